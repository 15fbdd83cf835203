"""The loop's end of the recorder: rows and lines into its ring."""

import time
from pathlib import Path
from typing import Self

from layflat.arrays import Array
from layflat.errors import OutputError
from layflat.rig.loop import Recorder
from layflat.rig.record import SHARED
from layflat.rig.recorder.ring import Event, Level, RecorderState, Ring
from layflat.rig.safety.faults import Fault, Reaction

# How much a cycle's events matter, by its worst fault.
LEVELS = [Level.INFO, *(Level.WARN if fault.reaction is Reaction.WARN else Level.ERROR for fault in list(Fault)[1:])]
TIME, FAULT = (list(SHARED).index(name) for name in ("time", "fault"))
CHANGE = " -> "  # in the line of a change of state
STARTS_WITHIN = 30.0  # a recorder has to be there by then, s


class RecorderClient(Recorder):
    """Hands over what the loop has to keep to a ring that a recorder empties; it never waits."""

    def __init__(self, ring: Ring) -> None:
        self._ring, self._time, self._level = ring, 0.0, Level.INFO

    @classmethod
    def join(cls, path: Path) -> Self:
        """Take hold of the ring in a file, as soon as its recorder is there; raise OutputError if it is not."""
        ring, until = Ring.attach(path), time.monotonic() + STARTS_WITHIN
        while not ring.recorder_alive() or ring.recorder is RecorderState.UNFINISHED:
            if ring.recorder is RecorderState.UNFINISHED or time.monotonic() > until:
                raise OutputError("the recorder did not start", where="rig", right="see that logs can be written")
            time.sleep(0.005)
        return cls(ring)

    def push(self, row: Array) -> None:
        """Hand over a row of `record.Layout`."""
        self._time, self._level = float(row[TIME]), LEVELS[int(row[FAULT])]
        self._ring.push(row)

    def event(self, text: str) -> None:
        """Hand over a line for people; it matters as much as the worst fault of the cycle that it belongs to.

        A change of state beside a fault that is only told matters no more than any other.
        """
        mild = CHANGE in text and self._level is Level.WARN
        self._ring.put_event(Event(self._time, Level.INFO if mild else self._level, text))

    def alive(self) -> bool:
        """Whether rows reach the disk."""
        return self._ring.recorder_alive()

    def end(self) -> None:
        """Say that nothing more will come."""
        self._ring.end()
