"""What one transaction says, as 16-bit words; the tables in docs/rig-wires.md are those of this module.

The transaction's number goes before them: in a register of its own, or in a frame's head.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import isfinite

import numpy as np

from layflat.machine.model import Machine
from layflat.machine.parameters import drive_parts, joints
from layflat.physics.sensor import Sensor
from layflat.rig.driver import Command, DeviceState, Reading
from layflat.rig.wire.converter import Converter, WireError

AIR, RESET = 1, 2
"""Bits of a command's flags."""
STATE, STOPPED = 3, 4
"""Bits of a reading's flags: two of the device's state, one of the e-stop."""


@dataclass(frozen=True)
class Wire:
    """Converters of a rig, and the words that they make of commands and readings.

    Args:
        joints: how many there are.
        centre: count of the voltage that closes the valves.
        voltage: of the valves' drivers; its top count is one short of the range, as in any such converter.
        angle: of every joint.
        pressure: of every joint, differential.
        supply: absolute.
    """

    joints: int
    centre: int
    voltage: Converter
    angle: Converter
    pressure: Converter
    supply: Converter

    @classmethod
    def of(cls, machine: Machine) -> Wire:
        """Converters of a machine.

        Raises:
            MachineError: it has no valve or sensors.
        """
        valve, _, _ = drive_parts(machine)
        first = joints(machine)[0]
        own, ambient = machine.interface, machine.supply.ambient_pressure
        counts = 2**own.voltage_bits
        low, steps = valve.centre_voltage - valve.volts_to_full, 2**own.supply_bits
        supply = Sensor(ambient, ambient + own.supply_range_gauge, own.supply_range_gauge / steps, 0.0, 0.0)
        return cls(
            len(machine.joints),
            counts // 2,
            Converter(low, 2 * valve.volts_to_full / counts, counts - 1),
            Converter.of_sensor(first.angle_sensor),
            Converter.of_sensor(first.pressure_sensor),
            Converter.of_sensor(supply),
        )

    @property
    def command_size(self) -> int:
        """Words of a command."""
        return 1 + self.joints

    @property
    def reading_size(self) -> int:
        """Words of a reading."""
        return 1 + self.supply.words + self.joints * (self.angle.words + self.pressure.words)

    def command_words(self, command: Command) -> list[int]:
        """A command on the wire; voltages end at the ends of the range, and what is no number is the centre."""
        voltage = self.voltage
        counts = [voltage.count(v) if isfinite(v) else self.centre for v in command.voltages.tolist()]
        return [AIR * command.air + RESET * command.reset, *counts]

    def command(self, words: Sequence[int]) -> Command:
        """The command that words say.

        Raises:
            WireError: they are no command.
        """
        if len(words) != self.command_size:
            raise WireError(f"a command of {len(words)} words; this rig's have {self.command_size}")
        flags, *counts = words
        if flags & ~(AIR | RESET):
            raise WireError(f"flags {flags:#06x}, of which only 1 (air) and 2 (reset) mean anything")
        if max(counts) > self.voltage.top:
            raise WireError(f"voltage's count {max(counts)} of a converter that ends at {self.voltage.top}")
        voltages = np.array([self.voltage.value(count) for count in counts])
        return Command(voltages, air=bool(flags & AIR), reset=bool(flags & RESET))

    def reading_words(self, reading: Reading) -> list[int]:
        """A reading on the wire."""
        words = [reading.device | STOPPED * reading.stopped]
        self.supply.put(words, reading.supply)
        for angle, pressure in zip(reading.angles.tolist(), reading.pressures.tolist(), strict=True):
            self.angle.put(words, angle)
            self.pressure.put(words, pressure)
        return words

    def reading(self, words: Sequence[int]) -> Reading:
        """The reading that words say.

        Raises:
            WireError: they are no reading.
        """
        if len(words) != self.reading_size:
            raise WireError(f"a reading of {len(words)} words; this rig's have {self.reading_size}")
        flags = words[0]
        if flags & ~(STATE | STOPPED) or flags & STATE > DeviceState.DUMPED:
            raise WireError(f"flags {flags:#06x}, which mean nothing")
        supply = self.supply.take(words, 1)
        at, each, pair = 1 + self.supply.words, self.angle.words, self.angle.words + self.pressure.words
        starts = range(at, len(words), pair)
        angles = np.array([self.angle.take(words, i) for i in starts])
        pressures = np.array([self.pressure.take(words, i + each) for i in starts])
        return Reading(angles, pressures, supply, bool(flags & STOPPED), DeviceState(flags & STATE))
