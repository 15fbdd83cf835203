"""Faults of the wires between a rig and its host."""

from enum import Enum
from math import inf


class Spoil(Enum):
    """Ways in which a reply is spoilt."""

    LOST = "lost"
    CRC = "crc"
    SEQUENCE = "sequence"
    LATE = "late"


class Link:
    """A sound link, until told otherwise.

    A spoilt reply follows a command that was heard. While the link is silent, nothing is heard either: who answers
    leaves the command alone.
    """

    def __init__(self) -> None:
        self.mend()

    def spoil(self, kind: Spoil, replies: float = inf) -> None:
        """Spoil so many of the coming replies."""
        self._kind, self._left = kind, replies

    def mend(self) -> None:
        """All is well from now on."""
        self.silent, self._kind, self._left = False, Spoil.LOST, 0.0

    def next(self) -> Spoil | None:
        """Return the fault of the coming reply; None where it is sent as it is."""
        if self.silent:
            return Spoil.LOST
        if self._left < 1.0:
            return None
        self._left -= 1.0
        return self._kind
