"""Clocks that the loop is given: a real one, and one that jumps to each deadline.

All times are whole nanoseconds, so that a cycle is just as long at the end of a day as at its beginning.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Protocol

SECOND = 1_000_000_000
"""ns"""

LEAD, LATEST, TIMES = 1_000_000, 250_000, 3
"""A punctual clock wakes so early before an instant (ns), begins no warmup later than so, makes so many of them."""


class Clock(Protocol):
    """What the loop sleeps by."""

    def now(self) -> int:
        """Nanoseconds since some instant; it never runs backwards."""

    def wait(self, until: int) -> None:
        """Return at `until` or as soon after it as may be; at once if it has passed."""


class MonotonicClock:
    """The machine's own; not moved by anyone who sets its time of day."""

    def now(self) -> int:
        """Nanoseconds since the machine started."""
        return time.monotonic_ns()

    def wait(self, until: int) -> None:
        """Sleep until an instant."""
        left = until - time.monotonic_ns()
        if left > 0:
            time.sleep(left / SECOND)


class PunctualClock(MonotonicClock):
    """One that wakes early and gets everything ready: it warms up what comes, and watches the time until it comes.

    Args:
        warm_up: the first time it takes long, each time after that less.
    """

    def __init__(self, warm_up: Callable[[], object]) -> None:
        self._warm_up = warm_up

    def wait(self, until: int) -> None:
        """Sleep until shortly before an instant, warm_up, and return at the instant."""
        super().wait(until - LEAD)
        for _ in range(TIMES):
            if time.monotonic_ns() > until - LATEST:
                break
            self._warm_up()
        while time.monotonic_ns() < until:
            pass


class VirtualClock:
    """Time that passes only while somebody waits: hours in seconds, and always the same."""

    def __init__(self, start: int = 0) -> None:
        self._now = start

    def now(self) -> int:
        """Nanoseconds, as last waited for."""
        return self._now

    def wait(self, until: int) -> None:
        """Be there at once."""
        self._now = max(self._now, until)
