"""The loop's end of the recorder: rows and lines into its ring."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from layflat.rig.recorder.ring import Event, Level, Ring


class Hand:
    """Hands over what the loop has to keep; it never waits.

    Args:
        ring: that a recorder empties.
    """

    def __init__(self, ring: Ring) -> None:
        self._ring, self._time = ring, 0.0

    def push(self, row: NDArray[np.float64]) -> None:
        """Hand over a row of `record.Layout`."""
        self._time = float(row[0])
        self._ring.push(row)

    def event(self, text: str, *, serious: bool = True) -> None:
        """Hand over a line for people."""
        self._ring.tell(Event(self._time, Level.WARN if serious else Level.INFO, text))

    def alive(self) -> bool:
        """Whether rows reach the disk."""
        return self._ring.recorder_alive()

    def end(self) -> None:
        """Say that nothing more will come."""
        self._ring.end()


@dataclass(frozen=True)
class HandOf:
    """Makes a hand in another process; it can be pickled.

    Args:
        ring: the ring's file.
    """

    ring: Path

    def __call__(self) -> Hand:
        """Take hold of the ring."""
        return Hand(Ring.attach(self.ring))
