"""A rig in use whose every cycle is kept: recorder and loop, each in a process of its own, begun and ended in order."""

import time
from collections.abc import Callable
from contextlib import AbstractContextManager, ExitStack
from functools import partial
from pathlib import Path

from layflat.machine import Machine
from layflat.rig.clock import SECOND
from layflat.rig.driver import Driver
from layflat.rig.lease import Lease
from layflat.rig.record import Layout
from layflat.rig.recorder.bag import Heading
from layflat.rig.recorder.client import RecorderClient
from layflat.rig.recorder.process import part_of, start_recorder
from layflat.rig.recorder.ring import Ring
from layflat.rig.session import Session

PATIENCE = 20.0  # a recorder that has shown no sign of life for so long will not finish its log, s


class Recorded(AbstractContextManager["Recorded"]):
    """A session and its recorder: `with Recorded(...) as rig: rig.session.start()`; see `Session`.

    The log, NAME.mcap, keeps the rig's address; OutputError is raised if it can't be written at its place.
    """

    def __init__(
        self, machine: Machine, driver: Callable[[], Driver], address: str, place: Path, lease: Lease | None = None
    ) -> None:
        self.machine, self.place = machine, place
        with ExitStack() as begun:
            self._ring = Ring.create(Layout.of(machine).width)
            begun.callback(self._ring.close)
            begun.callback(self._ring.remove)
            self.recorder = start_recorder(self._ring, place, Heading.of(machine, driver=address))
            begun.callback(self._finish)
            client = partial(RecorderClient.join, self._ring.path)
            self.session = begun.enter_context(Session(machine, driver, client, lease))
            self._begun = begun.pop_all()

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
        self._begun.close()

    def __exit__(self, *_: object) -> None:
        self.close()

    def _finish(self) -> None:
        """Let the recorder finish; one that does nothing any more is ended."""
        ring, recorder = self._ring, self.recorder
        ring.end()
        begun = time.monotonic_ns()
        while recorder.is_alive():
            recorder.join(0.1)
            if time.monotonic_ns() - max(begun, ring.head.recorder_beat) > PATIENCE * SECOND:
                recorder.kill()
