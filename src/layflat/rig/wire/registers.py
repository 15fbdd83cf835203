"""Where the words stand in a Modbus station's registers."""

from __future__ import annotations

from typing import NamedTuple

from layflat.errors import MachineError
from layflat.machine.model import Machine
from layflat.rig.wire.content import Wire
from layflat.rig.wire.identity import IDENTITY_SIZE


class Registers(NamedTuple):
    """Ranges of registers; commands are written, the others read. The first two begin with the transaction's number."""

    commands: range
    readings: range
    identity: range

    @classmethod
    def of(cls, machine: Machine) -> Registers:
        """The map that a machine's file asks for.

        Raises:
            MachineError: it goes beyond the last register, or what is read overlaps.
        """
        wire, link = Wire.of(machine), machine.interface.modbus
        sizes = {"commands": 1 + wire.command_size, "readings": 1 + wire.reading_size, "identity": IDENTITY_SIZE}
        found = cls(*(range(getattr(link, name), getattr(link, name) + size) for name, size in sizes.items()))
        where = f"{machine.origin}: interface.modbus"
        for name, registers in zip(sizes, found, strict=True):
            if registers.stop > 0x10000:
                raise MachineError(
                    f"{len(registers)} registers from {registers.start} on go beyond 65535",
                    where=f"{where}.{name}",
                    right=f"give up to {0x10000 - len(registers)}",
                )
        if found.readings.start < found.identity.stop and found.identity.start < found.readings.stop:
            raise MachineError(
                f"register {found.identity.start} is too near to the readings, from {found.readings.start} on",
                where=f"{where}.identity",
                right=f"give {found.readings.stop} or more",
            )
        return found
