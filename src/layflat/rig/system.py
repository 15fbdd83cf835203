"""What operating systems do differently: locks of files, processors, signals of a terminal."""

from __future__ import annotations

import os
import signal
import sys

from layflat.errors import InputError

FROM_TERMINAL = [getattr(signal, name) for name in ("SIGINT", "SIGHUP") if hasattr(signal, name)]
"""Signals that a terminal sends to all of its processes."""


def require_posix(where: str) -> None:
    """Refuse what takes pipes, terminals and shared files as Linux and macOS have them.

    Args:
        where: what needs them: a command.

    Raises:
        InputError: this is another system.
    """
    if os.name != "posix":
        right = "run it there; logs can be read, repaired and drawn here"
        raise InputError(f"needs Linux or macOS, this is {sys.platform}", where=where, right=right)


def lock(handle: int, *, shared: bool = False) -> None:
    """Lock an open file until it is closed; on Windows nobody shares a lock.

    Raises:
        OSError: another process has it locked.
    """
    try:
        import fcntl  # noqa: PLC0415  # not on every system
    except ImportError:
        import msvcrt  # noqa: PLC0415

        msvcrt.locking(handle, msvcrt.LK_NBLCK, 1)  # type: ignore[attr-defined]
        return
    fcntl.flock(handle, (fcntl.LOCK_SH if shared else fcntl.LOCK_EX) | fcntl.LOCK_NB)


def processors() -> int:
    """Return how many processors this process may use."""
    try:
        return len(os.sched_getaffinity(0))
    except AttributeError:  # only Linux tells
        return os.cpu_count() or 1
