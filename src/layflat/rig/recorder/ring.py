"""Rows and events on their way from the loop to the recorder, in memory that outlives either.

One writes (the loop), one reads (the recorder), nobody waits: a full queue drops what comes, and counts. The memory is
a mapped file that its users hold locked, so that what nobody uses any more can be told and removed. It is nothing that
Python's resource tracker knows of, which would remove it when any one of its users dies.
"""

import mmap
import os
import threading
import time
from ctypes import Structure, c_int64, sizeof
from enum import IntEnum
from pathlib import Path
from typing import Any, NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from layflat.arrays import Array
from layflat.errors import InputError
from layflat.rig.clock import SECOND
from layflat.rig.system import RING, lock, new_file

MAGIC = int.from_bytes(b"lfring04", "little")  # changes with what stands where in the memory
STALE = SECOND  # who has not shown a sign of life for so long is dead, ns
ROWS, EVENTS = 4096, 256  # that fit: 20 s at 200 Hz
TEXT = 240  # bytes of an event's text; the rest is cut off

_EVENT = np.dtype([("time", "<f8"), ("level", "<i8"), ("text", f"S{TEXT}")])


class Level(IntEnum):
    """How much an event matters; numbers of rcl_interfaces/msg/Log."""

    INFO = 20
    WARN = 30
    ERROR = 40


class RecorderState(IntEnum):
    """What the recorder is doing."""

    ABSENT = 0
    RECORDING = 1
    STUCK = 2  # it can't write (disk full): it keeps what it can in memory, and tries on
    FINISHING = 3
    DONE = 4
    UNFINISHED = 5  # it has ended and could not make the file whole; `layflat log repair` takes what was written


class Event(NamedTuple):
    """Something worth telling."""

    time: float  # s since the loop began
    level: int
    text: str


class _Counts(Structure):
    """Items of a queue so far."""

    _fields_ = [(name, c_int64) for name in ("written", "read", "dropped")]


class _Head(Structure):
    """What stands at the beginning of the memory; beats are the last signs of life, ns of `time.monotonic_ns`."""

    _fields_ = [
        *((name, c_int64) for name in ("magic", "width", "rows_fit", "events_fit")),
        *((name, c_int64) for name in ("ended", "recorder", "loop_beat", "recorder_beat")),
        *((name, _Counts) for name in ("rows", "events")),
    ]


class _Queue:
    """Items in shared memory, one after the other, and again from the beginning."""

    def __init__(self, counts: _Counts, items: NDArray[Any]) -> None:
        self._counts, self._items, self._fit = counts, items, len(items)

    def put(self, item: Any) -> bool:
        """Add an item; False if there was no room."""
        counts = self._counts
        written = counts.written
        if written - counts.read >= self._fit:
            counts.dropped += 1
            return False
        self._items[written % self._fit] = item
        _fence()
        counts.written = written + 1
        return True

    def take(self) -> NDArray[Any]:
        """All items that are there."""
        first, end = self._counts.read, self._counts.written
        _fence()
        items: NDArray[Any] = self._items[np.arange(first, end) % self._fit]
        self._counts.read = end
        return items


class Ring:
    """The memory, as each of its users has it; make one with `create`, join in with `attach`."""

    def __init__(self, path: Path, handle: int) -> None:
        self.path, self._handle = path, handle
        self._memory = mmap.mmap(handle, 0)
        self.head = head = _Head.from_buffer(self._memory)  # what both sides tell, and how much was handed over
        rows: Array = np.ndarray((head.rows_fit, head.width), np.float64, self._memory, sizeof(_Head))
        events: NDArray[Any] = np.ndarray((head.events_fit,), _EVENT, self._memory, sizeof(_Head) + rows.nbytes)
        self._rows, self._events = _Queue(head.rows, rows), _Queue(head.events, events)

    @classmethod
    def create(cls, width: int, *, rows: int = ROWS, events: int = EVENTS) -> Self:
        """Make the memory for so many rows of a width, and so many events."""
        path, handle = new_file(RING, sizeof(_Head) + rows * width * 8 + events * _EVENT.itemsize)
        os.pwrite(handle, bytes(_Head(MAGIC, width, rows, events)), 0)
        return cls(path, handle)

    @classmethod
    def attach(cls, path: Path) -> Self:
        """Join in; raise InputError if there is none."""
        right = "give the ring of a loop that runs"
        try:
            handle = os.open(path, os.O_RDWR)
        except OSError as error:
            raise InputError(f"can't be opened ({error.strerror})", where=str(path), right=right) from None
        lock(handle, shared=True)
        if os.pread(handle, 8, 0) != MAGIC.to_bytes(8, "little"):
            os.close(handle)
            raise InputError("is not a ring of this version of layflat", where=str(path), right=right)
        return cls(path, handle)

    def close(self) -> None:
        """Let go; others go on."""
        del self._rows, self._events, self.head
        self._memory.close()
        os.close(self._handle)

    def remove(self) -> None:
        """Take away its name: those who are in go on, nobody else can join. A second time does nothing."""
        self.path.unlink(missing_ok=True)

    # the loop

    def push(self, row: Array) -> bool:
        """Hand over a cycle's row, (width,); False if there was no room. It is a sign of life too."""
        self.head.loop_beat = time.monotonic_ns()
        return self._rows.put(row)

    def put_event(self, event: Event) -> bool:
        """Hand over an event, its text cut between two characters; False if there was no room."""
        text = event.text.encode()[:TEXT].decode(errors="ignore").encode()
        return self._events.put((event.time, event.level, text))

    def end(self) -> None:
        """Say that no more rows will come."""
        self.head.ended = True

    def recorder_alive(self) -> bool:
        """Whether the recorder has shown a sign of life in the last second."""
        return _is_fresh(self.head.recorder_beat)

    @property
    def recorder(self) -> RecorderState:
        """What the recorder said last that it does."""
        return RecorderState(self.head.recorder)

    # the recorder

    def take(self) -> Array:
        """All rows that are there, (rows, width)."""
        return self._rows.take()

    def take_events(self) -> list[Event]:
        """All events that are there."""
        return [Event(float(time), int(level), text.decode()) for time, level, text in self._events.take()]

    def beat(self, state: RecorderState) -> None:
        """Show that the recorder lives, and what it does."""
        self.head.recorder, self.head.recorder_beat = state, time.monotonic_ns()

    def loop_alive(self) -> bool:
        """Whether the loop has handed over a row in the last second."""
        return _is_fresh(self.head.loop_beat)


def _is_fresh(beat: int) -> bool:
    return beat > 0 and time.monotonic_ns() - beat <= STALE


_lock = threading.Lock()


def _fence() -> None:
    """Let all that was written or read so far have happened, on processors that change the order (ARM).

    Nothing passes from before the first block to behind the second.
    """
    with _lock:
        pass
    with _lock:
        pass
