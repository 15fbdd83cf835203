"""Operating system: locks, files of shared memory, and the privileges of a real-time process."""

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

MAILBOX_PREFIX, RING_PREFIX = "layflat-rig-", "layflat-ring-"  # prefixes of files of shared memory
MIN_MAILBOX_AGE = 60.0  # before which an unlocked mailbox may be on its way to the process that will lock it, s

FIFO_PRIORITY = 50  # of SCHED_FIFO: above all that is not real-time, below the kernel's threads for interrupts
MLOCK_FLAGS = 3  # MCL_CURRENT | MCL_FUTURE of mlockall
PR_SET_TIMERSLACK = 29  # PR_SET_TIMERSLACK of prctl


def require_posix(where: str) -> None:
    """Raise InputError on systems without pipes, terminals and shared files as Linux and macOS have them."""
    if os.name != "posix":
        right = "run it there; logs can be read, repaired and drawn here"
        raise InputError(f"needs Linux or macOS, this is {sys.platform}", where=where, right=right)


def lock_file(handle: int, *, shared: bool = False) -> None:
    """Lock an open file until it is closed (on Windows always exclusively); raise OSError if another process has it."""
    try:
        import fcntl  # noqa: PLC0415  # not on every system
    except ImportError:
        import msvcrt  # noqa: PLC0415

        msvcrt.locking(handle, msvcrt.LK_NBLCK, 1)  # type: ignore[attr-defined]
        return
    fcntl.flock(handle, (fcntl.LOCK_SH if shared else fcntl.LOCK_EX) | fcntl.LOCK_NB)


def create_shared_file(prefix: str, size: int) -> tuple[Path, int]:
    """Create a file of shared memory, after removing those of dead processes.

    Returns:
        Its path, in /dev/shm where that is writable, and its handle, open and with a shared lock.
    """
    remove_orphaned_files(prefix)
    handle, name = tempfile.mkstemp(prefix=prefix, dir=_shared_memory_folder())
    lock_file(handle, shared=True)
    os.truncate(handle, size)
    return Path(name), handle


def _shared_memory_folder() -> Path:
    """Return /dev/shm where it is writable, else the folder of temporary files."""
    memory = Path("/dev/shm")
    return memory if os.access(memory, os.W_OK) else Path(tempfile.gettempdir())


def remove_orphaned_files(prefix: str) -> None:
    """Remove the files of shared memory that no process holds locked; mailboxes only from `MIN_MAILBOX_AGE` on."""
    min_age = MIN_MAILBOX_AGE if prefix == MAILBOX_PREFIX else 0.0  # a mailbox changes hands before it is locked
    for path in _shared_memory_folder().glob(f"{prefix}*"):
        with suppress(OSError), path.open("r+b") as file:
            if time.time() - os.fstat(file.fileno()).st_mtime >= min_age:
                lock_file(file.fileno())
                path.unlink(missing_ok=True)


def go_realtime() -> list[str]:
    """Request real-time priority, locked memory, a processor and exact timers, and switch off garbage collection.

    Returns:
        A line for each request that was not granted, with its remedy.
    """
    gc.collect()
    gc.freeze()
    gc.disable()
    requests: list[tuple[Callable[[], None], str]] = [
        (set_fifo_priority, "real-time priority (SCHED_FIFO); allow rtprio in /etc/security/limits.conf"),
        (_lock_memory, "memory that stays in place (mlockall); allow memlock in /etc/security/limits.conf"),
        (_pin_to_processor, "a processor of its own (affinity); give it two processors or more"),
        (_set_timer_slack, "exact timers (timer slack); run it on Linux"),
    ]
    refused = []
    for request, what in requests:
        try:
            request()
        except (OSError, AttributeError):
            refused.append(f"not granted: {what}")
    return refused


def set_fifo_priority() -> None:
    """Set real-time scheduling (SCHED_FIFO) for this process; raise OSError if that is not granted."""
    # Not for its children: they would take the processor from all others.
    os.sched_setscheduler(0, os.SCHED_FIFO | os.SCHED_RESET_ON_FORK, os.sched_param(FIFO_PRIORITY))


def _lock_memory() -> None:
    """Keep all memory of this process, future pages too, out of the swap; raise OSError if that is not granted."""
    if ctypes.CDLL(None).mlockall(MLOCK_FLAGS) != 0:
        raise OSError


def _pin_to_processor() -> None:
    """Pin this process to the last processor that it may use; raise OSError if there is only one."""
    allowed = sorted(os.sched_getaffinity(0))
    if len(allowed) < 2:
        raise OSError
    os.sched_setaffinity(0, {allowed[-1]})


def _set_timer_slack() -> None:
    """Set the timer slack of this thread to 1 ns; raise OSError if that is not granted."""
    if ctypes.CDLL(None).prctl(PR_SET_TIMERSLACK, 1, 0, 0, 0) != 0:
        raise OSError
