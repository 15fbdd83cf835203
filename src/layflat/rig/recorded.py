"""A rig in use whose every cycle is kept: recorder and loop, each in a process of its own, begun and ended in order."""

from __future__ import annotations

import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from types import TracebackType

from layflat.machine import Machine
from layflat.rig.clock import SECOND
from layflat.rig.driver import Driver
from layflat.rig.law import layout_of
from layflat.rig.recorder.bag import Heading
from layflat.rig.recorder.client import RecorderClient
from layflat.rig.recorder.process import part_of, start_recorder
from layflat.rig.recorder.ring import RecorderState, Ring
from layflat.rig.session import Session

PATIENCE = 20.0
"""A recorder that has shown no sign of life for so long will not finish its log, s."""


class Recorded:
    """A session and its recorder: `with Recorded(...) as rig: rig.session.start()`.

    Args:
        machine: with controller.
        driver: makes the driver; called in the loop's process, so it must be picklable.
        address: what names the rig: two loops can't have it at a time.
        place: of the log, NAME.mcap.
        realtime: whether the loop asks for priority and locked memory.

    Raises:
        OutputError: the log can't be written there.
        LoopError: the loop did not begin; its message says why.
    """

    def __init__(
        self, machine: Machine, driver: Callable[[], Driver], address: str, place: Path, *, realtime: bool = True
    ) -> None:
        self.machine, self.place = machine, place
        self._ring = Ring.create(layout_of(machine))
        try:
            self.recorder = start_recorder(self._ring, place, Heading.of(machine, driver=address))
        except BaseException:
            self._let_go()
            raise
        try:
            client = partial(RecorderClient.join, self._ring.path)
            self.session = Session(machine, driver, address, client, realtime=realtime)
        except BaseException:
            self._finish()
            raise

    @property
    def recording(self) -> bool:
        """Whether the recorder is there."""
        return self.recorder.is_alive()

    @property
    def part(self) -> Path | None:
        """What the recorder left without finishing it, if anything."""
        part = part_of(self.place)
        return part if part.exists() else None

    def close(self) -> None:
        """Stop, wait until the air is out, the loop has ended, and the log is whole; a second time does nothing."""
        if self._ring_is_there:
            try:
                self.session.close()
            finally:
                self._finish()

    def __enter__(self) -> Recorded:
        """The session with its recorder."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Close it."""
        self.close()

    _ring_is_there = True

    def _finish(self) -> None:
        """Let the recorder finish; one that does nothing any more is ended."""
        ring, recorder = self._ring, self.recorder
        ring.end()
        begun = time.monotonic_ns()
        while recorder.is_alive():
            recorder.join(0.1)
            if time.monotonic_ns() - max(begun, ring.head.recorder_beat) > PATIENCE * SECOND:
                recorder.kill()
        self.finished = ring.recorder is RecorderState.DONE
        """Whether the log is whole."""
        self._let_go()

    def _let_go(self) -> None:
        self._ring.remove()
        self._ring.close()
        self._ring_is_there = False
