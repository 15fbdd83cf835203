"""Content of one transaction, as 16-bit words; the tables in docs/rig-wires.md are those of this module.

The transaction's number precedes them: in a register of its own, or in a frame's header. The identity of a device is
read before anything moves, and compared with the machine.
"""

import struct
from collections.abc import Sequence
from math import floor, isfinite
from typing import NamedTuple, Self

import numpy as np

from layflat.errors import LayflatError, MachineError
from layflat.machine.model import Machine
from layflat.machine.parameters import joints, valve_and_sensors
from layflat.physics.sensor import Sensor
from layflat.rig.device_state import DeviceState
from layflat.rig.driver import Capabilities, DriverError, RigCommand, SensorReading

WORD_BITS = 16
SEQUENCE_MODULUS = (
    1 << WORD_BITS
)  # numbers of transactions go round, so that "later" means less than half a round ahead
AIR_FLAG, RESET_FLAG = 1, 2  # of the flags of a command
OUTPUTS_SHIFT = 8  # bit of the flags at which digital outputs begin: states of a command, their number of an identity
STATE_MASK, STOPPED_FLAG = 3, 4  # bits of a reading's flags: two of the device's state, one of the e-stop
IDENTITY_MAGIC = 0x4C46  # nothing else that answers is taken for a rig
VERSION = 1
LAW_VERSION = 2  # of a device that runs the control law itself: a digest takes the place of the watchdog's times
MAX_WORD = 0xFFFF  # the most that a word carries
DITHERS_FLAG, LETS_DOWN_FLAG = 1, 2  # of the flags of an identity
_WIRE_TIMES = {
    "shortest cycle": "rigs have cycles up to 65 ms: make controller.cycle shorter",
    "watchdog": "up to 65 s: make interface.watchdog_cycles or controller.cycle smaller",
    "time until it dumps": "up to 65 s: make interface.dump_after smaller",
}
"""Times of a machine that go over the wire, with what would be right."""
_IDENTITY_TEXTS = {
    "joints": "{} joint(s)",
    "voltage_low": "voltages from {} mV on",
    "voltage_high": "voltages up to {} mV",
    "centre_voltage": "its centre at {} mV",
    "voltage_bits": "voltages of {} bits",
    "angle_bits": "angles of {} bits",
    "pressure_bits": "pressures of {} bits",
    "supply_bits": "a supply of {} bits",
    "centres_after": "a watchdog of {} ms",
    "dumps_after": "{} ms until it dumps",
}


class WireError(LayflatError):
    """Words that violate the protocol of docs/rig-wires.md."""


def next_sequence(number: int) -> int:
    """Return the number of the transaction after this one: 0 after 65535."""
    return (number + 1) % SEQUENCE_MODULUS


def is_later(number: int, last: int | None) -> bool:
    """Return whether a transaction's number comes after the last one; any does where there is none yet (None)."""
    return last is None or 0 < (number - last) % SEQUENCE_MODULUS < SEQUENCE_MODULUS // 2


class Converter(NamedTuple):
    """Linear converter: a count c, from 0 to `top` inclusive, stands for the value low + lsb c."""

    low: float  # value of count 0
    lsb: float  # value of one count
    top: int  # greatest count

    @classmethod
    def of_sensor(cls, sensor: Sensor) -> Self:
        """Return the converter of a sensor, with the counts of `read_sensor`: both ends of the range included."""
        return cls(sensor.low, sensor.lsb, round((sensor.high - sensor.low) / sensor.lsb))

    @property
    def words(self) -> int:
        """Return the number of words of a count, 1 or 2."""
        return 1 if self.top < SEQUENCE_MODULUS else 2

    def count(self, value: float) -> int:
        """Return the count nearest to a value, clipped to the range."""
        inside = min(max(value, self.low), self.value(self.top))
        return floor((inside - self.low) / self.lsb + 0.5)

    def value(self, count: int) -> float:
        """Return the quantity of a count: bit for bit what `read_sensor` reports."""
        return self.low + self.lsb * count

    def append_count(self, words: list[int], value: float) -> None:
        """Append a value's count, high word first."""
        words += divmod(self.count(value), SEQUENCE_MODULUS)[-self.words :]

    def take(self, words: Sequence[int], at: int) -> float:
        """Return the value whose count begins at index `at` of words; raise WireError if the count exceeds `top`."""
        count = words[at] if self.words == 1 else words[at] << WORD_BITS | words[at + 1]
        if count > self.top:
            raise WireError(f"count {count} where this rig's converter goes from 0 to {self.top}")
        return self.value(count)


