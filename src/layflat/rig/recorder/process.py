"""Recorder: a process of its own that reads the loop's ring and writes the log."""

import os
import signal
import sys
import time
from collections import deque
from concurrent.futures import Future, ThreadPoolExecutor
from multiprocessing.context import SpawnProcess
from pathlib import Path

import numpy as np

from layflat.arrays import Array
from layflat.errors import LayflatError, OutputError
from layflat.files import check_folder, whole_file
from layflat.parallel import FROM_TERMINAL, start_process
from layflat.rig.clock import NS_PER_SECOND
from layflat.rig.recorder.bag import BagWriter, LogHeading
from layflat.rig.recorder.file import GrowingFile, sync_path
from layflat.rig.recorder.repair import PART_SUFFIX, write_indexed
from layflat.rig.recorder.ring import Event, EventLevel, RecorderState, Ring
from layflat.rig.safety.faults import Fault, Reaction

TIME_BEFORE_FAULT, TIME_AFTER_FAULT = 10.0, 2.0  # around a fault, in its black box, s
MAX_WARNING = max(fault for fault in Fault if fault.reaction is Reaction.WARN)  # faults up to this one make no file
MAX_BLACK_BOXES = 100  # files of one log
POLL_INTERVAL = 0.01  # between two polls of the ring, s
FULL_DISK_TIMEOUT = 10.0  # waiting time at the end for a disk that is full, s


class BlackBox:
    """Buffer of the last seconds, which a thread writes to a file beside the log at each new fault.

    A further fault within `TIME_AFTER_FAULT` is in the same file. The files of a log NAME.mcap are called
    NAME-fault-001.mcap and so on.
    """

    def __init__(self, place: Path, heading: LogHeading) -> None:
        self._place, self._heading, self._named = place, heading, heading.layout.named
        self._rows: deque[Array] = deque()
        self._events: deque[Event] = deque()
        self._last = 0.0
        self._due: float | None = None
        self._writer = ThreadPoolExecutor(1)
        self._writing: Future[None] | None = None
        self._made = 0

    def append(self, rows: Array, events: list[Event]) -> None:
        """Add new rows, (rows, width), and events, drop those that are too old, and schedule a file at a new fault.

        Warnings make no file, nor do faults after `MAX_BLACK_BOXES` files.
        """
        self._events.extend(events)
        if len(rows):
            self._rows.append(rows)
            worst, times = self._named(rows, "fault"), self._named(rows, "time")
            faults = np.where(worst > MAX_WARNING, worst, 0.0)
            new = np.flatnonzero((faults != np.append(self._last, faults[:-1])) & (faults > 0.0))
            self._last = float(faults[-1])
            if len(new) and self._due is None and self._made < MAX_BLACK_BOXES:
                self._due = float(times[new[0]]) + TIME_AFTER_FAULT
            since = times[-1] - TIME_BEFORE_FAULT - TIME_AFTER_FAULT
            while self._named(self._rows[0], "time")[-1] < since:
                self._rows.popleft()
            while self._events and self._events[0].time < since:
                self._events.popleft()

    def work(self, begin: int, *, wait: bool = False) -> Event | None:
        """Start writing a file that is due, in a thread, unless one is being written; report one that is finished.

        Args:
            begin: time of day when the loop began, ns since 1970.
            wait: whether to wait until the file that is being written is finished.

        Returns:
            An event for a file, of this or an earlier call, that is now written or can't be; else None.
        """
        now = float(self._named(self._rows[-1], "time")[-1]) if self._rows else 0.0
        if self._writing is None and self._due is not None and now >= self._due:
            self._made, self._due = self._made + 1, None
            rows, events = np.concatenate(self._rows), list(self._events)
            self._writing = self._writer.submit(self._write_bag, self._name, rows, events, begin)
        if self._writing is None or not (wait or self._writing.done()):
            return None
        error = self._writing.exception()
        self._writing = None
        if isinstance(error, OSError | OutputError):
            return Event(now, EventLevel.WARN, f"black box {self._name} can't be written ({error})")
        if error is not None:
            raise error
        return Event(now, EventLevel.INFO, f"black box written: {self._name}")

    def end(self, begin: int) -> list[Event]:
        """Write the files that are due, even if the seconds after their fault are not over; return the events."""
        events = [self.work(begin, wait=True)]
        if self._due is not None:
            self._due = -np.inf
            events.append(self.work(begin, wait=True))
        return [event for event in events if event is not None]

    @property
    def _name(self) -> str:
        return f"{self._place.stem}-fault-{self._made:03d}.mcap"

    def _write_bag(self, name: str, rows: Array, events: list[Event], begin: int) -> None:
        """Write rows and events to a bag of its own, which appears whole and synced; `begin` is the log's start, ns."""
        with whole_file(self._place.with_name(name)) as temporary:
            with temporary.open("wb") as file:
                bag = BagWriter(file, self._heading, begin, chunked=True)
                for event in events:
                    bag.write_event(event)
                bag.add(rows)
                bag.finish()
            sync_path(temporary)


