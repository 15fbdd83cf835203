"""Session on a rig with a log of every cycle: recorder and loop, each in a process of its own, in the right order."""

import time
from collections.abc import Callable
from contextlib import AbstractContextManager, ExitStack
from functools import partial
from glob import escape
from pathlib import Path
from typing import Self

from layflat.errors import OutputError
from layflat.machine import Machine
from layflat.rig.clock import NS_PER_SECOND
from layflat.rig.driver import Driver
from layflat.rig.process import RecorderClient
from layflat.rig.record import RowLayout
from layflat.rig.recorder.bag import LogHeading
from layflat.rig.recorder.process import LogExistsError, part_path, start_recorder
from layflat.rig.recorder.ring import Ring
from layflat.rig.session import HostLease, RigSession

MAX_NAME_ATTEMPTS = 100  # names that are tried where other processes create logs at the same time

RECORDER_TIMEOUT = 20.0  # without a heartbeat, after which a recorder is killed, s


def free_log_path(folder: Path, name: str) -> Path:
    """Return the first of NAME.mcap, NAME-2.mcap, ... of whose stem the folder holds no file, whatever its suffix."""
    count = 1
    while any(folder.glob(f"{escape(stem := name if count == 1 else f'{name}-{count}')}.*")):
        count += 1
    return folder / f"{stem}.mcap"


class RecordedSession(AbstractContextManager["RecordedSession"]):
    """Session with its recorder: `with RecordedSession(...) as rig: rig.session.start()`; see `RigSession`.

    Args:
        machine: description of the rig.
        driver: factory of its driver, called in the loop's process.
        address: address of the rig, for the log.
        place: path of the log, NAME.mcap.
        lease: lease, as in `RigSession`.

    Raises:
        OutputError: the log can't be written.
        RigLoopError: the loop failed to start.
    """

    def __init__(
        self, machine: Machine, driver: Callable[[], Driver], address: str, place: Path, lease: HostLease | None = None
    ) -> None:
        self.machine, self.place = machine, place
        with ExitStack() as begun:
            self._ring = Ring.create(RowLayout.for_machine(machine).width)
            begun.callback(self._ring.close)
            begun.callback(self._ring.remove)
            self.recorder = start_recorder(self._ring, place, LogHeading.for_machine(machine, driver=address))
            begun.callback(self._finish)
            client = partial(RecorderClient.join, self._ring.path)
            self.session = begun.enter_context(RigSession(machine, driver, client, lease))
            self._begun = begun.pop_all()

    @property
    def is_recording(self) -> bool:
        """Return whether the recorder runs."""
        return self.recorder.is_alive()

    @property
    def part(self) -> Path | None:
        """Return the file that the recorder left without finishing it; None if there is none."""
        part = part_path(self.place)
        return part if part.exists() else None

    @classmethod
    def in_folder(
        cls,
        machine: Machine,
        driver: Callable[[], Driver],
        address: str,
        folder: Path,
        name: str,
        lease: HostLease | None = None,
    ) -> Self:
        """Return a session whose log has the first name that is free: NAME.mcap, NAME-2.mcap, and so on.

        Args:
            machine: description of the rig.
            driver: factory of its driver, called in the loop's process.
            address: address of the rig, for the log.
            folder: folder of the log.
            name: name of the log, without its suffix.
            lease: lease, as in `RigSession`.

        Raises:
            OutputError: no log can be written there.
            RigLoopError: the loop failed to start.
        """
        for _ in range(MAX_NAME_ATTEMPTS):
            try:
                return cls(machine, driver, address, free_log_path(folder, name), lease)
            except LogExistsError:  # another process was faster
                continue
        right = "give another folder"
        raise OutputError("other runs take every name of a log", where=str(folder / name), right=right)

    def close(self) -> None:
        """Stop; wait until the air is out, the loop has ended, and the log is whole. A second call does nothing."""
        self._begun.close()

    def __exit__(self, *_: object) -> None:
        self.close()

    def _finish(self) -> None:
        """Wait until the recorder finishes; kill it after `RECORDER_TIMEOUT` without a heartbeat. Remove empty logs."""
        ring, recorder = self._ring, self.recorder
        ring.end()
        begun = time.monotonic_ns()
        while recorder.is_alive():
            recorder.join(0.1)
            if time.monotonic_ns() - max(begun, ring.head.recorder_beat) > RECORDER_TIMEOUT * NS_PER_SECOND:
                recorder.kill()
        part = part_path(self.place)
        if part.exists() and part.stat().st_size == 0:  # it never began
            part.unlink()