class Wire(NamedTuple):
    """Encoding of a rig's commands and readings as words, by its converters."""

    joints: int  # number of joints
    centre: int  # count of the voltage that closes the valves
    voltage: Converter  # of the valves' drivers; its top count is one short of the range, as in any such converter
    angle: Converter
    pressure: Converter  # differential
    supply: Converter  # absolute
    outputs: int = 0  # number of digital outputs

    @classmethod
    def for_machine(cls, machine: Machine) -> Self:
        """Return the encoding for a machine; raise MachineError if it has no valve or sensors."""
        valve, _, _ = valve_and_sensors(machine)
        first, interface, ambient = joints(machine)[0], machine.interface, machine.supply.ambient_pressure
        counts, low = 2**interface.voltage_bits, valve.centre_voltage - valve.volts_to_full
        lsb = interface.supply_range_gauge / 2**interface.supply_bits
        return cls(
            len(machine.joints),
            counts // 2,
            Converter(low, 2 * valve.volts_to_full / counts, counts - 1),
            Converter.of_sensor(first.angle_sensor),
            Converter.of_sensor(first.pressure_sensor),
            Converter.of_sensor(Sensor(ambient, ambient + interface.supply_range_gauge, lsb, 0.0, 0.0)),
            len(interface.outputs),
        )

    @property
    def command_size(self) -> int:
        """Return the number of words of a command."""
        return 1 + self.joints

    @property
    def reading_size(self) -> int:
        """Return the number of words of a reading."""
        return 1 + self.supply.words + self.joints * (self.angle.words + self.pressure.words)

    def command_words(self, command: RigCommand) -> list[int]:
        """Return a command as words; voltages are clipped to the range, and those that are not finite are centred."""
        voltage = self.voltage
        counts = [voltage.count(v) if isfinite(v) else self.centre for v in command.voltages.tolist()]
        return [AIR_FLAG * command.air | RESET_FLAG * command.reset | command.outputs << OUTPUTS_SHIFT, *counts]

    def command(self, words: Sequence[int]) -> RigCommand:
        """Return the command of words; raise WireError if they are no command."""
        _check_words(words, self.command_size, AIR_FLAG | RESET_FLAG | ((1 << self.outputs) - 1) << OUTPUTS_SHIFT)
        voltages, flags = np.array([self.voltage.take(words, i) for i in range(1, len(words))]), words[0]
        return RigCommand(
            voltages, air=bool(flags & AIR_FLAG), reset=bool(flags & RESET_FLAG), outputs=flags >> OUTPUTS_SHIFT
        )

    def reading_words(self, reading: SensorReading) -> list[int]:
        """Return a reading as words of 16 bits: device state and e-stop, supply, each joint's angle and pressure."""
        words = [reading.device | STOPPED_FLAG * reading.stopped]
        self.supply.append_count(words, reading.supply)
        for angle, pressure in zip(reading.angles.tolist(), reading.pressures.tolist(), strict=True):
            self.angle.append_count(words, angle)
            self.pressure.append_count(words, pressure)
        return words

    def reading(self, words: Sequence[int]) -> SensorReading:
        """Return the reading of words; raise WireError if they are no reading."""
        _check_words(words, self.reading_size, STATE_MASK | STOPPED_FLAG)
        flags, each, pair = words[0], self.angle.words, self.angle.words + self.pressure.words
        if flags & STATE_MASK > DeviceState.DUMPED:
            raise WireError(f"flags {flags:#06x}, whose device state is not 0, 1 or 2")
        starts = range(1 + self.supply.words, len(words), pair)
        angles = np.array([self.angle.take(words, i) for i in starts])
        pressures = np.array([self.pressure.take(words, i + each) for i in starts])
        supply = self.supply.take(words, 1)
        return SensorReading(angles, pressures, supply, bool(flags & STOPPED_FLAG), DeviceState(flags & STATE_MASK))


