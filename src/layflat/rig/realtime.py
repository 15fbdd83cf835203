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
    asked: list[tuple[str, Callable[[], None], str]] = [
        ("real-time priority (SCHED_FIFO)", first_in, "allow rtprio in /etc/security/limits.conf"),
        ("memory that stays in place (mlockall)", _lock_memory, "allow memlock in /etc/security/limits.conf"),
        ("a processor of its own (affinity)", _own_processor, "give it two processors or more"),
        ("exact timers (timer slack)", _exact_timers, "run it on Linux"),
    ]
    refused = []
    for what, ask, help_ in asked:
        try:
            ask()
        except (OSError, AttributeError):
            refused.append(f"not granted: {what}; {help_}")
    return refused


def first_in() -> None:
    """Run before everything that is not real-time itself.

    Raises:
        OSError: that is not granted.
    """
    os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(PRIORITY))


def _call(name: str, *args: int) -> None:
    if getattr(ctypes.CDLL(None, use_errno=True), name)(*args) != 0:
        raise OSError(ctypes.get_errno(), name)


def _lock_memory() -> None:
    _call("mlockall", LOCK_ALL)


def _own_processor() -> None:
    allowed = sorted(os.sched_getaffinity(0))
    if len(allowed) < 2:
        raise OSError("there is one only")
    os.sched_setaffinity(0, {allowed[-1]})


def _exact_timers() -> None:
    _call("prctl", TIMER_SLACK, 1, 0, 0, 0)
