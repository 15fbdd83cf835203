"""What the device makes of words, whatever they came over."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

from layflat.machine.model import Machine
from layflat.rig.device.link import Link
from layflat.rig.driver import Capabilities, Command, Reading
from layflat.rig.wire.content import Wire
from layflat.rig.wire.identity import Identity
from layflat.rig.wire.sequence import is_later

LATE = 1.5
"""Delay of a late reply, in times of the host's patience."""


class Device(Protocol):
    """Valves, sensors and watchdog of a device."""

    capabilities: Capabilities
    """What it can do."""
    link: Link
    """How well its wires do."""

    def obey(self, command: Command) -> None:
        """Take a command."""
        ...

    def reading(self) -> Reading:
        """What the sensors say now."""
        ...

    def tick(self) -> None:
        """Catch up with the clock: what moves, and the watchdog."""
        ...


class Exchange:
    """A device behind words.

    A command is obeyed if its number comes after that of the one before, so that none is obeyed twice, nor an old one
    that was under way for long; who asks for the identity begins anew.
    """

    def __init__(self, device: Device, machine: Machine) -> None:
        self.device = device
        self.wire = Wire.of(machine)
        self._identity = Identity.of(machine, device.capabilities).words()
        self._last: int | None = None

    def identity(self) -> list[int]:
        """Words that say what rig this is; the next command may have any number."""
        self._last = None
        return self._identity

    def obey(self, sequence: int, words: Sequence[int]) -> bool:
        """Take a command's number and words; whether it was a new one, which alone is obeyed.

        Raises:
            WireError: they are no command.
        """
        command = self.wire.command(words)
        if not is_later(sequence, self._last):
            return False
        self._last = sequence
        self.device.obey(command)
        return True

    @property
    def last(self) -> int:
        """Number of the last command that was obeyed; 0 before there was one."""
        return self._last or 0

    def reading(self) -> list[int]:
        """A reading's words."""
        return self.wire.reading_words(self.device.reading())
