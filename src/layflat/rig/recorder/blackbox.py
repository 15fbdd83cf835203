"""What happened around a fault, at full rate, as a file of its own beside the log."""

from collections import deque
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path

import numpy as np

from layflat.arrays import Array
from layflat.errors import OutputError
from layflat.files import whole_file
from layflat.rig.recorder.bag import Bag, Heading
from layflat.rig.recorder.file import synced
from layflat.rig.recorder.ring import Event, Level
from layflat.rig.safety.faults import Fault, Reaction

BEFORE, AFTER = 10.0, 2.0  # s around a fault that are kept
MILD = max(fault for fault in Fault if fault.reaction is Reaction.WARN)  # up to this one faults make no file
MOST = 100  # files that one log gets


class BlackBox:
    """The last seconds in memory; a fault that is new makes a file of them, which a thread writes beside the log.

    A further fault within the seconds after one is in the same file. The files of a log NAME.mcap are called
    NAME-fault-001.mcap and so on.
    """

    def __init__(self, place: Path, heading: Heading) -> None:
        self._place, self._heading, self._named = place, heading, heading.layout.named
        self._rows: deque[Array] = deque()
        self._events: deque[Event] = deque()
        self._last = 0.0
        self._due: float | None = None
        self._writer = ThreadPoolExecutor(1)
        self._writing: Future[None] | None = None
        self._made = 0

    def keep(self, rows: Array, events: list[Event]) -> None:
        """Take in what is new."""
        self._events.extend(events)
        if len(rows):
            self._rows.append(rows)
            found, times = self._named(rows, "fault"), self._named(rows, "time")
            faults = np.where(found > MILD, found, 0.0)
            new = np.flatnonzero((faults != np.append(self._last, faults[:-1])) & (faults > 0.0))
            self._last = float(faults[-1])
            if len(new) and self._due is None and self._made < MOST:
                self._due = float(times[new[0]]) + AFTER
            since = times[-1] - BEFORE - AFTER
            while self._named(self._rows[0], "time")[-1] < since:
                self._rows.popleft()
            while self._events and self._events[0].time < since:
                self._events.popleft()

    def work(self, begin: int, *, wait: bool = False) -> Event | None:
        """Have what is due written; returns what is to be told once a file is done or can't be written.

        `begin` is the time of day when the loop began, ns since 1970; `wait` until the file is done.
        """
        now = float(self._named(self._rows[-1], "time")[-1]) if self._rows else 0.0
        if self._writing is None and self._due is not None and now >= self._due:
            self._made, self._due = self._made + 1, None
            rows, events = np.concatenate(self._rows), list(self._events)
            self._writing = self._writer.submit(self._write, self._name, rows, events, begin)
        if self._writing is None or not (wait or self._writing.done()):
            return None
        error = self._writing.exception()
        self._writing = None
        if isinstance(error, OSError | OutputError):
            return Event(now, Level.WARN, f"black box {self._name} can't be written ({error})")
        if error is not None:
            raise error
        return Event(now, Level.INFO, f"black box written: {self._name}")

    def end(self, begin: int) -> list[Event]:
        """Write all that is due, be its last seconds over or not."""
        told = [self.work(begin, wait=True)]
        if self._due is not None:
            self._due = -np.inf
            told.append(self.work(begin, wait=True))
        return [event for event in told if event is not None]

    @property
    def _name(self) -> str:
        return f"{self._place.stem}-fault-{self._made:03d}.mcap"

    def _write(self, name: str, rows: Array, events: list[Event], begin: int) -> None:
        with whole_file(self._place.with_name(name)) as temporary:
            with temporary.open("wb") as file:
                bag = Bag(file, self._heading, begin, chunked=True)
                for event in events:
                    bag.write_event(event)
                bag.add(rows)
                bag.finish()
            synced(temporary)
