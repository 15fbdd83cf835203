"""Sheet of a first start: measurements by hand, then the checks of `layflat rig check`, with their limits.

The checks have the names, the order and the limits of `rig/check.py` and `rig/signs.py`.
"""

from math import degrees, floor, radians
from shlex import quote
from typing import NamedTuple

from layflat.machine import Machine
from layflat.machine.parameters import sensor, valve_and_sensors
from layflat.physics.sensor import Sensor
from layflat.plot import render_page
from layflat.rig import check, signs
from layflat.rig.abilities import falls_without_air, resting_angles
from layflat.rig.driver import Capabilities
from layflat.rig.safety.detectors import DetectorLimits
from layflat.rig.safety.limits import detector_limits
from layflat.solids.documents.components import BAR, max_supply_gauge
from layflat.solids.documents.pins import ADC_REFERENCE, AIR_GPIO, STOP_GPIO, BoardPins

HAND_ANGLE = radians(1.0)  # to which a joint is set by hand
VOLTAGE_TOLERANCE = 0.01  # of the valves' full voltage
LOGIC_LEVELS = 0.8, 2.0  # V: highest low and lowest high level of a Pico's input


class SheetRow(NamedTuple):
    """Check of a sheet: its name, the action, and the expected reading with unit and tolerance."""

    check: str
    action: str
    expected: str


class SheetSection(NamedTuple):
    """Section of a sheet; its rows are numbered after its letter."""

    letter: str
    title: str
    text: str
    rows: list[SheetRow]
    air: bool | None = None  # whether `layflat rig check` tries the air, too; None: it is not run


def commissioning_sheet(machine: Machine) -> str:
    """Return the sheet of a machine's first start as HTML to be printed and filled in.

    Raises:
        MachineError: the machine has no valve or sensors, or more joints than the firmware has pins.
    """
    by_hand = "Power on, air shut off at 0V1 and hoses empty, no program on the host. Measure against 0 V of the board."
    with_air = "Nobody within the arm's reach, e-stop in hand; joints move by some degrees."
    sections = [
        SheetSection("A", "By hand", by_hand, rows_by_hand(machine)),
        SheetSection("B", "Without air", "Air shut off.", rows_without_air(machine), air=False),
        SheetSection("C", "With air", with_air, rows_with_air(machine), air=True),
    ]
    template, name = "commissioning.html.j2", quote(machine.origin)
    return render_page("layflat.solids.documents", template, machine=machine, name=name, sections=sections)


def rows_by_hand(machine: Machine) -> list[SheetRow]:
    """Return the measurements with a voltmeter before the first check; errors as from `commissioning_sheet`."""
    pins, (valve, angle, pressure) = BoardPins.for_machine(machine), valve_and_sensors(machine)
    gauge, low, high = machine.supply.pressure_gauge / BAR, *LOGIC_LEVELS
    rest = valve.centre_voltage + (0.0 if falls_without_air(machine) else valve.volts_to_full)
    pressure_error = ADC_REFERENCE * check.MAX_VENTED_PRESSURE / pressure.range
    supply_error = ADC_REFERENCE * check.MAX_VENTED_PRESSURE / machine.interface.supply_range_gauge
    accepted = f"{machine.safety.supply_ready * gauge:.2f} to {max_supply_gauge(machine) / BAR:.2f} bar are accepted"
    rows = [
        SheetRow("e-stop", f"press it, then release it: GP{STOP_GPIO}", f"below {low:g} V, then above {high:g} V"),
        SheetRow("dump valve", f"GP{AIR_GPIO}, and the coil of 0V3, before the host commands", f"below {low:g} V; 0 V"),
        SheetRow("regulator", "open 0V1, set 0Z1; shut 0V1 again", f"{gauge:g} bar; {accepted}"),
        SheetRow("supply sensor", f"converter channel {pins.supply}", f"0 V +- {1e3 * supply_error:.0f} mV"),
    ]
    middle, slope = 0.5 * ADC_REFERENCE, ADC_REFERENCE / angle.range
    tolerance = f"+- {1e3 * slope * HAND_ANGLE:.0f} mV"
    for j, (name, joint) in enumerate(machine.joints.items()):
        stop = middle + slope * 0.5 * joint.stops.mechanical_stroke
        command = f"command at {j + 1}V1 (GP{pins.valves[j]}), 1 s after power on"
        by_hand = f"channel {pins.angles[j]}, in mid-stroke by hand, then at the stop to which hose A turns it"
        rows += [
            SheetRow(f"valve of {name}", command, f"{rest:g} V +- {VOLTAGE_TOLERANCE * valve.volts_to_full:g} V"),
            SheetRow(f"angle of {name}", by_hand, f"{middle:.2f} V {tolerance}, then {stop:.2f} V {tolerance}"),
            SheetRow(
                f"pressure of {name}",
                f"channel {pins.pressures[j]}",
                f"{middle:.2f} V +- {1e3 * pressure_error:.0f} mV",
            ),
        ]
    return rows


