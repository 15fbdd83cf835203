"""Shared memory between the host and the loop: setpoints in one direction, snapshots in the other.

Neither side ever waits for the other. A slot has a single writing process; its number is odd while it is written, and
a checksum stands beside the values, so that a reader receives a whole message or none, on any processor and also where
the writer was killed half way. The memory is a mapped file; it exists as long as any process maps it.
"""

import contextlib
import mmap
import os
import struct
from collections.abc import Sequence
from dataclasses import dataclass
from math import isnan, nan
from pathlib import Path
from zlib import crc32

import numpy as np

from layflat.arrays import Array
from layflat.machine.interface import MAX_OUTPUTS
from layflat.rig.clock import NS_PER_SECOND, LoopClock
from layflat.rig.record import RowLayout
from layflat.rig.safety.supervisor import HostRequest
from layflat.rig.system import MAILBOX_PREFIX, create_shared_file, lock_file

SEQUENCE_NUMBER = struct.Struct("<Q")
SLOT_HEADER = struct.Struct("<QI4x")  # number of the message, checksum; the values follow

# Attempts to read a message that is being written before the reader keeps its last one: of the loop, and of hosts.
LOOP_READ_ATTEMPTS, HOST_READ_ATTEMPTS = 4, 1000
MAX_CLOCK_OFFSET = 0.1  # greatest difference between the target instant of demands and their arrival, s
HOST_TIMEOUT = 2.0  # after this time without a message of the host the loop ends, once the air is out, s


class Slot:
    """Slot for one message of `size` bytes at an offset in shared memory, written by one process and read by any."""

    def __init__(self, memory: mmap.mmap, start: int, size: int) -> None:
        self._memory, self._start = memory, start
        self._values = slice(start + SLOT_HEADER.size, start + SLOT_HEADER.size + size)
        self._number = self.number & ~1

    @property
    def number(self) -> int:
        """Return the number of the message: odd while it is written, 0 before the first."""
        number: int = SEQUENCE_NUMBER.unpack_from(self._memory, self._start)[0]
        return number

    def write(self, values: bytes) -> None:
        """Replace the message of the slot; its sequence number and checksum let a reader detect a torn one."""
        memory, start = self._memory, self._start
        SEQUENCE_NUMBER.pack_into(memory, start, self._number + 1)
        memory[self._values] = values
        self._number += 2
        SLOT_HEADER.pack_into(memory, start, self._number, crc32(values))

    def read(self, tries: int = LOOP_READ_ATTEMPTS) -> tuple[int, bytes] | None:
        """Return number and values of the message; None before the first, or if no attempt read a whole one."""
        for _ in range(tries):
            number, checksum = SLOT_HEADER.unpack_from(self._memory, self._start)
            values = self._memory[self._values]
            if number == 0:
                return None
            if number == self.number and number % 2 == 0 and crc32(values) == checksum:
                return number, values
        return None


@dataclass
class Setpoints:
    """Setpoints of the host. Edges are counted, so that none is lost between two cycles."""

    demands: list[float]  # rad; NaN where there is none yet
    starts: int = 0
    stops: int = 0
    resets: int = 0
    holds: int = 0
    ended: bool = False  # whether the loop is to end once the hoses are vented
    velocities: list[float] | None = None  # rad/s; None: they are derived from the demands, as the next
    accelerations: list[float] | None = None  # rad/s2
    asks: int = 0  # number of demands so far, whether they differ or not
    target_time: int = 0  # target instant of the last ones, by a monotonic clock, ns
    switches: tuple[int, ...] = (0,) * MAX_OUTPUTS  # edges of each digital output: odd where it is to be on

    def switched(self, output: int, on: bool) -> tuple[int, ...]:
        """Return `switches` with one or two more edges of an output, after which it is on or off as requested."""
        count = self.switches[output] + 1
        return *self.switches[:output], count + (count % 2 != on), *self.switches[output + 1 :]


