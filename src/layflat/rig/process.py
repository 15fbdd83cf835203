"""The loop in a process of its own: what runs there, and how it begins and ends."""

from __future__ import annotations

import contextlib
import hashlib
import signal
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from multiprocessing.connection import Connection
from pathlib import Path
from typing import IO, Protocol

from layflat.errors import InputError, LayflatError
from layflat.machine import Machine
from layflat.rig import system
from layflat.rig.capabilities import check_capabilities
from layflat.rig.clock import LEAD, SECOND, MonotonicClock, PunctualClock
from layflat.rig.driver import Driver
from layflat.rig.law import layout_of
from layflat.rig.loop import Loop, NoRecorder, Recorder
from layflat.rig.mailbox import Mailbox, RemoteHost
from layflat.rig.realtime import go_realtime
from layflat.rig.system import processors
from layflat.rig.warmup import WarmupLoop

LEADS = 4
"""Shorter cycles than so many leads of a punctual clock leave others too little of a processor."""


class Keeper(Recorder, Protocol):
    """A recorder that has to be told when the loop has ended."""

    def end(self) -> object:
        """Nothing more will come."""
        ...


@dataclass(frozen=True)
class Job:
    """What the loop's process is given; everything in it can be pickled.

    Args:
        machine: with controller.
        driver: makes the driver, in the process.
        mailbox: file shared with the host.
        rig: what names the rig, such as the driver's address; one loop at a time may have it.
        recorder: makes the end of the recorder that takes rows, in the process.
        realtime: whether to ask for priority and locked memory.
    """

    machine: Machine
    driver: Callable[[], Driver]
    mailbox: Path
    rig: str
    recorder: Callable[[], Keeper] | None = None
    realtime: bool = True


@dataclass(frozen=True)
class LoopMessage:
    """What the process says: that it runs, that it failed, or that it ended."""

    kind: str
    """"running", "failed" or "ended"."""
    lines: tuple[str, ...] = ()


def run_loop(job: Job, pipe: Connection) -> None:
    """Main function of the process: loop until the host has ended or died, and the air is out."""
    # Ctrl-C goes to all processes of a terminal; the host turns it into a controlled stop.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        with lock(job.rig):
            lines = _loop(job, pipe)
        said = LoopMessage("ended", lines)
    except LayflatError as error:
        said = LoopMessage("failed", (str(error),))
    except Exception as error:  # whatever happens, the host is told; the device centres by itself
        said = LoopMessage("failed", (f"the loop broke: {type(error).__name__}: {error}",))
    job.mailbox.unlink(missing_ok=True)  # who has it open keeps it; the host may be gone
    with contextlib.suppress(OSError):  # the host may be gone
        pipe.send(said)


def _loop(job: Job, pipe: Connection) -> tuple[str, ...]:
    machine = job.machine
    clock, mailbox = _clock(job), Mailbox(job.mailbox, layout_of(machine))
    driver = job.driver()
    recorder: Keeper = job.recorder() if job.recorder is not None else NoRecorder()
    try:
        check_capabilities(machine, driver.configure())
        loop = Loop(machine, driver, clock, RemoteHost(mailbox, clock, len(machine.joints)), recorder)
        refused = go_realtime() if job.realtime else []
        for line in refused:
            recorder.event(line)
        driver.activate()
        pipe.send(LoopMessage("running", tuple(refused)))
        loop.run()
        return (loop.deadlines.summary(),)
    finally:
        driver.finalize()
        recorder.end()
        mailbox.close()


def _clock(job: Job) -> MonotonicClock:
    """A punctual one where a processor can be had for it; what the first cycle calls is loaded in any case."""
    warmup = WarmupLoop(job.machine)
    assert job.machine.controller is not None  # the warmup needed it too
    spare = job.machine.controller.cycle * SECOND >= LEADS * LEAD and processors() > 1
    return PunctualClock(warmup) if job.realtime and spare else MonotonicClock()


def lock(rig: str) -> IO[str]:
    """Take a rig for this process alone; it is free again when the file closes, or the process dies.

    Raises:
        InputError: another loop has it.
    """
    digest = hashlib.sha256(rig.encode()).hexdigest()[:12]
    path = Path(tempfile.gettempdir()) / f"layflat-rig-{digest}.lock"
    try:
        file = path.open("w", encoding="utf-8")
    except OSError as error:
        raise InputError(
            f"can't be locked ({error.strerror}: {path})", where=rig, right="run it as its owner"
        ) from None
    try:
        system.lock(file.fileno())
    except OSError:
        file.close()
        raise InputError("another loop runs this rig", where=rig, right="stop that one first") from None
    return file
