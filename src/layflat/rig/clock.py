"""Clocks of the loop, a real one and one that jumps to each deadline; deadlines and the statistics of their lateness.

All times are whole nanoseconds, so that a cycle is just as long at the end of a day as at its beginning.
"""

import time
from collections.abc import Callable
from typing import Protocol

import numpy as np

NS_PER_SECOND = 1_000_000_000  # ns
HISTOGRAM_BINS = (
    5000  # of the histograms of lateness and compute time, a microsecond each; the last one takes all that is later
)

# A punctual clock wakes this long before an instant (ns), starts no warmup later than this before it (ns), and makes at
# most so many warmups.
WAKE_LEAD, MIN_WARMUP_TIME, MAX_WARMUPS = 1_000_000, 250_000, 3


class LoopClock(Protocol):
    """Clock by which the loop sleeps."""

    def now(self) -> int:
        """Return the time since a fixed instant, ns; it never decreases."""

    def wait(self, until: int) -> None:
        """Return at `until` or as soon after it as may be; at once if it has passed."""


class MonotonicClock:
    """Monotonic clock of the computer, which changes of its time of day do not move."""

    def now(self) -> int:
        """Return the time since the computer started, ns."""
        return time.monotonic_ns()

    def wait(self, until: int) -> None:
        """Sleep until an instant, ns."""
        left = until - time.monotonic_ns()
        if left > 0:
            time.sleep(left / NS_PER_SECOND)


class PunctualClock(MonotonicClock):
    """Clock that wakes early, warms up the code of the coming cycle, and polls the time until the instant."""

    def __init__(self, warm_up: Callable[[], object]) -> None:
        self._warm_up = warm_up

    def wait(self, until: int) -> None:
        """Sleep until shortly before an instant (ns), warm up, and return at the instant."""
        super().wait(until - WAKE_LEAD)
        for _ in range(MAX_WARMUPS):
            if time.monotonic_ns() > until - MIN_WARMUP_TIME:
                break
            self._warm_up()
        while time.monotonic_ns() < until:
            pass


class VirtualClock:
    """Clock whose time passes only in `wait`: simulated hours take seconds, and are reproducible."""

    def __init__(self, start: int = 0) -> None:
        self._now = start

    def now(self) -> int:
        """Return the instant last waited for, ns."""
        return self._now

    def wait(self, until: int) -> None:
        """Advance to an instant (ns) at once."""
        self._now = max(self._now, until)


class Deadlines:
    """Deadlines, one every cycle (s). Those missed by more than a cycle are left out, not made up for."""

    def __init__(self, clock: LoopClock, cycle: float) -> None:
        self._clock, self._period = clock, round(cycle * NS_PER_SECOND)
        self.cycle = cycle
        self.begun: int | None = None  # when the first cycle began, ns
        self._next = self._now = 0
        self.elapsed = cycle  # between the starts of the last two cycles, s
        self.lateness = 0.0  # of this cycle, s
        self.missed = 0  # deadlines left out so far
        self.missed_now = 0  # deadlines left out just before this cycle
        self.reset_statistics()

    def wait(self) -> int:
        """Wait for the next deadline (the first call does not), and return the instant (ns) at which the cycle begins.

        It updates `elapsed`, `lateness`, the missed deadlines, and the histogram of the lateness.
        """
        clock = self._clock
        if self.begun is None:
            self.begun = self._next = now = clock.now()
        else:
            self._next += self._period
            clock.wait(self._next)
            now = clock.now()
            self.elapsed = (now - self._now) / NS_PER_SECOND
        late = now - self._next
        self.missed_now = late // self._period if late > 0 else 0
        if self.missed_now:
            self.missed += self.missed_now
            self._next += self.missed_now * self._period
        self._now = now
        self.lateness = late / NS_PER_SECOND
        self._late[min(max(late // 1000, 0), HISTOGRAM_BINS - 1)] += 1
        return now

    def record_compute_time(self, seconds: float) -> None:
        """Add the compute time of a cycle (s) to the histogram."""
        self._busy[min(int(seconds / 1e-6), HISTOGRAM_BINS - 1)] += 1

    def reset_statistics(self) -> None:
        """Clear both histograms, for instance after a cycle that loads compiled code; missed deadlines stay counted."""
        # Lists: incrementing an item is several times as fast as in an array.
        self._late, self._busy = [0] * HISTOGRAM_BINS, [0] * HISTOGRAM_BINS

    def lateness_at(self, fraction: float) -> float:
        """Return the quantile of the lateness at a fraction of the cycles, s."""
        return _quantile(self._late, fraction)

    def compute_at(self, fraction: float) -> float:
        """Return the quantile of the compute time at a fraction of the cycles, s."""
        return _quantile(self._busy, fraction)

    def summary(self) -> str:
        """Return a line for people: cycles, lateness, compute time and missed deadlines."""
        return (
            f"{sum(self._late)} cycles, late by {1e6 * self.lateness_at(0.5):.0f} us at the median and "
            f"{1e6 * self.lateness_at(0.99):.0f} us at 99 %, computed in {1e6 * self.compute_at(0.5):.0f} and "
            f"{1e6 * self.compute_at(0.99):.0f} us, {self.missed} deadlines missed"
        )


def _quantile(bins: list[int], fraction: float) -> float:
    """Return a quantile of a duration, s, from its histogram in bins of 1 us: the upper end of a bin; 0 if empty."""
    total = sum(bins)
    if total == 0:
        return 0.0
    return float(np.searchsorted(np.cumsum(bins), fraction * total) + 1) * 1e-6