def _check_words(words: Sequence[int], size: int, flags: int) -> None:
    """Check the number of words and that the first has no other flags than these; raise WireError."""
    if len(words) != size:
        raise WireError(f"{len(words)} words where this rig's messages have {size}")
    if words[0] & ~flags:
        raise WireError(f"flags {words[0]:#06x}, of which only {flags:#06x} may be set")


class Identity(NamedTuple):
    """Identity of a device, a word each: voltages in mV, the cycle in us, times without a command in ms."""

    magic: int
    version: int
    joints: int
    voltage_bits: int
    angle_bits: int
    pressure_bits: int
    supply_bits: int
    voltage_low: int
    voltage_high: int
    centre_voltage: int
    flags: int
    shortest_cycle: int
    centres_after: int
    dumps_after: int

    @classmethod
    def for_machine(cls, machine: Machine, able: Capabilities | None = None) -> Self:
        """Return the identity of a machine's device with its capabilities; default: those that the machine requires.

        Raises:
            MachineError: the machine has no valve, sensors or controller, or a voltage or time too large for the wire.
        """
        _, angle_sensor, pressure_sensor = valve_and_sensors(machine)
        if machine.controller is None:
            raise MachineError("has no controller", where=machine.origin, right="give a machine with a controller")
        joints, low, high, centre, dithers, cycle, lets_down, outputs = able or Capabilities.required_by(machine)
        if max(abs(low), abs(high)) > 32.0:
            raise MachineError(f"reaches from {low:g} to {high:g} V", where="valve", right="rigs have up to +-32 V")
        interface = machine.interface
        bits = interface.voltage_bits, angle_sensor.bits, pressure_sensor.bits, interface.supply_bits
        voltages = (round(1e3 * voltage) for voltage in (low, high, centre))
        times = (1e6 * cycle, 1e3 * interface.watchdog_cycles * machine.cycle, 1e3 * interface.dump_after)
        for (name, right), time in zip(_WIRE_TIMES.items(), times, strict=True):
            if not 0.0 < time < MAX_WORD + 0.5:
                raise MachineError(f"its {name} is too long for a rig's wire", where=machine.origin, right=right)
        flags = DITHERS_FLAG * dithers | LETS_DOWN_FLAG * lets_down | outputs << OUTPUTS_SHIFT
        return cls._make((IDENTITY_MAGIC, VERSION, joints, *bits, *voltages, flags, *map(round, times)))

    def words(self) -> list[int]:
        """Return the identity as words, negative numbers in two's complement.

        Raises:
            WireError: a number does not fit into a word.
        """
        for name, number in self._asdict().items():
            if not -MAX_WORD // 2 <= number <= MAX_WORD or (
                number < 0 and not name.endswith(("low", "high", "voltage"))
            ):
                raise WireError(f"{name} is {number}, which does not fit into a word")
        return [number & MAX_WORD for number in self]

    @property
    def runs_law(self) -> bool:
        """Return whether the device runs the control law and the supervisor itself."""
        return self.version == LAW_VERSION

    @property
    def digest(self) -> int:
        """Return the digest of the machine for which a device that runs the control law was made."""
        return self.centres_after << WORD_BITS | self.dumps_after

    @classmethod
    def from_words(cls, words: Sequence[int], versions: Sequence[int] = (VERSION,)) -> Self:
        """Return the identity of words; raise WireError if no rig sent them, or one of another protocol version."""
        if len(words) != IDENTITY_SIZE or words[0] != IDENTITY_MAGIC:
            raise WireError(f"the device that answers is not a rig of layflat's{_describe_slip(words)}")
        if words[1] not in versions:
            what = f"the rig speaks version {words[1]} of the protocol, layflat version {VERSION}: change its firmware"
            raise WireError(what)
        return cls(*struct.unpack("=7H3h4H", struct.pack("=14H", *words)))

    def check(self, machine: Machine, where: str) -> Capabilities:
        """Check that this is a machine's device; return the required capabilities with its own cycle and features.

        Args:
            machine: the machine.
            where: address of the device, for messages.

        Raises:
            DriverError: a number differs, or a capability is missing.
        """
        expected = Identity.for_machine(machine)
        for name, words in _IDENTITY_TEXTS.items():
            if self.runs_law and name.endswith("_after"):
                continue
            actual, required = getattr(self, name), getattr(expected, name)
            if actual != required:
                what = f"the rig has {words.format(actual)}, the machine {machine.name!r} {words.format(required)}"
                raise DriverError(what, where=where, right="give the description of this rig")
        needed = Capabilities.required_by(machine)
        if needed.dithers and not self.flags & DITHERS_FLAG:
            raise DriverError("the rig adds no dither", where=where, right="let its firmware add the dither")
        if needed.lets_down and not self.flags & LETS_DOWN_FLAG:
            what = "the rig opens the valves as it vents the air, and this arm would fall"
            raise DriverError(
                what, where=where, right="its device has to keep them centred (LETS_DOWN in its settings)"
            )
        outputs = self.flags >> OUTPUTS_SHIFT
        if outputs < needed.outputs:
            what = f"the rig has {outputs} digital output(s), the machine {machine.name!r} {needed.outputs}"
            raise DriverError(what, where=where, right="give the description of this rig")
        if self.shortest_cycle > 1e6 * machine.cycle:
            what = f"the rig needs {self.shortest_cycle} us a cycle, the machine's is {1e3 * machine.cycle:g} ms"
            raise DriverError(what, where=where, right="make controller.cycle longer")
        flags = {"dithers": bool(self.flags & DITHERS_FLAG), "lets_down": bool(self.flags & LETS_DOWN_FLAG)}
        return needed._replace(shortest_cycle=1e-6 * self.shortest_cycle, outputs=outputs, **flags)