class Mailbox:
    """Shared memory of host and loop, at a path from `create`; each process opens it for itself."""

    def __init__(self, path: Path, layout: RowLayout) -> None:
        self._format, second, size = _plan_memory(layout)
        self._handle = os.open(path, os.O_RDWR)
        lock_file(self._handle, shared=True)
        self._memory = mmap.mmap(self._handle, size)
        self.setpoints = Slot(self._memory, 0, self._format.size)
        self.snapshot = Slot(self._memory, second, 8 * layout.width)

    @classmethod
    def create(cls, layout: RowLayout) -> Path:
        """Create an empty file of shared memory and return its path; the caller removes it."""
        path, handle = create_shared_file(MAILBOX_PREFIX, _plan_memory(layout)[2])
        os.close(handle)
        return path

    def write_setpoints(self, setpoints: Setpoints) -> None:
        """Replace the setpoints, as the host; every call, with changes or without, is a heartbeat."""
        edges = (
            setpoints.starts, setpoints.stops, setpoints.resets, setpoints.holds, int(setpoints.ended), setpoints.asks,
            setpoints.target_time, *setpoints.switches,
        )  # fmt: skip
        unknown = [nan] * len(setpoints.demands)
        rates = (*(setpoints.velocities or unknown), *(setpoints.accelerations or unknown))
        self.setpoints.write(self._format.pack(*edges, *setpoints.demands, *rates))

    def read_setpoints(self) -> tuple[int, Setpoints] | None:
        """Return number and content of the setpoints, as the loop; None where no whole message is there."""
        message = self.setpoints.read()
        if message is None:
            return None
        starts, stops, resets, holds, ended, asks, target_time, *rest = self._format.unpack(message[1])
        switches, numbers = tuple(rest[:MAX_OUTPUTS]), rest[MAX_OUTPUTS:]
        n = len(numbers) // 3
        demands, *rates = (numbers[k * n : (k + 1) * n] for k in range(3))
        velocities, accelerations = (None if all(map(isnan, rate)) else rate for rate in rates)
        edges = starts, stops, resets, holds, bool(ended)
        return message[0], Setpoints(demands, *edges, velocities, accelerations, asks, target_time, switches)

    def publish(self, row: Array) -> None:
        """Write a row of `record.RowLayout`, as the loop."""
        self.snapshot.write(row.tobytes())

    def read_row(self) -> Array | None:
        """Return the last row, as the host or any observer, in a read-only array; None where no whole one is there."""
        message = self.snapshot.read(HOST_READ_ATTEMPTS)
        return np.frombuffer(message[1]) if message is not None else None

    def close(self) -> None:
        """Unmap the memory and close the file in this process; a second call does nothing."""
        with contextlib.suppress(BufferError):
            self._memory.close()
        if self._handle >= 0:
            os.close(self._handle)
            self._handle = -1


def _plan_memory(layout: RowLayout) -> tuple[struct.Struct, int, int]:
    """Return the format of setpoints, the offset of the snapshot's slot behind theirs, and the size of the memory."""
    setpoints = struct.Struct(f"<{7 + MAX_OUTPUTS}q{3 * len(layout.joints)}d")
    second = SLOT_HEADER.size + setpoints.size
    return setpoints, second, second + SLOT_HEADER.size + 8 * layout.width


class RemoteHost:
    """Host of a loop at the other end of a mailbox.

    The age of setpoints counts by the loop's own clock, from the cycle in which it first read them: a wrong clock of
    the host can't keep stale ones alive. The host states the target instant of demands on the same clock, so that one
    that wakes late still states where its motion should have been; an instant more than 0.1 s off counts as now.
    """

    def __init__(self, mailbox: Mailbox, clock: LoopClock, joints: int) -> None:
        self._mailbox, self._clock = mailbox, clock
        self._number = -1
        self._last = Setpoints([nan] * joints)
        self._last_message = self._target_time = clock.now()

    def request(self, now: int) -> HostRequest:
        """Return the host's request in the cycle that began at `now` (ns); each edge is returned once."""
        before = last = self._last
        if self._mailbox.setpoints.number != self._number and (message := self._mailbox.read_setpoints()) is not None:
            self._number, last = message
            self._last, self._last_message = last, now
            if last.asks != before.asks:
                self._target_time = (
                    last.target_time if abs(now - last.target_time) <= MAX_CLOCK_OFFSET * NS_PER_SECOND else now
                )
        start, stop, reset = last.starts > before.starts, last.stops > before.stops, last.resets > before.resets
        hold = last.holds > before.holds
        switched: Sequence[tuple[int, bool]] = ()
        if last.switches != before.switches:
            counts = enumerate(zip(last.switches, before.switches, strict=True))
            switched = [(number, after % 2 == 1) for number, (after, then) in counts if after != then]
        return HostRequest(
            last.demands, start, stop or last.ended, reset, (now - self._last_message) / NS_PER_SECOND, last.velocities,
            last.accelerations, (now - self._target_time) / NS_PER_SECOND, hold, switched,
        )  # fmt: skip

    def publish(self, row: Array) -> None:
        """Write a row to the mailbox."""
        self._mailbox.publish(row)

    @property
    def ended(self) -> bool:
        """Return whether the host has ended the loop, or has sent nothing for `HOST_TIMEOUT`."""
        return self._last.ended or (self._clock.now() - self._last_message) / NS_PER_SECOND > HOST_TIMEOUT
