"""The cell's clock against a clock that tests advance."""

from math import isnan

import pytest

from layflat.pages.cell.watcher import MAX_CATCH_UP, PACE_WINDOW, Pace


class Clock:
    """Time that passes while somebody sleeps, or as a test says."""

    def __init__(self) -> None:
        self.time = 100.0

    def now(self) -> float:
        return self.time

    def sleep(self, seconds: float) -> None:
        assert seconds >= 0.0
        self.time += seconds


@pytest.fixture
def clock() -> Clock:
    return Clock()


@pytest.fixture
def pace(clock: Clock) -> Pace:
    return Pace(clock.now, clock.sleep)


def test_what_computes_quickly_is_held_to_real_time(pace: Pace, clock: Clock) -> None:
    for cycle in range(1, 401):
        clock.time += 0.001
        pace.hold(0.005 * cycle, fast=False)
    assert clock.time == pytest.approx(102.0)


def test_a_short_delay_is_made_up_for_and_a_long_one_is_not(pace: Pace, clock: Clock) -> None:
    clock.time += 0.5 * MAX_CATCH_UP
    pace.hold(0.01, fast=False)
    pace.hold(1.0, fast=False)
    assert clock.time == pytest.approx(101.0)
    clock.time += 7.0
    pace.hold(1.01, fast=False)
    pace.hold(2.01, fast=False)
    assert clock.time == pytest.approx(109.0)


def test_nothing_waits_where_it_is_to_go_fast_nor_later_for_what_was_gained(pace: Pace, clock: Clock) -> None:
    pace.hold(50.0, fast=True)
    assert clock.time == 100.0
    pace.hold(50.5, fast=False)
    assert clock.time == pytest.approx(100.5)


def test_a_delivery_begins_at_nought(pace: Pace, clock: Clock) -> None:
    pace.hold(3.0, fast=False)
    clock.time += 5.0
    pace.begin_delivery()
    pace.hold(1.0, fast=False)
    assert clock.time == pytest.approx(109.0)


def test_the_pace_is_that_of_the_last_seconds(pace: Pace, clock: Clock) -> None:
    assert isnan(pace.ratio(0.0))
    clock.time += 1.0
    assert pace.ratio(3.0) == pytest.approx(3.0)
    for second in range(1, 5):
        clock.time += PACE_WINDOW / 2
        assert pace.ratio(3.0 + 0.5 * second * PACE_WINDOW / 2) >= 0.5 - 1e-9
    assert pace.ratio(3.0 + PACE_WINDOW) == pytest.approx(0.5)
