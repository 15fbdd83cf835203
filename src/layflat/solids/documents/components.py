"""Components of a machine's air and wires, with their tags: circuit, letter and number, as ISO 1219-2 has them.

Circuit 0 is the supply, circuit j joint j from base to tip. Letters: P source of air, V valve, A actuator, S sensor,
Z other.
"""

from math import degrees
from typing import NamedTuple, Self

from layflat.errors import MachineError
from layflat.machine import Machine
from layflat.machine.parameters import valve_and_sensors

VALVE_NAMES = {"spool": "5/3 proportional valve", "switching": "two 4/2 on/off valves"}
"""Valves that documents know, by kind."""
BAR, LITRE_PER_SECOND_BAR = 1e5, 1e-8  # Pa; m3/(s Pa)


class AirComponent(NamedTuple):
    """AirComponent of a machine's air or wires."""

    tag: str
    name: str
    rating: str = ""


class ValvePorts(NamedTuple):
    """Ports of a joint's valve, or pair of valves; those of a tuple but the exhausts are connected with each other."""

    inlets: tuple[str, ...]
    to_a: tuple[str, ...]
    to_b: tuple[str, ...]
    exhausts: tuple[str, ...]

    @classmethod
    def of_joint(cls, kind: str, number: int) -> Self:
        """Return the ports (ISO 11727) of the valve of a kind of a joint."""
        if kind == "switching":
            return cls(*(tuple(f"{number}V1{which}:{port}" for which in "ab") for port in (1, 4, 2, 3)))
        tag = f"{number}V1"
        return cls((f"{tag}:1",), (f"{tag}:4",), (f"{tag}:2",), (f"{tag}:5", f"{tag}:3"))


def supply_components(machine: Machine) -> list[AirComponent]:
    """Return the components of the supply, in the order of the air."""
    gauge, safety = machine.supply.pressure_gauge, machine.safety
    return [
        AirComponent("0P1", "compressed-air supply", f"at least {gauge / BAR + 1.0:g} bar, dry and oil-free"),
        AirComponent("0V1", "shut-off valve, by hand, lockable, vents the line"),
        AirComponent("0Z1", "filter with drain, pressure regulator and gauge", f"set to {gauge / BAR:g} bar"),
        AirComponent("0V2", "relief valve", f"opens by {max_supply_gauge(machine) / BAR:g} bar"),
        AirComponent("0V3", "3/2 dump valve, spring return, vents the line without current"),
        AirComponent("0V4", "soft-start valve (ISO 4414)", f"ready within {safety.start_time:g} s"),
        AirComponent("0Z2", "distributor of the supply line"),
        AirComponent("0S1", "pressure transducer", f"0 to {machine.interface.supply_range_gauge / BAR:g} bar gauge"),
    ]


def max_supply_gauge(machine: Machine) -> float:
    """Return the gauge pressure at which a relief valve has to open: that above which the rig stops, Pa."""
    return machine.safety.overpressure * machine.supply.pressure_gauge


def joint_components(machine: Machine, number: int) -> list[AirComponent]:
    """Return the components of a joint, number 1 for the first from the base.

    Raises:
        MachineError: no valve or sensors, or a valve of a kind that documents do not know.
    """
    (name, joint), (valve, angle, pressure) = list(machine.joints.items())[number - 1], valve_and_sensors(machine)
    if valve.kind not in VALVE_NAMES:
        right = f"documents know the kinds {' and '.join(VALVE_NAMES)}"
        raise MachineError(f"is {valve.kind!r}", where=f"{machine.origin}: valve.kind", right=right)
    conductance = joint.valve_size * valve.conductance / LITRE_PER_SECOND_BAR
    low, high = (f"{valve.centre_voltage + sign * valve.volts_to_full:g}" for sign in (-1, 1))
    flow = f"C = {conductance:.3g} l/(s bar), b = {valve.critical_ratio:g}, {low} to {high} V"
    half, span = 0.5 * pressure.range / BAR, 0.5 * degrees(angle.range)
    size = f"layflat, {1e3 * joint.hose.width:g} mm flat"
    parts = [
        AirComponent(f"{number}V1", VALVE_NAMES[valve.kind], flow),
        AirComponent(f"{number}A1", f"hose A of joint {name}, turns it forward", size),
        AirComponent(f"{number}A2", f"hose B of joint {name}, turns it back", size),
        AirComponent(f"{number}S1", "differential pressure transducer", f"-{half:g} to {half:g} bar"),
        AirComponent(f"{number}S2", "angle potentiometer", f"-{span:g} to {span:g} deg from mid-stroke"),
        AirComponent(f"{number}V2", "proportional pressure regulator", "0 to 10 V"),
        AirComponent(f"{number}V3", "proportional pressure regulator of the calliper", "0 to 10 V"),
        AirComponent(f"{number}A3", "brake calliper, spring return", f"brake slips at {joint.brake.torque:g} N m"),
    ]
    missing = {
        f"{number}A2": joint.acting == "single",
        f"{number}V2": joint.regulator is None,
        f"{number}V3": joint.brake.calliper is None,
        f"{number}A3": joint.brake.calliper is None,
    }
    return [part for part in parts if not missing.get(part.tag, False)]


def list_components(machine: Machine) -> list[AirComponent]:
    """Return all components of a machine's air and its sensors; errors as from `joint_components`."""
    joints = [part for number in range(1, len(machine.joints) + 1) for part in joint_components(machine, number)]
    return [*supply_components(machine), *joints]
