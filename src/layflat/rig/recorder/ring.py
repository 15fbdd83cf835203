"""Rows and events on their way from the loop to the recorder, in memory that outlives either.

One writes (the loop), one reads (the recorder), nobody waits: a full ring drops what comes, and counts. The memory is a
mapped file that its users hold locked, so that what nobody uses any more can be told and removed. It is nothing that
Python's resource tracker knows of, which would remove it when any one of its users dies.
"""

from __future__ import annotations

import json
import mmap
import os
import threading
import time
from enum import IntEnum
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from layflat.errors import InputError
from layflat.rig.clock import SECOND
from layflat.rig.record import Layout
from layflat.rig.shared import RING, new_file
from layflat.rig.system import lock

Array = NDArray[np.float64]

MAGIC = int.from_bytes(b"lfring02", "little")
"""Changes with what stands where in the memory."""

STALE = SECOND
"""Who has not shown a sign of life for so long is dead, ns."""

ROWS, EVENTS = 4096, 256
"""That fit: 20 s at 200 Hz."""

TEXT = 240
"""Bytes of an event's text; the rest is cut off."""

_EVENT = np.dtype([("time", "<f8"), ("level", "<i8"), ("text", f"S{TEXT}")])
_NAMES = 7680
_HEAD = 512 + _NAMES


class _Word(IntEnum):
    """Where numbers stand in the head."""

    MAGIC = 0
    NAMES = 1
    ROWS = 2
    EVENTS = 3
    WRITTEN = 4
    READ = 5
    DROPPED = 6
    EVENTS_WRITTEN = 7
    EVENTS_READ = 8
    EVENTS_DROPPED = 9
    LOOP_BEAT = 10
    RECORDER_BEAT = 11
    ENDED = 12
    RECORDER = 13


class Level(IntEnum):
    """How much an event matters; numbers of rcl_interfaces/msg/Log."""

    INFO = 20
    WARN = 30
    ERROR = 40


class RecorderState(IntEnum):
    """What the recorder is doing."""

    ABSENT = 0
    RECORDING = 1
    STUCK = 2
    """It can't write (disk full): it keeps what it can in memory, and tries on."""
    FINISHING = 3
    DONE = 4
    UNFINISHED = 5
    """It has ended and could not make the file whole; what was written is there, `layflat log repair` takes it."""


class Event(NamedTuple):
    """Something worth telling."""

    time: float
    """s since the loop began"""
    level: int
    text: str