def start_recorder(ring: Ring, place: Path, heading: LogHeading) -> SpawnProcess:
    """Start a recorder's process and return it; `ring.is_recorder_alive()` returns True once it records.

    It ends by itself when the loop, which fills the ring, ends or has pushed no row for a second. Until it is finished
    the log is called NAME.mcap.part; that file and its folder are created here.

    Args:
        ring: ring that the loop fills.
        place: path of the log, NAME.mcap.
        heading: heading of the log.

    Raises:
        OutputError: the log can't be written.
        LogExistsError: there is a log of this name.
    """
    check_log_path(place)
    place.parent.mkdir(parents=True, exist_ok=True)
    try:
        os.close(os.open(part_path(place), os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o644))
    except FileExistsError:
        raise LogExistsError("is recorded by another run", where=str(place), right="give another name") from None
    return start_process(_record, (ring.path, place, heading), "layflat recorder")


class LogExistsError(OutputError):
    """Log of this name that exists already, or that another process begins at the same time."""


def check_log_path(place: Path) -> None:
    """Check that a log can be written; raise OutputError if it can't, LogExistsError if it would replace another."""
    part = part_path(place)
    if place.exists():
        raise LogExistsError("is there already", where=str(place), right="give another name, or move it")
    if part.exists():
        raise LogExistsError("is there already", where=str(part), right=f"`layflat log repair {part}` makes it whole")
    check_folder(place.parent)


def part_path(place: Path) -> Path:
    """Return the path of a log until it is finished."""
    return place.with_name(place.name + PART_SUFFIX)


def _record(ring_path: Path, place: Path, heading: LogHeading) -> None:
    """Record until the loop ends, finish the log, and remove the ring; exit with 1 if the log is unfinished."""
    for number in FROM_TERMINAL:
        signal.signal(number, signal.SIG_IGN)
    ring = Ring.attach(ring_path)
    try:
        recorder = LogRecorder(ring, place, heading)
    except OSError:
        ring.beat(RecorderState.UNFINISHED)
        sys.exit(1)
    signal.signal(signal.SIGTERM, lambda *_: setattr(recorder, "stopped", True))
    recorder.run()
    ring.remove()
    sys.exit(ring.recorder is not RecorderState.DONE)


