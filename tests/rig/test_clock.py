import pytest

from layflat.rig.clock import NS_PER_SECOND, Deadlines, VirtualClock


class LateClock(VirtualClock):
    """Comes late by what it is told, once."""

    late = 0

    def wait(self, until: int) -> None:
        super().wait(until + self.late)
        self.late = 0


def test_deadlines_stand_and_missed_ones_are_left_out() -> None:
    clock = LateClock(7)
    deadlines = Deadlines(clock, 0.005)
    assert deadlines.wait() == 7
    clock.late = 1_000_000
    assert deadlines.wait() == 6_000_007
    assert (deadlines.lateness, deadlines.missed, deadlines.elapsed) == (0.001, 0, 0.006)
    assert deadlines.wait() == 10_000_007
    assert deadlines.elapsed == 0.004
    clock.late = 12_000_000
    assert deadlines.wait() == 27_000_007
    assert (deadlines.missed_now, deadlines.missed) == (2, 2)
    assert deadlines.wait() == 30_000_007
    assert deadlines.missed_now == 0


def test_a_day_of_cycles_does_not_drift() -> None:
    clock = VirtualClock()
    deadlines = Deadlines(clock, 0.005)
    for _ in range(1001):
        deadlines.wait()
    assert clock.now() == 5 * NS_PER_SECOND
    assert deadlines.elapsed == 0.005


def test_statistics_are_quantiles() -> None:
    deadlines = Deadlines(VirtualClock(), 0.005)
    for microseconds in range(100):
        deadlines.record_compute_time(1e-6 * microseconds + 0.5e-6)
    assert deadlines.compute_at(0.5) == pytest.approx(50e-6)
    assert deadlines.compute_at(0.99) == pytest.approx(99e-6)
    assert deadlines.lateness_at(0.5) == 0.0
