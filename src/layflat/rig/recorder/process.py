"""The recorder: a process of its own that takes what the loop hands over, and writes it."""

import os
import signal
import sys
import time
from multiprocessing.context import SpawnProcess
from pathlib import Path

from layflat.errors import LayflatError, OutputError
from layflat.files import check_folder, whole_file
from layflat.parallel import FROM_TERMINAL, start_process
from layflat.rig.clock import SECOND
from layflat.rig.recorder.bag import Bag, Heading
from layflat.rig.recorder.blackbox import BlackBox
from layflat.rig.recorder.file import GrowingFile, synced
from layflat.rig.recorder.repair import PART, indexed
from layflat.rig.recorder.ring import Event, Level, RecorderState, Ring

TICK = 0.01  # between two looks into the ring, s
PATIENCE = 10.0  # for which a disk that is full at the end is waited for, s


def start_recorder(ring: Ring, place: Path, heading: Heading) -> SpawnProcess:
    """Start a recorder; `ring.recorder_alive()` tells when it is there.

    It ends by itself when the loop, which fills the ring, ends or has not handed over anything for a second. The log is
    called NAME.mcap.part until it is finished; OutputError is raised if it can't be written, TakenError if it is there.
    """
    check_place(place)
    place.parent.mkdir(parents=True, exist_ok=True)
    try:
        os.close(os.open(part_of(place), os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o644))
    except FileExistsError:
        raise TakenError("is recorded by another run", where=str(place), right="give another name") from None
    return start_process(_record, (ring.path, place, heading), "layflat recorder")


class TakenError(OutputError):
    """There is a log of this name already, or another process begins one at the same time."""


def check_place(place: Path) -> None:
    """Make sure that a log can be written; raise OutputError if it can't, or would take the place of another."""
    part = part_of(place)
    if place.exists():
        raise TakenError("is there already", where=str(place), right="give another name, or move it")
    if part.exists():
        raise TakenError("is there already", where=str(part), right=f"`layflat log repair {part}` makes it whole")
    check_folder(place.parent)


def part_of(place: Path) -> Path:
    """Return the name of a log until it is finished."""
    return place.with_name(place.name + PART)


def _record(ring_path: Path, place: Path, heading: Heading) -> None:
    """Record until the loop ends, then finish the log. Exit status 1 if it could not."""
    for number in FROM_TERMINAL:
        signal.signal(number, signal.SIG_IGN)
    ring = Ring.attach(ring_path)
    try:
        recorder = Recorder(ring, place, heading)
    except OSError:
        ring.beat(RecorderState.UNFINISHED)
        sys.exit(1)
    signal.signal(signal.SIGTERM, lambda *_: setattr(recorder, "stopped", True))
    recorder.run()
    ring.remove()
    sys.exit(ring.recorder is not RecorderState.DONE)


class Recorder:
    """A log that is being recorded; raise OSError if it can't be."""

    def __init__(self, ring: Ring, place: Path, heading: Heading) -> None:
        import mcap.writer  # noqa: F401, PLC0415  # before the first row: it takes long

        self._ring, self._place, self._heading = ring, place, heading
        self._file = GrowingFile(part_of(place))
        self._box = BlackBox(place, heading)
        self._bag: Bag | None = None
        self._time = 0.0
        self._dropped = self._left_out = 0
        self._stuck = False
        self.stopped = False  # whether to finish with what is there
        self._parent = os.getppid()

    def run(self) -> None:
        """Record, then finish."""
        over, ring = False, self._ring
        while not over:
            gone = not ring.loop_alive() if ring.head.loop_beat else os.getppid() != self._parent
            over = self.stopped or ring.head.ended or gone  # known before the ring is drained: nothing stays in it
            self.drain()
            time.sleep(TICK)
        self._finish()

    def drain(self) -> None:
        """Write what the loop has handed over."""
        rows, events = self._ring.take(), self._ring.take_events()
        layout = self._heading.layout
        if len(rows):
            self._time = float(layout.named(rows[-1], "time"))
        if self._bag is None:
            if not (len(rows) or events):
                self._ring.beat(RecorderState.RECORDING)
                return
            begin = layout.began(rows[0]) if len(rows) else time.time_ns() - round(events[0].time * SECOND)
            self._bag = Bag(self._file, self._heading, begin, chunked=False)
        events += self._noticed(len(rows))
        if self._file.room:
            self._bag.add(rows)
            for event in events:
                self._bag.write_event(event)
        self._file.flush()
        self._ring.beat(RecorderState.STUCK if self._file.trouble else RecorderState.RECORDING)
        self._box.keep(rows, events)
        told = self._box.work(self._bag.begin)
        if told is not None:
            self._bag.write_event(told)

    def _noticed(self, rows: int) -> list[Event]:
        """Return new events of the recording itself."""
        told: list[tuple[Level, str]] = []
        dropped, trouble = self._ring.head.rows.dropped + self._ring.head.events.dropped, self._file.trouble
        if dropped > self._dropped:
            missing = f"{dropped - self._dropped} cycles or events are missing: the recorder did not keep up"
            told.append((Level.WARN, missing))
        if self._file.room and self._left_out:
            told.append((Level.WARN, f"{self._left_out} cycles are missing: the disk was full"))
        if trouble and not self._stuck:
            told.append((Level.ERROR, f"the log can't be written: {trouble}"))
        if self._stuck and not trouble:
            told.append((Level.WARN, "the log can be written again"))
        self._dropped, self._stuck = dropped, bool(trouble)
        self._left_out = 0 if self._file.room else self._left_out + rows
        return [Event(self._time, level, text) for level, text in told]

    def _finish(self) -> None:
        """Make the file whole under its own name; where that can't be done, leave what is there."""
        self._ring.beat(RecorderState.FINISHING)
        part, bag = part_of(self._place), self._bag
        if bag is None:
            part.unlink()
            self._file.close()
            self._ring.beat(RecorderState.DONE)
            return
        for event in self._box.end(bag.begin):
            bag.write_event(event)
        give_up = time.monotonic() + PATIENCE
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
                indexed(part, temporary, lambda *_: self._ring.beat(RecorderState.FINISHING))
            synced(self._place.parent)
            part.unlink()
            self._ring.beat(RecorderState.DONE)
        except (LayflatError, OSError):
            self._ring.beat(RecorderState.UNFINISHED)
        self._file.close()