def rows_without_air(machine: Machine) -> list[SheetRow]:
    """Return the checks of `layflat rig check` without air, in its order; MachineError without valve or sensors."""
    requests = round(check.CHECK_DURATION / machine.cycle)
    lost = floor(check.MAX_LOST_FRACTION * requests)
    within = f"of {requests} in {check.CHECK_DURATION:g} s"
    bar = check.MAX_VENTED_PRESSURE / BAR
    rows = [
        SheetRow("device", "read", check.describe_device(Capabilities.required_by(machine))),
        SheetRow("link", "read the good replies", f"at least {requests - lost} {within}"),
        SheetRow("cycles", "read the missed cycles", f"at most {lost} {within}"),
        SheetRow("e-stop", "release it before", "released"),
        SheetRow("supply", "read", f"0 bar gauge +- {bar:g} bar"),
    ]
    ends = resting_angles(machine)
    for j, name in enumerate(machine.joints):
        limits = detector_limits(machine, name)
        rows += [_angle_row(machine, name, float(ends[j]), limits), _pressure_row(machine, name, limits)]
    return rows


def rows_with_air(machine: Machine) -> list[SheetRow]:
    """Return the checks of `layflat rig check --air`, in its order; MachineError without valve or sensors."""
    valve_and_sensors(machine)
    ready = machine.safety.supply_ready * machine.supply.pressure_gauge / BAR
    rows = [SheetRow("air", "open 0V1; read the time", f"{ready:g} bar gauge within {machine.safety.start_time:g} s")]
    angle, pressure = degrees(signs.MAX_TEST_ANGLE / 2), signs.MIN_PRESSURE_RESPONSE / BAR
    for name, joint in machine.joints.items():
        forward, back = (f"{sign}{pressure:g} bar and {sign}{angle:g} deg or more" for sign in "+-")
        back = back if joint.acting == "double" else "nothing, or as much"
        expected = f"opened forward: {forward}; opened back: {back}"
        rows.append(SheetRow(f"signs of {name}", "stand clear; read both responses", expected))
    return rows


def _angle_row(machine: Machine, name: str, end: float, limits: DetectorLimits) -> SheetRow:
    """Return the check of the angle sensor of a joint that may rest up to an angle (rad) from mid-stroke."""
    described, top = sensor(valve_and_sensors(machine)[1]), degrees(min(end, limits.rail.high))
    lower = check.MIN_NOISE_RATIO * described.noise / described.lsb if limits.angle_frozen.noisy > 0.0 else 0.0
    expected = f"-{top:.1f} to {top:.1f} deg, as it rests; {_noise_text(described, lower)}"
    return SheetRow(f"angle of {name}", "do not touch the joint", expected)


def _pressure_row(machine: Machine, name: str, limits: DetectorLimits) -> SheetRow:
    """Return the check of the differential pressure of a joint."""
    bar = min(check.MAX_VENTED_PRESSURE, limits.over_pressure) / BAR
    noise = _noise_text(sensor(valve_and_sensors(machine)[2]))
    return SheetRow(f"pressure of {name}", "hoses empty", f"0 bar +- {bar:g} bar; {noise}")


def _noise_text(described: Sensor, lower: float = 0.0) -> str:
    """Return the accepted noise in counts; readings of a sensor that changes at rest must not all be equal."""
    changes = lower == 0.0 and described.noise > check.MIN_CHANGING_NOISE * described.lsb
    start = f"{lower:.2f} to " if lower > 0.0 else "above 0, at most " if changes else "at most "
    return f"noise {start}{check.max_noise(described) / described.lsb:.1f} counts"
