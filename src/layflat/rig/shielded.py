"""Processes that Ctrl-C does not reach: it goes to all of a terminal, and their host alone decides what it means."""

from __future__ import annotations

import signal
from collections.abc import Iterator
from contextlib import contextmanager

from layflat.rig.system import FROM_TERMINAL


@contextmanager
def shielded() -> Iterator[None]:
    """Processes that are started in here never hear the terminal, not even before their first line has run."""
    before = signal.pthread_sigmask(signal.SIG_BLOCK, FROM_TERMINAL)
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
