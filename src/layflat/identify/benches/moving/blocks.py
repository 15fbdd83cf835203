"""What can be fitted of a machine from motion and pressures, block by block, and how far around the description."""

from collections.abc import Sequence

from layflat.errors import InputError
from layflat.identify.benches.contract import check_known
from layflat.identify.benches.moving.links import MASSES, links
from layflat.identify.unknown import ParameterSpec, Unknown, around, factor_range, fixed_range, from_zero
from layflat.machine import Machine
from layflat.physics.delay import LONGEST
from layflat.physics.friction.stribeck import StribeckPart
from layflat.physics.valves.switching import SwitchingValvesPart

FILLING = "steps large enough to open the valve fully, both ways"
SLOW = "slow ramps over the stroke, both ways"
CENTRE = "small motions about the valve's centre"
PAUSES = "pauses of seconds"
SAMPLED = "steps, with the pressure sampled every few milliseconds"

DELAYS = from_zero(lambda machine, _: LONGEST * machine.cycle)
OFFSETS = around(lambda machine: 0.02 * machine.pressure_sensor.range)

VALVE = (
    ParameterSpec("valve.conductance", "m^3/(s Pa)", factor_range(3.0), FILLING),
    ParameterSpec("valve.critical_ratio", "1", fixed_range(0.05, 0.9), "filling from low pressure and venting to it"),
    ParameterSpec("valve.leakage", "m^3/(s Pa)", factor_range(20.0, 1e-9), PAUSES),
    ParameterSpec("valve.centre_voltage", "V", around(lambda machine: 0.2 * machine.valve.volts_to_full), PAUSES),
    ParameterSpec("valve.volts_to_full", "V", factor_range(2.0), "voltages beyond full opening"),
    ParameterSpec("valve.delay", "s", DELAYS, "steps, and chirps up to 3 Hz"),
)
SPOOL = (
    ParameterSpec("valve.overlap", "1", fixed_range(0.0, 0.3), CENTRE),
    ParameterSpec("valve.natural_frequency", "Hz", factor_range(4.0), SAMPLED),
)
SWITCHING = (
    ParameterSpec("valve.dead_band", "1", fixed_range(0.0, 0.3), CENTRE),
    ParameterSpec("valve.opening_delay", "s", factor_range(3.0), "pulses of all lengths"),
    ParameterSpec("valve.closing_delay", "s", factor_range(3.0), "pulses of all lengths"),
)
HOSE = (
    ParameterSpec("hose.torque_factor", "1", factor_range(2.0), "fast moves with a known payload, and without"),
    ParameterSpec("hose.dead_volume", "m^3", factor_range(3.0), FILLING),
    ParameterSpec("hose.compliance", "m^3/Pa", factor_range(10.0, 1e-10), "filling from low pressure"),
    ParameterSpec("hose.wall_conductance", "W/K", factor_range(10.0, 10.0), "fast filling, then pauses of seconds"),
)
LOSSES = (
    ParameterSpec("hose.loss_share", "1", factor_range(3.0, 0.5, most=1.0), SLOW),
    ParameterSpec("losses.pressure_free", "1", fixed_range(0.0, 1.0), f"{SLOW}, at two supply pressures"),
    ParameterSpec("losses.deflections.0", "rad", factor_range(5.0), "small motions to and fro"),
    ParameterSpec("losses.deflections.1", "rad", factor_range(5.0), "motions of a few degrees to and fro"),
    ParameterSpec("losses.deflections.2", "rad", factor_range(4.0), "slow ramps of several sizes"),
)
FRICTION = (
    ParameterSpec("brake.torque", "N m", factor_range(5.0, 5.0), SLOW),
    ParameterSpec("brake.viscous", "N m s/rad", factor_range(20.0, 1.0), "chirps up to 3 Hz"),
)
STRIBECK = (
    ParameterSpec("friction.static_ratio", "1", fixed_range(1.0, 3.0), f"{SLOW}, with pauses"),
    ParameterSpec("friction.velocity", "rad/s", factor_range(10.0), f"{SLOW}, with pauses"),
    ParameterSpec("friction.load_share", "1", fixed_range(0.0, 0.3), f"{SLOW}, at two supply pressures"),
)
LINE = (
    ParameterSpec("line.length", "m", factor_range(3.0), f"{FILLING}, and chirps up to 3 Hz"),
    ParameterSpec("line.bore", "m", factor_range(2.0), FILLING),
)
INERTIA = (ParameterSpec("link.inertia", "kg m^2", MASSES, "chirps up to 3 Hz without payload"),)
PAYLOAD = ParameterSpec("arm.payload", "kg", from_zero(lambda _, guess: max(3.0 * guess, 2.0)), "chirps up to 3 Hz")
SENSORS = ParameterSpec("pressure_sensor.offset", "Pa", OFFSETS, "both pressures by themselves")

BY_JOINT = {"hose": HOSE, "losses": LOSSES, "friction": FRICTION, "inertia": INERTIA}
BLOCKS = ("valve", *BY_JOINT, "line", "payload", "sensors")  # what `--fit` takes for a machine that moves


def unknowns(machine: Machine, blocks: Sequence[str]) -> list[Unknown]:
    """What is to be fitted of a machine; raise InputError if there is no such block, or none is given."""
    if not blocks:
        raise InputError("names no block", where="fit", right=f"choose from {', '.join(BLOCKS)}")
    of_kind = SWITCHING if isinstance(machine.valve, SwitchingValvesPart) else SPOOL
    specs = {"valve": [*VALVE, *of_kind], "payload": [PAYLOAD], "sensors": [SENSORS]}
    for block, of in BY_JOINT.items():
        specs[block] = [
            spec._replace(path=f"joint.{name}.{spec.path}")
            for name, joint in machine.joints.items()
            for spec in (*of, *(STRIBECK if block == "friction" and isinstance(joint.friction, StribeckPart) else ()))
        ]
    if machine.arm.own_links:
        specs["inertia"] = links(machine)
    specs["line"] = _of_lines(machine)
    if "line" in blocks and not specs["line"]:
        raise InputError("has no line", where=machine.origin, right="describe its [line], or leave line out of --fit")
    return [spec.unknown(machine) for block in check_known(blocks, BLOCKS, "fit", "block") for spec in specs[block]]


def _of_lines(machine: Machine) -> list[ParameterSpec]:
    """The machine's own line, which all joints without theirs share, then those of joints."""
    shared = machine.line is not None and any(joint.line is None for joint in machine.joints.values())
    own = [f"joint.{name}." for name, joint in machine.joints.items() if joint.line is not None]
    return [spec._replace(path=f"{at}{spec.path}") for at in ([""] if shared else []) + own for spec in LINE]
