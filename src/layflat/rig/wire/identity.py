"""Identity of a device: read before anything moves, compared with the machine; layout of registers."""

import struct
from collections.abc import Sequence
from typing import NamedTuple, Self

from layflat.errors import MachineError
from layflat.machine.model import Machine
from layflat.machine.parameters import drive_parts
from layflat.rig.driver import Capabilities, DriverError
from layflat.rig.wire.content import Wire, WireError

MAGIC = 0x4C46  # nothing else that answers is taken for a rig
VERSION = 1
WORD = 0xFFFF  # the most that a word carries
DITHERS, LETS_DOWN, OUTPUTS = 1, 2, 8  # of the flags: two bits, and where the number of digital outputs begins


class Identity(NamedTuple):
    """Words by which a device can be known: voltages in mV, the cycle in us, times without a command in ms."""

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
    def of(cls, machine: Machine, able: Capabilities | None = None) -> Self:
        """Return the identity of a machine's device, with its abilities where these are given.

        Raise MachineError if the machine has no valve, sensors or controller, or a voltage or time that is too long for
        the wire.
        """
        _, angle_sensor, pressure_sensor = drive_parts(machine)
        if machine.controller is None:
            raise MachineError("has no controller", where=machine.origin, right="give a machine that moves by itself")
        joints, low, high, centre, dithers, cycle, lets_down, outputs = able or Capabilities.needed(machine)
        if max(abs(low), abs(high)) > 32.0:
            raise MachineError(f"reaches from {low:g} to {high:g} V", where="valve", right="rigs have up to +-32 V")
        own = machine.interface
        bits = own.voltage_bits, angle_sensor.bits, pressure_sensor.bits, own.supply_bits
        voltages = (round(1e3 * voltage) for voltage in (low, high, centre))
        times = (1e6 * cycle, 1e3 * own.watchdog_cycles * machine.cycle, 1e3 * own.dump_after)
        for (name, right), time in zip(_TIMES.items(), times, strict=True):
            if not 0.0 < time < WORD + 0.5:
                raise MachineError(f"its {name} is too long for a rig's wire", where=machine.origin, right=right)
        flags = DITHERS * dithers | LETS_DOWN * lets_down | outputs << OUTPUTS
        return cls._make((MAGIC, VERSION, joints, *bits, *voltages, flags, *map(round, times)))

    def words(self) -> list[int]:
        """Return the number as it goes over the wire; negative ones are those of two's complement.

        Raise WireError if a number does not fit into a word, which would go out as another.
        """
        for name, number in self._asdict().items():
            if not -WORD // 2 <= number <= WORD or (number < 0 and not name.endswith(("low", "high", "voltage"))):
                raise WireError(f"{name} is {number}, which does not fit into a word")
        return [number & WORD for number in self]

    @classmethod
    def from_words(cls, words: Sequence[int]) -> Self:
        """Return the identity in words; raise WireError if no rig sent them, or one of another version."""
        if len(words) != IDENTITY_SIZE or words[0] != MAGIC:
            raise WireError(f"what answers is not a rig of layflat's{_slip(words)}")
        if words[1] != VERSION:
            raise WireError(f"what answers speaks version {words[1]} of the protocol; this is version {VERSION}")
        return cls(*struct.unpack("=7H3h4H", struct.pack("=14H", *words)))

    def check(self, machine: Machine, where: str) -> Capabilities:
        """Make sure that this is the device of a machine; raise DriverError with the first number that differs."""
        expected = Identity.of(machine)
        for name, words in _EXPECTED.items():
            there, here = getattr(self, name), getattr(expected, name)
            if there != here:
                what = f"the rig has {words.format(there)}, the machine {machine.name!r} {words.format(here)}"
                raise DriverError(what, where=where, right="give the description of this rig")
        found = Capabilities.needed(machine)
        if found.dithers and not self.flags & DITHERS:
            raise DriverError("the rig adds no dither", where=where, right="its firmware has to, nobody else does")
        if found.lets_down and not self.flags & LETS_DOWN:
            what = "the rig opens the valves as it lets out the air, and this arm would fall"
            raise DriverError(
                what, where=where, right="its device has to keep them centred (LETS_DOWN in its settings)"
            )
        outputs = self.flags >> OUTPUTS
        if outputs < found.outputs:
            what = f"the rig has {outputs} digital output(s), the machine {machine.name!r} {found.outputs}"
            raise DriverError(what, where=where, right="give the description of this rig")
        if self.shortest_cycle > 1e6 * machine.cycle:
            what = f"the rig needs {self.shortest_cycle} us a cycle, the machine's is {1e3 * machine.cycle:g} ms"
            raise DriverError(what, where=where, right="make controller.cycle longer")
        flags = {"dithers": bool(self.flags & DITHERS), "lets_down": bool(self.flags & LETS_DOWN)}
        return found._replace(shortest_cycle=1e-6 * self.shortest_cycle, outputs=outputs, **flags)


IDENTITY_SIZE = len(Identity._fields)


def _slip(words: Sequence[int]) -> str:
    """Return what would make words an identity, where something does."""
    if words and words[0] == int.from_bytes(MAGIC.to_bytes(2, "big"), "little"):
        return ": the bytes of its words are swapped"
    if MAGIC in words:
        return f": its identity begins {words.index(MAGIC)} registers later: interface.modbus.identity is too low"
    return ": its registers are all 0" if words and not any(words) else ""


_TIMES = {
    "shortest cycle": "rigs have cycles up to 65 ms: make controller.cycle shorter",
    "watchdog": "up to 65 s: make interface.watchdog_cycles or controller.cycle smaller",
    "time until it dumps": "up to 65 s: make interface.dump_after smaller",
}
"""Times of a machine that go over the wire, with what would be right."""

_EXPECTED = {
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


class Registers(NamedTuple):
    """Ranges of registers; commands are written, the others read. The first two begin with the transaction's number."""

    commands: range
    readings: range
    identity: range

    @classmethod
    def of(cls, machine: Machine) -> Self:
        """The map that a machine's file asks for; raise MachineError if it is too long, or what is read overlaps."""
        wire, link = Wire.of(machine), machine.interface.modbus
        where = f"{machine.origin}: interface.modbus"
        sizes = {"commands": 1 + wire.command_size, "readings": 1 + wire.reading_size, "identity": IDENTITY_SIZE}
        for name, size in sizes.items():
            start, last = getattr(link, name), 0x10000 - size
            if start > last:
                what = f"{size} registers from {start} on go beyond 65535"
                raise MachineError(what, where=f"{where}.{name}", right=f"give up to {last}")
        found = cls(*(range(getattr(link, name), getattr(link, name) + size) for name, size in sizes.items()))
        if found.readings.start < found.identity.stop and found.identity.start < found.readings.stop:
            what = f"register {link.identity} is too near to the readings, from {link.readings} on"
            raise MachineError(what, where=f"{where}.identity", right=f"give {found.readings.stop} or more")
        return found