class LogRecorder:
    """Recorder of a log; raise OSError if the file can't be created."""

    def __init__(self, ring: Ring, place: Path, heading: LogHeading) -> None:
        import mcap.writer  # noqa: F401, PLC0415  # before the first row: it takes long

        self._ring, self._place, self._heading = ring, place, heading
        self._file = GrowingFile(part_path(place))
        self._box = BlackBox(place, heading)
        self._bag: BagWriter | None = None
        self._time = 0.0
        self._dropped = self._left_out = 0
        self._stuck = False
        self.stopped = False  # whether to finish without waiting for the loop's end
        self._parent = os.getppid()

    def run(self) -> None:
        """Record until the loop ends or dies or the recorder is stopped, then finish the log.

        Before the first row, the loop counts as dead once the process that started the recorder has ended.
        """
        ended, ring = False, self._ring
        while not ended:
            dead = not ring.is_loop_alive() if ring.head.loop_beat else os.getppid() != self._parent
            ended = self.stopped or ring.head.ended or dead  # set before the ring is drained: nothing stays in it
            self.drain()
            time.sleep(POLL_INTERVAL)
        self._finish()

    def drain(self) -> None:
        """Move new rows and events from the ring to the log and to the black box, and report the recorder's state.

        While the log's buffer is full (a full disk), the log lacks the rows; events and the black box are kept.
        """
        rows, events = self._ring.drain(), self._ring.drain_events()
        layout = self._heading.layout
        if len(rows):
            self._time = float(layout.named(rows[-1], "time"))
        if self._bag is None:
            if not (len(rows) or events):
                self._ring.beat(RecorderState.RECORDING)
                return
            begin = layout.began(rows[0]) if len(rows) else time.time_ns() - round(events[0].time * NS_PER_SECOND)
            self._bag = BagWriter(self._file, self._heading, begin, chunked=False)
        events += self._recording_events(len(rows))
        if self._file.has_room:
            self._bag.add(rows)
            for event in events:
                self._bag.write_event(event)
        self._file.flush()
        self._ring.beat(RecorderState.STUCK if self._file.trouble else RecorderState.RECORDING)
        self._box.append(rows, events)
        written = self._box.work(self._bag.begin)
        if written is not None:
            self._bag.write_event(written)

    def _recording_events(self, rows: int) -> list[Event]:
        """Return events of the recording since the last call: missing rows, and a disk that is full, or no more."""
        messages: list[tuple[EventLevel, str]] = []
        dropped, trouble = self._ring.head.rows.dropped + self._ring.head.events.dropped, self._file.trouble
        if dropped > self._dropped:
            missing = f"{dropped - self._dropped} cycles or events are missing: the recorder did not keep up"
            messages.append((EventLevel.WARN, missing))
        if self._file.has_room and self._left_out:
            messages.append((EventLevel.WARN, f"{self._left_out} cycles are missing: the disk was full"))
        if trouble and not self._stuck:
            messages.append((EventLevel.ERROR, f"the log can't be written: {trouble}"))
        if self._stuck and not trouble:
            messages.append((EventLevel.WARN, "the log can be written again"))
        self._dropped, self._stuck = dropped, bool(trouble)
        self._left_out = 0 if self._file.has_room else self._left_out + rows
        return [Event(self._time, level, text) for level, text in messages]

    def _finish(self) -> None:
        """Finish the black boxes, write the whole log under its own name, and remove the partial one; report DONE.

        It waits up to `FULL_DISK_TIMEOUT` for a full disk. Where writing fails the partial log stays: UNFINISHED.
        Without a row or event there is no log: the empty partial one is removed.
        """
        self._ring.beat(RecorderState.FINISHING)
        part, bag = part_path(self._place), self._bag
        if bag is None:
            part.unlink()
            self._file.close()
            self._ring.beat(RecorderState.DONE)
            return
        for event in self._box.end(bag.begin):
            bag.write_event(event)
        give_up = time.monotonic() + FULL_DISK_TIMEOUT
        self._file.flush()
        while self._file.trouble and time.monotonic() < give_up:
            time.sleep(0.1)
            self._file.flush()
            self._ring.beat(RecorderState.STUCK)
        self._file.sync()
        try:
            if self._file.trouble:
                raise OutputError(self._file.trouble, where=str(part))
            with whole_file(self._place) as temporary:
                write_indexed(part, temporary, lambda *_: self._ring.beat(RecorderState.FINISHING))
            sync_path(self._place.parent)
            part.unlink()
            self._ring.beat(RecorderState.DONE)
        except (LayflatError, OSError):
            self._ring.beat(RecorderState.UNFINISHED)
        self._file.close()
