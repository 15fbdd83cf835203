"""What operating systems do differently, processes share, and the machine grants one that must not be late."""

import ctypes
import gc
import os
import sys
import tempfile
import time
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

from layflat.errors import InputError

MAILBOX, RING = "layflat-rig-", "layflat-ring-"  # how the names of files of shared memory begin
YOUNG = 60.0  # for so long after it was made a file may be on its way to those who are going to lock it, s

PRIORITY = 50  # of SCHED_FIFO: above all that is not real-time itself, below the kernel's own threads for interrupts
LOCK_ALL = 3  # MCL_CURRENT | MCL_FUTURE of mlockall
TIMER_SLACK = 29  # PR_SET_TIMERSLACK of prctl


def require_posix(where: str) -> None:
    """Raise InputError on systems without pipes, terminals and shared files as Linux and macOS have them."""
    if os.name != "posix":
        right = "run it there; logs can be read, repaired and drawn here"
        raise InputError(f"needs Linux or macOS, this is {sys.platform}", where=where, right=right)


def lock(handle: int, *, shared: bool = False) -> None:
    """Lock an open file until it is closed; raise OSError if another process has it. Windows knows no shared locks."""
    try:
        import fcntl  # noqa: PLC0415  # not on every system
    except ImportError:
        import msvcrt  # noqa: PLC0415

        msvcrt.locking(handle, msvcrt.LK_NBLCK, 1)  # type: ignore[attr-defined]
        return
    fcntl.flock(handle, (fcntl.LOCK_SH if shared else fcntl.LOCK_EX) | fcntl.LOCK_NB)


def new_file(prefix: str, size: int) -> tuple[Path, int]:
    """Make a file of shared memory, locked and open, in memory where it can be; those of dead processes go first."""
    sweep(prefix)
    handle, name = tempfile.mkstemp(prefix=prefix, dir=_folder())
    lock(handle, shared=True)
    os.truncate(handle, size)
    return Path(name), handle


def _folder() -> Path:
    memory = Path("/dev/shm")
    return memory if os.access(memory, os.W_OK) else Path(tempfile.gettempdir())


def sweep(prefix: str) -> None:
    """Remove the memory of those who were killed: whoever has such a file open holds it locked."""
    least = YOUNG if prefix == MAILBOX else 0.0  # a mailbox changes hands before it is locked
    for path in _folder().glob(f"{prefix}*"):
        with suppress(OSError), path.open("r+b") as file:
            if time.time() - os.fstat(file.fileno()).st_mtime >= least:
                lock(file.fileno())
                path.unlink(missing_ok=True)


def go_realtime() -> list[str]:
    """Ask for all of it; a line for each thing that was not granted, with what would help."""
    gc.collect()
    gc.freeze()
    gc.disable()
    asked: list[tuple[Callable[[], None], str]] = [
        (first_in, "real-time priority (SCHED_FIFO); allow rtprio in /etc/security/limits.conf"),
        (_lock_memory, "memory that stays in place (mlockall); allow memlock in /etc/security/limits.conf"),
        (_own_processor, "a processor of its own (affinity); give it two processors or more"),
        (_exact_timers, "exact timers (timer slack); run it on Linux"),
    ]
    refused = []
    for ask, what in asked:
        try:
            ask()
        except (OSError, AttributeError):
            refused.append(f"not granted: {what}")
    return refused


def first_in() -> None:
    """Run before everything that is not real-time itself; raise OSError if that is not granted."""
    # What it starts is none of that: it would take the processor from all others.
    os.sched_setscheduler(0, os.SCHED_FIFO | os.SCHED_RESET_ON_FORK, os.sched_param(PRIORITY))


def _lock_memory() -> None:
    if ctypes.CDLL(None).mlockall(LOCK_ALL) != 0:
        raise OSError


def _own_processor() -> None:
    allowed = sorted(os.sched_getaffinity(0))
    if len(allowed) < 2:
        raise OSError
    os.sched_setaffinity(0, {allowed[-1]})


def _exact_timers() -> None:
    if ctypes.CDLL(None).prctl(TIMER_SLACK, 1, 0, 0, 0) != 0:
        raise OSError
