"""Station of a virtual rig: turns words of any protocol into commands to the device, and readings into words."""

import asyncio
from collections.abc import Callable, Sequence

from layflat.machine.model import Machine
from layflat.rig.device.link import Spoil
from layflat.rig.device.virtual import VirtualDevice
from layflat.rig.wire.content import Wire, is_later
from layflat.rig.wire.identity import Identity

LATE = 1.5  # delay of a late reply, in times of the host's patience


class Station:
    """A device behind words; who waits for its replies has a patience, s.

    A command is obeyed if its number comes after that of the one before, so that none is obeyed twice, nor an old one
    that was under way for long; who asks for the identity begins anew.
    """

    def __init__(self, device: VirtualDevice, machine: Machine, patience: float) -> None:
        self.device = device
        self._wire, self._patience = Wire.of(machine), patience
        self._identity = Identity.of(machine, device.capabilities).words()
        self._last: int | None = None

    def _identify(self) -> list[int]:
        """Words that say what rig this is; the next command may have any number."""
        self._last = None
        return self._identity

    def _obey(self, sequence: int, words: Sequence[int]) -> bool:
        """Obey a command if it is new, and return whether it was; raise WireError if its words are no command."""
        command = self._wire.command(words)
        if not is_later(sequence, self._last):
            return False
        self._last = sequence
        self.device.obey(command)
        return True

    def _read(self) -> list[int]:
        return self._wire.reading_words(self.device.reading())

    def _send(self, reply: bytes, spoil: Spoil | None, damaged: int, write: Callable[[bytes], object]) -> None:
        """Send a reply, or what becomes of it; `damaged` is the byte that a wrong checksum comes of."""
        if spoil is Spoil.CRC:
            reply = reply[:damaged] + bytes([reply[damaged] ^ 0x40]) + reply[damaged + 1 :]
        if spoil is Spoil.LATE:
            asyncio.get_running_loop().call_later(LATE * self._patience, write, reply)
        elif spoil is not Spoil.LOST:
            write(reply)
