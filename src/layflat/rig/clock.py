"""Clocks that the loop is given, a real one and one that jumps to each deadline; and how well deadlines are kept.

All times are whole nanoseconds, so that a cycle is just as long at the end of a day as at its beginning.
"""

import time
from collections.abc import Callable
from typing import Protocol

import numpy as np

SECOND = 1_000_000_000  # ns
BINS = 5000  # of the histograms of lateness and compute time, a microsecond each; the last one takes all that is later

# A punctual clock wakes so early before an instant (ns), begins no warmup later than so, makes so many of them.
LEAD, LATEST, TIMES = 1_000_000, 250_000, 3


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
    """One that wakes early and gets everything ready: it warms up what comes, and watches the time until it comes."""

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


class Deadlines:
    """A deadline every cycle (s). Those that were missed by more than a cycle are left out, not made up for."""

    def __init__(self, clock: Clock, cycle: float) -> None:
        self._clock, self._period = clock, round(cycle * SECOND)
        self.cycle = cycle
        self.begun: int | None = None  # when the first cycle began, ns
        self._next = self._now = 0
        self.elapsed = cycle  # between the starts of the last two cycles, s
        self.lateness = 0.0  # of this cycle, s
        self.missed = 0  # deadlines left out so far
        self.missed_now = 0  # deadlines left out just before this cycle
        self.forget()

    def wait(self) -> int:
        """Wait for the next deadline; the instant (ns) at which the cycle begins."""
        clock = self._clock
        if self.begun is None:
            self.begun = self._next = now = clock.now()
        else:
            self._next += self._period
            clock.wait(self._next)
            now = clock.now()
            self.elapsed = (now - self._now) / SECOND
        late = now - self._next
        self.missed_now = late // self._period if late > 0 else 0
        if self.missed_now:
            self.missed += self.missed_now
            self._next += self.missed_now * self._period
        self._now = now
        self.lateness = late / SECOND
        self._late[min(max(late // 1000, 0), BINS - 1)] += 1
        return now

    def took(self, seconds: float) -> None:
        """Note how long a cycle took to compute."""
        self._busy[min(int(seconds / 1e-6), BINS - 1)] += 1

    def forget(self) -> None:
        """Begin the statistics anew, for instance after a first cycle that loads compiled code."""
        # Lists, of which an item is counted up several times as fast as an array's.
        self._late, self._busy = [0] * BINS, [0] * BINS

    def lateness_at(self, share: float) -> float:
        """Lateness that this share of the cycles kept below, s."""
        return _quantile(self._late, share)

    def compute_at(self, share: float) -> float:
        """Compute time that this share of the cycles kept below, s."""
        return _quantile(self._busy, share)

    def summary(self) -> str:
        """A line for people."""
        return (
            f"{sum(self._late)} cycles, late by {1e6 * self.lateness_at(0.5):.0f} us at the median and "
            f"{1e6 * self.lateness_at(0.99):.0f} us at 99 %, computed in {1e6 * self.compute_at(0.5):.0f} and "
            f"{1e6 * self.compute_at(0.99):.0f} us, {self.missed} deadlines missed"
        )


def _quantile(bins: list[int], share: float) -> float:
    total = sum(bins)
    if total == 0:
        return 0.0
    return float(np.searchsorted(np.cumsum(bins), share * total) + 1) * 1e-6
