"""Shared memory between the host and the loop: setpoints one way, snapshots the other.

Neither side ever waits for the other. A slot is written by one process alone; its number is odd while it is written,
and a checksum stands beside the values, so that a reader takes a whole message or none, on any processor and also
where the writer was killed half way. The memory is a file that is mapped; it stays as long as anyone maps it.
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
from layflat.machine.interface import MOST_OUTPUTS
from layflat.rig.clock import SECOND, Clock
from layflat.rig.record import Layout
from layflat.rig.safety.supervisor import HostRequest
from layflat.rig.system import MAILBOX, lock, new_file

NUMBER = struct.Struct("<Q")
HEAD = struct.Struct("<QI4x")  # number of the message, checksum; the values follow

# Of a reader that meets a message in the making, until it keeps what it had; and where there is time.
TRIES, PEOPLE_TRIES = 4, 1000
OFF = 0.1  # by which the instant that demands are meant for may differ from when they come, s
PATIENCE = 2.0  # without a word of the host for so long the loop ends once the air is out, s


class Slot:
    """One message of `size` bytes at a place in shared memory, written by one process and read by any."""

    def __init__(self, memory: mmap.mmap, start: int, size: int) -> None:
        self._memory, self._start = memory, start
        self._values = slice(start + HEAD.size, start + HEAD.size + size)
        self._number = self.number & ~1

    @property
    def number(self) -> int:
        """Of the message, and odd while it is written; 0 before the first."""
        number: int = NUMBER.unpack_from(self._memory, self._start)[0]
        return number

    def write(self, values: bytes) -> None:
        """Replace the message."""
        memory, start = self._memory, self._start
        NUMBER.pack_into(memory, start, self._number + 1)
        memory[self._values] = values
        self._number += 2
        HEAD.pack_into(memory, start, self._number, crc32(values))

    def read(self, tries: int = TRIES) -> tuple[int, bytes] | None:
        """Number and values of the message; None before the first, or where none could be had whole."""
        for _ in range(tries):
            number, checksum = HEAD.unpack_from(self._memory, self._start)
            values = self._memory[self._values]
            if number == 0:
                return None
            if number == self.number and number % 2 == 0 and crc32(values) == checksum:
                return number, values
        return None


@dataclass
class Setpoints:
    """What the host asks for. Edges are counted, so that none is lost between two cycles."""

    demands: list[float]  # rad; not a number where there is none yet
    starts: int = 0
    stops: int = 0
    resets: int = 0
    holds: int = 0
    ended: bool = False  # whether the loop is to end once it has let out the air
    velocities: list[float] | None = None  # rad/s; None: they are derived from the demands, as the next
    accelerations: list[float] | None = None  # rad/s2
    asks: int = 0  # demands asked for so far, whether they differ or not
    meant: int = 0  # instant for which the last ones are meant, by a monotonic clock, ns
    switches: tuple[int, ...] = (0,) * MOST_OUTPUTS  # edges of each digital output: odd where it is to be on

    def switched(self, output: int, on: bool) -> tuple[int, ...]:
        """Return `switches` with one edge more, whatever the output was asked for before."""
        count = self.switches[output] + 1
        return *self.switches[:output], count + (count % 2 != on), *self.switches[output + 1 :]


class Mailbox:
    """The memory that host and loop share, at a path from `create`; each opens it for itself."""

    def __init__(self, path: Path, layout: Layout) -> None:
        self._format, second, size = _plan(layout)
        self._handle = os.open(path, os.O_RDWR)
        lock(self._handle, shared=True)
        self._memory = mmap.mmap(self._handle, size)
        self.setpoints = Slot(self._memory, 0, self._format.size)
        self.snapshot = Slot(self._memory, second, 8 * layout.width)

    @classmethod
    def create(cls, layout: Layout) -> Path:
        """A new file of shared memory, empty; whoever made it removes it."""
        path, handle = new_file(MAILBOX, _plan(layout)[2])
        os.close(handle)
        return path

    def ask(self, wanted: Setpoints) -> None:
        """The host's: replace the setpoints; doing so again shows that it lives."""
        edges = (
            wanted.starts, wanted.stops, wanted.resets, wanted.holds, int(wanted.ended), wanted.asks, wanted.meant,
            *wanted.switches,
        )  # fmt: skip
        unknown = [nan] * len(wanted.demands)
        rates = (*(wanted.velocities or unknown), *(wanted.accelerations or unknown))
        self.setpoints.write(self._format.pack(*edges, *wanted.demands, *rates))

    def asked(self) -> tuple[int, Setpoints] | None:
        """The loop's: number of the setpoints, and they; None where there is nothing whole."""
        found = self.setpoints.read()
        if found is None:
            return None
        starts, stops, resets, holds, ended, asks, meant, *rest = self._format.unpack(found[1])
        switches, numbers = tuple(rest[:MOST_OUTPUTS]), rest[MOST_OUTPUTS:]
        n = len(numbers) // 3
        demands, *rates = (numbers[k * n : (k + 1) * n] for k in range(3))
        velocities, accelerations = (None if all(map(isnan, of)) else of for of in rates)
        edges = starts, stops, resets, holds, bool(ended)
        wanted = Setpoints(demands, *edges, velocities, accelerations, asks, meant, switches)
        return found[0], wanted

    def publish(self, row: Array) -> None:
        """The loop's: show a row of `record.Layout`."""
        self.snapshot.write(row.tobytes())

    def shown(self) -> Array | None:
        """The host's, or anyone's: the last row; None before the first."""
        found = self.snapshot.read(PEOPLE_TRIES)
        return np.frombuffer(found[1]) if found is not None else None

    def close(self) -> None:
        """Let go of the memory."""
        with contextlib.suppress(BufferError):
            self._memory.close()
        if self._handle >= 0:
            os.close(self._handle)
            self._handle = -1


