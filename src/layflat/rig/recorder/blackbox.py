"""What happened around a fault, at full rate, as a file of its own beside the log."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from layflat.errors import OutputError
from layflat.files import whole_file
from layflat.rig.recorder.bag import Bag, Heading
from layflat.rig.recorder.file import synced
from layflat.rig.recorder.ring import Event, Level
from layflat.rig.safety.faults import TABLE, Reaction

Array = NDArray[np.float64]

BEFORE, AFTER = 10.0, 2.0
"""s around a fault that are kept."""

MILD = max(fault for fault, entry in TABLE.items() if entry.reaction is Reaction.TELL)
"""Up to this one faults are told and no more: they make no file."""

MOST = 100
"""Files that one log gets."""

PORTION = 50
"""Rows written at a time, so that the log does not wait."""


class BlackBox:
    """The last seconds in memory; a fault that is new makes a file of them.

    A further fault within the seconds after one is in the same file.

    Args:
        place: of the log, NAME.mcap; the files are NAME-fault-001.mcap and so on.
        heading: what the files say of themselves.
    """

    def __init__(self, place: Path, heading: Heading) -> None:
        self._place, self._heading = place, heading
        shared = heading.layout.shared
        self._time, self._fault = shared["time"], shared["fault"]
        self._rows: deque[Array] = deque()
        self._events: deque[Event] = deque()
        self._last = 0.0
        self._due: float | None = None
        self._writing: Iterator[None] | None = None
        self._made = 0

    def keep(self, rows: Array, events: list[Event]) -> None:
        """Take in what is new."""
        self._events.extend(events)
        if len(rows):
            self._rows.append(rows)
            faults = np.where(rows[:, self._fault] > MILD, rows[:, self._fault], 0.0)
            new = np.flatnonzero((faults != np.append(self._last, faults[:-1])) & (faults > 0.0))
            self._last = float(faults[-1])
            if len(new) and self._due is None and self._made < MOST:
                self._due = float(rows[new[0], self._time]) + AFTER
            since = rows[-1, self._time] - BEFORE - AFTER
            while self._rows[0][-1, self._time] < since:
                self._rows.popleft()
            while self._events and self._events[0].time < since:
                self._events.popleft()

    @property
    def writing(self) -> bool:
        """Whether a file is being written."""
        return self._writing is not None

    def work(self, begin: int) -> Event | None:
        """Write a little of what is due; returns what is to be told when a file is done or can't be written."""
        if self._writing is None:
            if self._due is None or self._rows[-1][-1, self._time] < self._due:
                return None
            self._made += 1
            self._writing = self._written(np.concatenate(self._rows), list(self._events), begin)
            self._due = None
        path = self._place.with_name(f"{self._place.stem}-fault-{self._made:03d}.mcap")
        now = float(self._rows[-1][-1, self._time])
        try:
            next(self._writing)
        except StopIteration:
            return self._done(Event(now, Level.INFO, f"black box written: {path.name}"))
        except (OSError, OutputError) as error:
            return self._done(Event(now, Level.WARN, f"black box {path.name} can't be written ({error})"))
        return None

    def end(self, begin: int) -> list[Event]:
        """Write all that is due, be its last seconds over or not."""
        told = []
        if self._due is not None:
            self._due = -np.inf
        while self._writing is not None or self._due is not None:
            told += [event] if (event := self.work(begin)) is not None else []
        return told

    def _done(self, event: Event) -> Event:
        self._writing = None
        return event

    def _written(self, rows: Array, events: list[Event], begin: int) -> Iterator[None]:
        path = self._place.with_name(f"{self._place.stem}-fault-{self._made:03d}.mcap")
        with whole_file(path) as temporary:
            with temporary.open("wb") as file:
                bag = Bag(file, self._heading, begin, chunked=True)
                for event in events:
                    bag.tell(event)
                for first in range(0, len(rows), PORTION):
                    bag.add(rows[first : first + PORTION])
                    yield
                bag.finish()
            with ThreadPoolExecutor(1) as others:  # the disk takes its time
                on_disk = others.submit(synced, temporary)
                while not on_disk.done():
                    yield
                on_disk.result()
