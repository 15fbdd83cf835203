"""What the machine grants a process that must not be late; where it does not, a line says so."""

from __future__ import annotations

import ctypes
import gc
import os
from collections.abc import Callable

PRIORITY = 50
"""Of SCHED_FIFO: above everything that is not real-time itself, below the kernel's own threads for interrupts."""

LOCK_ALL = 3
"""MCL_CURRENT | MCL_FUTURE of mlockall."""

TIMER_SLACK = 29
"""PR_SET_TIMERSLACK of prctl."""


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
    """Run before everything that is not real-time itself.

    Raises:
        OSError: that is not granted.
    """
    os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(PRIORITY))


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