class Ring:
    """The memory, as each of its users has it; make one with `create`, join in with `attach`."""

    def __init__(self, path: Path, handle: int) -> None:
        self.path, self._handle = path, handle
        self._memory = mmap.mmap(handle, 0)
        self._head = memoryview(self._memory)[:512].cast("q")
        names = bytes(self._memory[512 : 512 + self._head[_Word.NAMES]])
        about = json.loads(names)
        self.layout = Layout.of(about["joints"], about["law"])
        self._capacity, self._most_events = self._head[_Word.ROWS], self._head[_Word.EVENTS]
        shape = (self._capacity, self.layout.width)
        self._rows = np.ndarray(shape, np.float64, self._memory, _HEAD)
        self._events = np.ndarray((self._most_events,), _EVENT, self._memory, _HEAD + self._rows.nbytes)

    @classmethod
    def create(cls, layout: Layout, *, rows: int = ROWS, events: int = EVENTS) -> Ring:
        """Make the memory.

        Args:
            layout: of the rows.
            rows: that fit.
            events: that fit.
        """
        names = json.dumps({"joints": layout.joints, "law": dict(layout.law)}).encode()
        if len(names) > _NAMES:
            what = "names of joints and of the control law's signals are too long"
            raise InputError(what, where="machine", right=f"{_NAMES} bytes have to do")
        size = _HEAD + rows * layout.width * 8 + events * _EVENT.itemsize
        path, handle = new_file(RING, size)
        with mmap.mmap(handle, 0) as memory:
            head = np.ndarray((64,), np.int64, memory)
            head[_Word.NAMES], head[_Word.ROWS], head[_Word.EVENTS] = len(names), rows, events
            memory[512 : 512 + len(names)] = names
            head[_Word.MAGIC] = MAGIC
            del head
        return cls(path, handle)

    @classmethod
    def attach(cls, path: Path) -> Ring:
        """Join in.

        Raises:
            InputError: there is none.
        """
        right = "give the ring of a loop that runs"
        try:
            handle = os.open(path, os.O_RDWR)
        except OSError as error:
            raise InputError(f"can't be opened ({error.strerror})", where=str(path), right=right) from None
        lock(handle, shared=True)
        if os.pread(handle, 8, 0) != MAGIC.to_bytes(8, "little"):
            os.close(handle)
            raise InputError("is no ring of this version of layflat", where=str(path), right=right)
        return cls(path, handle)

    def close(self) -> None:
        """Let go; others go on."""
        del self._rows, self._events
        self._head.release()
        self._memory.close()
        os.close(self._handle)

    def remove(self) -> None:
        """Take away its name: those who are in go on, nobody else can join. A second time does nothing."""
        self.path.unlink(missing_ok=True)

    # the loop

    def push(self, row: Array) -> bool:
        """RecorderClient over a cycle's row, (width,); False if there was no room. It is a sign of life too."""
        head = self._head
        written = head[_WRITTEN]
        head[_LOOP_BEAT] = time.monotonic_ns()
        if written - head[_READ] >= self._capacity:
            head[_DROPPED] += 1
            return False
        self._rows[written % self._capacity] = row
        _fence()
        head[_WRITTEN] = written + 1
        return True

    def tell(self, event: Event) -> bool:
        """RecorderClient over an event; False if there was no room."""
        head = self._head
        written = head[_Word.EVENTS_WRITTEN]
        if written - head[_Word.EVENTS_READ] >= self._most_events:
            head[_Word.EVENTS_DROPPED] += 1
            return False
        self._events[written % self._most_events] = (event.time, event.level, _short(event.text))
        _fence()
        head[_Word.EVENTS_WRITTEN] = written + 1
        return True

    def end(self) -> None:
        """Say that no more rows will come."""
        self._head[_Word.ENDED] = 1

    def recorder_alive(self, now: int | None = None) -> bool:
        """Whether the recorder has shown a sign of life in the last second.

        Args:
            now: ns of `time.monotonic_ns`, which is asked where not given.
        """
        beat = self.recorder_beat
        return beat > 0 and (time.monotonic_ns() if now is None else now) - beat <= STALE

    @property
    def recorder(self) -> RecorderState:
        """What the recorder said last that it does."""
        return RecorderState(self._head[_Word.RECORDER])

    # the recorder

    def take(self) -> Array:
        """All rows that are there, (rows, width)."""
        head = self._head
        first, end = head[_READ], head[_WRITTEN]
        _fence()
        rows = self._rows[np.arange(first, end) % self._capacity]
        head[_READ] = end
        return rows

    def take_events(self) -> list[Event]:
        """All events that are there."""
        head = self._head
        first, end = head[_Word.EVENTS_READ], head[_Word.EVENTS_WRITTEN]
        _fence()
        events = self._events[np.arange(first, end) % self._most_events]
        head[_Word.EVENTS_READ] = end
        return [Event(float(one["time"]), int(one["level"]), one["text"].decode()) for one in events]

    def beat(self, state: RecorderState) -> None:
        """Show that the recorder lives, and what it does."""
        self._head[_Word.RECORDER] = state
        self._head[_Word.RECORDER_BEAT] = time.monotonic_ns()

    @property
    def begun(self) -> bool:
        """Whether the loop has handed over a row."""
        return self._head[_LOOP_BEAT] > 0

    @property
    def ended(self) -> bool:
        """Whether the loop said that it has ended."""
        return bool(self._head[_Word.ENDED])

    def loop_alive(self, now: int | None = None) -> bool:
        """Whether the loop has handed over a row in the last second."""
        return (time.monotonic_ns() if now is None else now) - self._head[_LOOP_BEAT] <= STALE

    @property
    def written(self) -> int:
        """Rows that were handed over so far."""
        return self._head[_WRITTEN]

    @property
    def recorder_beat(self) -> int:
        """When the recorder last showed that it lives, ns of `time.monotonic_ns`."""
        return self._head[_Word.RECORDER_BEAT]

    @property
    def dropped(self) -> int:
        """Rows for which there was no room."""
        return self._head[_DROPPED]

    @property
    def events_dropped(self) -> int:
        """Events for which there was no room."""
        return self._head[_Word.EVENTS_DROPPED]


_WRITTEN, _READ, _DROPPED, _LOOP_BEAT = (
    int(word) for word in (_Word.WRITTEN, _Word.READ, _Word.DROPPED, _Word.LOOP_BEAT)
)
"""As plain numbers, for what happens in every cycle."""

_lock = threading.Lock()


def _fence() -> None:
    """Let all that was written or read so far have happened, on processors that change the order (ARM).

    Nothing passes from before the first block to behind the second.
    """
    with _lock:
        pass
    with _lock:
        pass


def _short(text: str) -> bytes:
    """A text as UTF-8 that fits, cut between two characters."""
    return text.encode()[:TEXT].decode(errors="ignore").encode()
