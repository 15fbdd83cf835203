"""Does what a driver found fit the machine?"""

from __future__ import annotations

from layflat.errors import InputError
from layflat.machine import Machine
from layflat.machine.parameters import drive_parts
from layflat.rig.driver import Capabilities


def check_capabilities(machine: Machine, found: Capabilities) -> None:
    """Make sure that a driver fits a machine.

    Raises:
        InputError: it does not.
        MachineError: the machine has no valve or sensors.
    """
    valve, _, _ = drive_parts(machine)
    cycle = machine.controller.cycle if machine.controller is not None else 0.0
    low, high = valve.centre_voltage - valve.volts_to_full, valve.centre_voltage + valve.volts_to_full
    needed = f"the valves need {low:g} to {high:g} V"
    wrong = [
        (found.joints != len(machine.joints), f"it has {found.joints} joints, the machine {len(machine.joints)}"),
        (
            found.voltage_low > low or found.voltage_high < high,
            f"its voltages are {found.voltage_low:g} to {found.voltage_high:g} V, {needed}",
        ),
        (
            abs(found.centre_voltage - valve.centre_voltage) > 1e-3 * valve.volts_to_full,
            f"it falls back to {found.centre_voltage:g} V, the valves are closed at {valve.centre_voltage:g} V",
        ),
        (valve.dithered is not None and not found.dithers, "it does not add the dither"),
        (
            found.shortest_cycle > cycle,
            f"its shortest cycle is {1000 * found.shortest_cycle:g} ms, the controller's {1000 * cycle:g} ms",
        ),
    ]
    for is_so, what in wrong:
        if is_so:
            raise InputError(f"the device does not fit {machine.name!r}: {what}", where="driver")
