"""Ring buffer of rows and events from the loop to the recorder, in shared memory that outlives either.

One process writes (the loop), one reads (the recorder), neither waits: a full queue drops new items and counts them.
The memory is a mapped file that its users hold locked, so that an orphaned one can be recognized and removed. Python's
resource tracker does not know it: the tracker would remove it when any one of its users dies.
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
from layflat.rig.clock import NS_PER_SECOND
from layflat.rig.system import RING_PREFIX, create_shared_file, lock_file

RING_MAGIC = int.from_bytes(b"lfring04", "little")  # changes with the layout of the memory
ALIVE_TIMEOUT = NS_PER_SECOND  # without a heartbeat, after which a process counts as dead, ns
ROW_CAPACITY, EVENT_CAPACITY = 4096, 256  # 20 s of rows at 200 Hz
MAX_EVENT_BYTES = 240  # of an event's text; the rest is cut off

_EVENT_DTYPE = np.dtype([("time", "<f8"), ("level", "<i8"), ("text", f"S{MAX_EVENT_BYTES}")])


class EventLevel(IntEnum):
    """Severity of an event, with the numbers of rcl_interfaces/msg/Log."""

    INFO = 20
    WARN = 30
    ERROR = 40


class RecorderState(IntEnum):
    """State of the recorder."""

    ABSENT = 0
    RECORDING = 1
    STUCK = 2  # it can't write (disk full): it buffers what fits into memory, and tries again
    FINISHING = 3
    DONE = 4
    UNFINISHED = 5  # it has ended without finishing the file, which `layflat log repair` makes whole


class Event(NamedTuple):
    """Event for people: a fault, a change of state, or a message."""

    time: float  # s since the loop began
    level: int  # as of `EventLevel`
    text: str


class _Counts(Structure):
    """Counts of a queue's items so far."""

    _fields_ = [(name, c_int64) for name in ("written", "read", "dropped")]


class _RingHeader(Structure):
    """Header of the memory; beats are the instants of the last signs of life, ns of `time.monotonic_ns`."""

    _fields_ = [
        *((name, c_int64) for name in ("magic", "width", "rows_fit", "events_fit")),
        *((name, c_int64) for name in ("ended", "recorder", "loop_beat", "recorder_beat")),
        *((name, _Counts) for name in ("rows", "events")),
    ]


class _Queue:
    """Circular queue of items in shared memory."""

    def __init__(self, counts: _Counts, items: NDArray[Any]) -> None:
        self._counts, self._items, self._fit = counts, items, len(items)

    def append(self, item: Any) -> bool:
        """Append an item; return False if there was no room, and count it as dropped."""
        counts = self._counts
        written = counts.written
        if written - counts.read >= self._fit:
            counts.dropped += 1
            return False
        self._items[written % self._fit] = item
        _fence()
        counts.written = written + 1
        return True

    def drain(self) -> NDArray[Any]:
        """Remove and return all items."""
        first, end = self._counts.read, self._counts.written
        _fence()
        items: NDArray[Any] = self._items[np.arange(first, end) % self._fit]
        self._counts.read = end
        return items


class Ring:
    """Ring buffer in shared memory; make one with `create`, open an existing one with `attach`."""

    def __init__(self, path: Path, handle: int) -> None:
        self.path, self._handle = path, handle
        self._memory = mmap.mmap(handle, 0)
        self.head = head = _RingHeader.from_buffer(self._memory)  # states of both sides, and counts of the queues
        rows: Array = np.ndarray((head.rows_fit, head.width), np.float64, self._memory, sizeof(_RingHeader))
        events: NDArray[Any] = np.ndarray(
            (head.events_fit,), _EVENT_DTYPE, self._memory, sizeof(_RingHeader) + rows.nbytes
        )
        self._rows, self._events = _Queue(head.rows, rows), _Queue(head.events, events)

    @classmethod
    def create(cls, width: int, *, rows: int = ROW_CAPACITY, events: int = EVENT_CAPACITY) -> Self:
        """Create a ring in new shared memory.

        Args:
            width: count of numbers in a row.
            rows: capacity of the queue of rows.
            events: capacity of the queue of events.
        """
        path, handle = create_shared_file(
            RING_PREFIX, sizeof(_RingHeader) + rows * width * 8 + events * _EVENT_DTYPE.itemsize
        )
        os.pwrite(handle, bytes(_RingHeader(RING_MAGIC, width, rows, events)), 0)
        return cls(path, handle)

    @classmethod
    def attach(cls, path: Path) -> Self:
        """Open an existing ring; raise InputError if there is none at the path."""
        right = "give the ring of a loop that runs"
        try:
            handle = os.open(path, os.O_RDWR)
        except OSError as error:
            raise InputError(f"can't be opened ({error.strerror})", where=str(path), right=right) from None
        try:
            lock_file(handle, shared=True)
        except OSError:
            os.close(handle)
            raise InputError("is locked by another process", where=str(path), right=right) from None
        if os.pread(handle, 8, 0) != RING_MAGIC.to_bytes(8, "little"):
            os.close(handle)
            raise InputError("is not a ring of this version of layflat", where=str(path), right=right)
        return cls(path, handle)

    def close(self) -> None:
        """Unmap the memory in this process; others keep it."""
        del self._rows, self._events, self.head
        self._memory.close()
        os.close(self._handle)

    def remove(self) -> None:
        """Remove the file: processes that have it open keep it, no other can open it. A second call does nothing."""
        self.path.unlink(missing_ok=True)

    # the loop

    def push(self, row: Array) -> bool:
        """Append a cycle's row, (width,), which is a heartbeat too; return False if there was no room."""
        self.head.loop_beat = time.monotonic_ns()
        return self._rows.append(row)

    def put_event(self, event: Event) -> bool:
        """Append an event, its text cut to `MAX_EVENT_BYTES` in whole characters; return False if there was no room."""
        text = event.text.encode()[:MAX_EVENT_BYTES].decode(errors="ignore").encode()
        return self._events.append((event.time, event.level, text))

    def end(self) -> None:
        """Mark the end of the rows."""
        self.head.ended = True

    def is_recorder_alive(self) -> bool:
        """Return whether the recorder had a heartbeat in the last second."""
        return _is_fresh(self.head.recorder_beat)

    @property
    def recorder(self) -> RecorderState:
        """Return the last state that the recorder has reported."""
        return RecorderState(self.head.recorder)

    # the recorder

    def drain(self) -> Array:
        """Remove and return all rows, (rows, width)."""
        return self._rows.drain()

    def drain_events(self) -> list[Event]:
        """Remove and return all events."""
        return [Event(float(time), int(level), text.decode()) for time, level, text in self._events.drain()]

    def beat(self, state: RecorderState) -> None:
        """Report the recorder's state, as a heartbeat."""
        self.head.recorder, self.head.recorder_beat = state, time.monotonic_ns()

    def is_loop_alive(self) -> bool:
        """Return whether the loop has pushed a row in the last second."""
        return _is_fresh(self.head.loop_beat)


def _is_fresh(beat: int) -> bool:
    return beat > 0 and time.monotonic_ns() - beat <= ALIVE_TIMEOUT


_lock = threading.Lock()


def _fence() -> None:
    """Order all reads and writes before this call ahead of those after it, on processors that reorder them (ARM).

    Locking and unlocking twice is a full barrier: nothing moves from before the first block to behind the second.
    """
    with _lock:
        pass
    with _lock:
        pass