def _plan(layout: Layout) -> tuple[struct.Struct, int, int]:
    """How setpoints are written, where the snapshot's slot begins behind theirs, and where it ends."""
    setpoints = struct.Struct(f"<{7 + MOST_OUTPUTS}q{3 * len(layout.joints)}d")
    second = HEAD.size + setpoints.size
    return setpoints, second, second + HEAD.size + 8 * layout.width


class RemoteHost:
    """The host as the loop sees it through a mailbox.

    How old setpoints are is told by the loop's own clock, from the cycle in which it first saw them: what the host
    believes of the time can't keep stale ones alive. For which instant demands are meant it may say: a host that wakes
    late asks for where the motion is to be by then, if its clock is the loop's.
    """

    def __init__(self, mailbox: Mailbox, clock: Clock, joints: int) -> None:
        self._mailbox, self._clock = mailbox, clock
        self._number = -1
        self._last = Setpoints([nan] * joints)
        self._heard = self._meant = clock.now()

    def request(self, now: int) -> HostRequest:
        """What is wanted now; edges are given once."""
        before = last = self._last
        if self._mailbox.setpoints.number != self._number and (found := self._mailbox.asked()) is not None:
            self._number, last = found
            self._last, self._heard = last, now
            if last.asks != before.asks:
                self._meant = last.meant if abs(now - last.meant) <= OFF * SECOND else now
        start, stop, reset = last.starts > before.starts, last.stops > before.stops, last.resets > before.resets
        hold = last.holds > before.holds
        switched: Sequence[tuple[int, bool]] = ()
        if last.switches != before.switches:
            counts = enumerate(zip(last.switches, before.switches, strict=True))
            switched = [(number, after % 2 == 1) for number, (after, then) in counts if after != then]
        return HostRequest(
            last.demands, start, stop or last.ended, reset, (now - self._heard) / SECOND, last.velocities,
            last.accelerations, (now - self._meant) / SECOND, hold, switched,
        )  # fmt: skip

    def publish(self, row: Array) -> None:
        """Show a row to it."""
        self._mailbox.publish(row)

    @property
    def ended(self) -> bool:
        """Whether it wants the loop to end, or has not been heard for long."""
        return self._last.ended or (self._clock.now() - self._heard) / SECOND > PATIENCE
