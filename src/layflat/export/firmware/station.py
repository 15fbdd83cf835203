"""Settings of a machine's device in C: what its host expects, as the struct of `device/station.h`."""

from math import pi, sin
from pathlib import Path

from layflat.machine import Machine
from layflat.machine.parameters import valve_and_sensors
from layflat.rig.abilities import falls_without_air
from layflat.rig.device.virtual import LINE_EMPTY_TIME
from layflat.rig.wire import OUTPUTS_SHIFT, Identity

DEVICE_FOLDER = Path(__file__).parent / "device"  # sources in C
WAVE_STEPS = 32  # of a period of the dither
CYCLES_PER_DITHER = 4  # control cycles in a period of the dither, which the control laws average


def station_settings(machine: Machine) -> str:
    """Return the source file with the settings of a machine's device.

    Raises:
        MachineError: the machine has no valve, sensors or controller, or does not fit the wire.
    """
    identity, (valve, _, _) = Identity.for_machine(machine), valve_and_sensors(machine)
    half = 2**identity.voltage_bits / 2 * (valve.dithered.amplitude if valve.dithered is not None else 0.0)
    wave = [round(half * sin(2 * pi * i / WAVE_STEPS)) for i in range(WAVE_STEPS)]
    names = "joints", "voltage_bits", "angle_bits", "pressure_bits", "supply_bits"
    volts = "voltage_low", "voltage_high", "centre_voltage"
    fields = {name: str(getattr(identity, name)) for name in (*names, *volts)} | {
        "centres_after": f"{1000 * identity.centres_after}u",
        "dumps_after": f"{1000 * identity.dumps_after}u",
        "empties_after": f"{LINE_EMPTY_TIME // 1000}u",
        "lets_down": str(int(falls_without_air(machine))),
        "shortest_cycle": str(identity.shortest_cycle),
        "dither_period": f"{round(1e6 * CYCLES_PER_DITHER * machine.cycle)}u",
        "dither": f"{{{', '.join(map(str, wave))}}}",
        "outputs": str(identity.flags >> OUTPUTS_SHIFT),
    }
    lines = [f"    .{name} = {value}," for name, value in fields.items()]
    head = ['#include "station.h"', "", "extern const station_settings machine_station;"]
    return "\n".join([*head, "const station_settings machine_station = {", *lines, "};", ""])
