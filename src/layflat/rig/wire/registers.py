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
