"""What one transaction says, as 16-bit words; the tables in docs/rig-wires.md are those of this module.

The transaction's number goes before them: in a register of its own, or in a frame's head.
"""

from collections.abc import Sequence
from math import floor, isfinite
from typing import NamedTuple, Self

import numpy as np

from layflat.errors import LayflatError
from layflat.machine.model import Machine
from layflat.machine.parameters import drive_parts, joints
from layflat.physics.sensor import Sensor
from layflat.rig.driver import Command, DeviceState, Reading

WORD = 16  # bits
ROUND = 1 << WORD  # numbers of transactions go round, so that "later" means less than half a round ahead
AIR, RESET, OUTPUTS = 1, 2, 8  # of a command's flags: two bits, and where those of the outputs begin
STATE, STOPPED = 3, 4  # bits of a reading's flags: two of the device's state, one of the e-stop


class WireError(LayflatError):
    """Words that nobody who keeps to docs/rig-wires.md sends."""


def following(number: int) -> int:
    """The number of the transaction after this one."""
    return (number + 1) % ROUND


def is_later(number: int, last: int | None) -> bool:
    """Whether a number is neither the last one heard nor an older one; any number does at first."""
    return last is None or 0 < (number - last) % ROUND < ROUND // 2


class Converter(NamedTuple):
    """A count c stands for low + lsb c; c goes from 0 to `top`, which belongs to it."""

    low: float
    lsb: float
    top: int

    @classmethod
    def of_sensor(cls, sensor: Sensor) -> Self:
        """Counts as `read_sensor` makes them: both ends of the range are among them."""
        return cls(sensor.low, sensor.lsb, round((sensor.high - sensor.low) / sensor.lsb))

    @property
    def words(self) -> int:
        """Words that a count takes."""
        return 1 if self.top < ROUND else 2

    def count(self, value: float) -> int:
        """Count nearest to a value, within the range."""
        inside = min(max(value, self.low), self.value(self.top))
        return floor((inside - self.low) / self.lsb + 0.5)

    def value(self, count: int) -> float:
        """What a count stands for: bit for bit what `read_sensor` says of it."""
        return self.low + self.lsb * count

    def put(self, words: list[int], value: float) -> None:
        """Append a value's count, high word first."""
        words += divmod(self.count(value), ROUND)[-self.words :]

    def take(self, words: Sequence[int], at: int) -> float:
        """The value whose count begins at a place among words; raise WireError if the converter has no such count."""
        count = words[at] if self.words == 1 else words[at] << WORD | words[at + 1]
        if count > self.top:
            raise WireError(f"count {count} of a converter that ends at {self.top}")
        return self.value(count)


class Wire(NamedTuple):
    """Converters of a rig, and the words that they make of commands and readings."""

    joints: int  # how many there are
    centre: int  # count of the voltage that closes the valves
    voltage: Converter  # of the valves' drivers; its top count is one short of the range, as in any such converter
    angle: Converter
    pressure: Converter  # differential
    supply: Converter  # absolute
    outputs: int = 0  # digital ones, that commands switch

    @classmethod
    def of(cls, machine: Machine) -> Self:
        """Converters of a machine; raise MachineError if it has no valve or sensors."""
        valve, _, _ = drive_parts(machine)
        first, own, ambient = joints(machine)[0], machine.interface, machine.supply.ambient_pressure
        counts, low = 2**own.voltage_bits, valve.centre_voltage - valve.volts_to_full
        lsb = own.supply_range_gauge / 2**own.supply_bits
        return cls(
            len(machine.joints),
            counts // 2,
            Converter(low, 2 * valve.volts_to_full / counts, counts - 1),
            Converter.of_sensor(first.angle_sensor),
            Converter.of_sensor(first.pressure_sensor),
            Converter.of_sensor(Sensor(ambient, ambient + own.supply_range_gauge, lsb, 0.0, 0.0)),
            len(own.outputs),
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
        """A command on the wire; voltages end at the ends of the range, and what is not a number is the centre."""
        voltage = self.voltage
        counts = [voltage.count(v) if isfinite(v) else self.centre for v in command.voltages.tolist()]
        return [AIR * command.air | RESET * command.reset | command.outputs << OUTPUTS, *counts]

    def command(self, words: Sequence[int]) -> Command:
        """The command that words say; raise WireError if they are no command."""
        _check(words, self.command_size, AIR | RESET | ((1 << self.outputs) - 1) << OUTPUTS)
        voltages, flags = np.array([self.voltage.take(words, i) for i in range(1, len(words))]), words[0]
        return Command(voltages, air=bool(flags & AIR), reset=bool(flags & RESET), outputs=flags >> OUTPUTS)

    def reading_words(self, reading: Reading) -> list[int]:
        """A reading on the wire."""
        words = [reading.device | STOPPED * reading.stopped]
        self.supply.put(words, reading.supply)
        for angle, pressure in zip(reading.angles.tolist(), reading.pressures.tolist(), strict=True):
            self.angle.put(words, angle)
            self.pressure.put(words, pressure)
        return words

    def reading(self, words: Sequence[int]) -> Reading:
        """The reading that words say; raise WireError if they are no reading."""
        _check(words, self.reading_size, STATE | STOPPED)
        flags, each, pair = words[0], self.angle.words, self.angle.words + self.pressure.words
        if flags & STATE > DeviceState.DUMPED:
            raise WireError(f"flags {flags:#06x}, which mean nothing")
        starts = range(1 + self.supply.words, len(words), pair)
        angles = np.array([self.angle.take(words, i) for i in starts])
        pressures = np.array([self.pressure.take(words, i + each) for i in starts])
        supply = self.supply.take(words, 1)
        return Reading(angles, pressures, supply, bool(flags & STOPPED), DeviceState(flags & STATE))


def _check(words: Sequence[int], size: int, flags: int) -> None:
    """Refuse words of another number, and other flags than these."""
    if len(words) != size:
        raise WireError(f"{len(words)} words; this rig's have {size}")
    if words[0] & ~flags:
        raise WireError(f"flags {words[0]:#06x}, which mean nothing")