IDENTITY_SIZE = len(Identity._fields)


def _describe_slip(words: Sequence[int]) -> str:
    """Return the likely mistake in words that are no identity, as the end of a message; empty where none is known."""
    if words and words[0] == int.from_bytes(IDENTITY_MAGIC.to_bytes(2, "big"), "little"):
        return ": the bytes of its words are swapped"
    if IDENTITY_MAGIC in words:
        return (
            f": its identity begins {words.index(IDENTITY_MAGIC)} registers later: interface.modbus.identity is too low"
        )
    return ": its registers are all 0" if words and not any(words) else ""


class Registers(NamedTuple):
    """Ranges of Modbus registers: commands are written, the others read; the first two begin with the number."""

    commands: range
    readings: range
    identity: range

    @classmethod
    def for_machine(cls, machine: Machine) -> Self:
        """Return the register map of a machine; raise MachineError if it is too long, or its read ranges overlap."""
        wire, link = Wire.for_machine(machine), machine.interface.modbus
        where = f"{machine.origin}: interface.modbus"
        sizes = {"commands": 1 + wire.command_size, "readings": 1 + wire.reading_size, "identity": IDENTITY_SIZE}
        for name, size in sizes.items():
            start, last = getattr(link, name), 0x10000 - size
            if start > last:
                what = f"{size} registers from {start} on go beyond 65535"
                raise MachineError(what, where=f"{where}.{name}", right=f"give up to {last}")
        registers = cls(*(range(getattr(link, name), getattr(link, name) + size) for name, size in sizes.items()))
        if registers.readings.start < registers.identity.stop and registers.identity.start < registers.readings.stop:
            what = f"register {link.identity} is too near to the readings, from {link.readings} on"
            raise MachineError(what, where=f"{where}.identity", right=f"give {registers.readings.stop} or more")
        return registers
