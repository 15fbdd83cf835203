"""Station of a virtual rig: turns words of any protocol into commands to the device, and readings into words."""

import asyncio
from collections.abc import Callable, Sequence

from layflat.machine.model import Machine
from layflat.rig.device.virtual import ReplyFault, VirtualDevice
from layflat.rig.wire import Identity, Wire, is_later

LATE_REPLY_RATIO = 1.5  # delay of a late reply over the host's timeout


class DeviceStation:
    """Device that exchanges words with a host, whose timeout for a reply is `patience`, s.

    A command is obeyed if its number comes after that of the one before, so that none is obeyed twice, nor a delayed
    old one; a request for the identity restarts the numbers.
    """

    def __init__(self, device: VirtualDevice, machine: Machine, patience: float) -> None:
        self.device = device
        self._wire, self._patience = Wire.for_machine(machine), patience
        self._identity = Identity.for_machine(machine, device.capabilities).words()
        self._last: int | None = None

    def _identify(self) -> list[int]:
        """Return the words of the identity; the next command may have any number."""
        self._last = None
        return self._identity

    def _obey(self, sequence: int, words: Sequence[int]) -> bool:
        """Obey a command if its number comes after the last one (`is_later`), and return whether it does.

        Raise WireError if the words are no command, whatever the number is; nothing changes then.
        """
        command = self._wire.command(words)
        if not is_later(sequence, self._last):
            return False
        self._last = sequence
        self.device.obey(command)
        return True

    def _read(self) -> list[int]:
        return self._wire.reading_words(self.device.reading())

    def _send(self, reply: bytes, spoil: ReplyFault | None, damaged: int, write: Callable[[bytes], object]) -> None:
        """Pass a reply to `write`, with a fault: damaged at the byte of index `damaged`, late, or not at all.

        A wrong number (SEQUENCE) has to be in the reply already.
        """
        if spoil is ReplyFault.CRC:
            reply = reply[:damaged] + bytes([reply[damaged] ^ 0x40]) + reply[damaged + 1 :]
        if spoil is ReplyFault.LATE:
            asyncio.get_running_loop().call_later(LATE_REPLY_RATIO * self._patience, write, reply)
        elif spoil is not ReplyFault.LOST:
            write(reply)
