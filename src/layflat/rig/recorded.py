"""A rig in use whose every cycle is kept: recorder and loop, each in a process of its own, begun and ended in order."""

import time
from collections.abc import Callable
from contextlib import AbstractContextManager, ExitStack
from functools import partial
from pathlib import Path
from typing import Self

from layflat.errors import OutputError
from layflat.machine import Machine
from layflat.rig.clock import SECOND
from layflat.rig.driver import Driver
from layflat.rig.lease import Lease
from layflat.rig.record import Layout
from layflat.rig.recorder.bag import Heading
from layflat.rig.recorder.client import RecorderClient
from layflat.rig.recorder.process import TakenError, part_of, start_recorder
from layflat.rig.recorder.ring import Ring
from layflat.rig.session import Session

PLACES = 100  # names that are tried, where other processes take them at the same time

PATIENCE = 20.0  # a recorder that has shown no sign of life for so long will not finish its log, s


def free_place(folder: Path, name: str) -> Path:
    """Return a place for a log that nothing has yet: NAME.mcap, NAME-2.mcap, and so on."""
    count = 1
    while any(folder.glob(f"{(stem := name if count == 1 else f'{name}-{count}')}.*")):
        count += 1
    return folder / f"{stem}.mcap"


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

    @classmethod
    def in_folder(
        cls,
        machine: Machine,
        driver: Callable[[], Driver],
        address: str,
        folder: Path,
        name: str,
        lease: Lease | None = None,
    ) -> Self:
        """Return one whose log has the first name that is free: NAME.mcap, NAME-2.mcap, and so on.

        Args:
            machine: what is driven.
            driver: makes its driver, in the loop's process.
            address: of the rig, for the log.
            folder: of the log.
            name: of the log, without its suffix.
            lease: as in `Session`.

        Raises:
            OutputError: no log can be written there.
        """
        for _ in range(PLACES):
            try:
                return cls(machine, driver, address, free_place(folder, name), lease)
            except TakenError:  # another process was faster
                continue
        right = "give another folder"
        raise OutputError("other runs take every name of a log", where=str(folder / name), right=right)

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
        part = part_of(self.place)
        if part.exists() and part.stat().st_size == 0:  # it never began
            part.unlink()
