"""The detectors one by one; whole machines are watched in tests/rig."""

from math import inf, nan

import numpy as np
import pytest

from layflat.control import watch
from layflat.control.watch import FRESH, Limits, Patience, WatchMemory, watch_joint

CYCLE = 0.005
LIMITS = Limits(-1.3, 1.3, 6e-4, 1.2, 14.0, 5e5, 1e5, 0.6, 0.1, 1.0, 0.25, 1000.0, 1.0)
PATIENCE = Patience(3, 2, 2, 2, 0.09, 0.09, 0.09, 0.17, 0.0125, 0.0375, 0.29, 0.6)
SWING = (2000.0, 0.0, -2000.0, 0.0)


def follow(
    samples: int, angle: list[float], *, pressure: list[float] | None = None, demand: float | None = None,
    surplus: float = 0.0, level: int = watch.AIR,
    averaged: float = 0.0, others: float = 0.0,
) -> tuple[WatchMemory, list[int]]:  # fmt: skip
    memory, found = FRESH, []
    for k in range(samples):
        x = angle[k % len(angle)]
        p = pressure[k % len(pressure)] if pressure else SWING[k % 4] + 0.3 * k
        memory, bits = watch_joint(
            LIMITS, PATIENCE, memory, x, p, averaged * k, others * k, 0.0, surplus, x if demand is None else demand,
            0.0, CYCLE, level, True,
        )  # fmt: skip
        found.append(bits)
    return memory, found


def test_a_sound_joint_at_rest_has_no_fault() -> None:
    memory, found = follow(400, [0.5])
    assert not any(found)
    assert memory.ripple == pytest.approx(2000.0, rel=1e-3)


@pytest.mark.parametrize("slope", [0.0, 3000.0])
def test_ripple_is_that_of_the_dither_whatever_the_slope(slope: float) -> None:
    memory, _ = follow(20, [0.0], pressure=[SWING[k % 4] + slope * k for k in range(20)])
    assert memory.ripple == pytest.approx(2000.0)


@pytest.mark.parametrize("bad", [-1.3, 1.3, nan, inf])
def test_the_rail_counts_samples_with_or_without_air(bad: float) -> None:
    for level in (watch.SENSORS, watch.AIR):
        assert follow(3, [bad], level=level)[1][:2] == [0, 0]
        assert follow(3, [bad], level=level)[1][2] & watch.AT_RAIL


def test_a_pressure_that_is_not_a_number_is_at_fault() -> None:
    assert follow(2, [0.0], pressure=[nan], level=watch.SENSORS)[1] == [0, watch.PRESSED]


def test_speed_and_stroke_count_where_the_joint_may_move() -> None:
    leap = [0.0, 0.08, 0.16, 0.24, 0.32]
    assert follow(4, leap, level=watch.MOTION)[1] == [0, 0, watch.FAST, watch.FAST]
    assert not any(follow(4, leap, level=watch.SENSORS)[1])
    assert follow(2, [1.21, 1.2101], level=watch.MOTION)[1] == [0, watch.OUTSIDE]
    assert follow(2, [1.25, 1.31], level=watch.MOTION)[1] == [0, watch.OUTSIDE], "it went on to the rail"


@pytest.mark.parametrize("when", np.linspace(0.0, 0.9, 10))
@pytest.mark.parametrize("rate", [200.0, 500.0])
def test_a_joint_that_speeds_up_is_found_two_samples_after_it_is_too_fast(when: float, rate: float) -> None:
    times = CYCLE * (np.arange(14.0) - 10.0 + when)
    speeds = LIMITS.speed + rate * times
    angles = np.where(speeds > 0.0, speeds**2, 0.0) / (2.0 * rate)
    found = follow(len(angles), list(angles - angles.max()), level=watch.MOTION)[1]
    first, last = int(np.argmax(times > 0.0)), int(np.argmax([bool(bits & watch.FAST) for bits in found]))
    assert first <= last <= first + 1


def test_a_pressure_that_repeats_itself_is_found() -> None:
    found = follow(40, [0.1, 0.1006], pressure=[500.0])[1]
    assert (np.flatnonzero(found)[0] + 1) * CYCLE <= 0.1
    assert found[int(np.flatnonzero(found)[0])] == watch.PRESSURE_FROZEN


def test_too_much_air_is_no_answer() -> None:
    assert follow(5, [0.5, 0.5006], surplus=0.26)[1][-1] & watch.VALVE_UNRESPONSIVE
    assert not any(follow(5, [0.5, 0.5006], surplus=-0.24)[1])


def test_a_joint_that_stands_still_at_once_has_a_frozen_sensor() -> None:
    found = follow(30, [0.0, 0.004, 0.008, *[0.012] * 27])[1]
    assert np.flatnonzero(found)[0] == 11
    assert found[11] == watch.ANGLE_FROZEN


def test_a_joint_that_bears_more_than_friction_is_blocked_unless_others_hold_it() -> None:
    """A rise by 10 kPa a sample: friction hides 100 kPa, and nearly twice that is borne."""
    found = follow(40, [0.5], averaged=1e4)[1]
    first = int(np.flatnonzero(found)[0])
    assert found[first] == watch.ANGLE_FROZEN
    assert first * CYCLE == pytest.approx(0.1, abs=0.01)
    assert not any(follow(40, [0.5], averaged=1e4, others=9e3)[1])
    assert not any(follow(40, [0.5], averaged=1e3, others=9e3)[1]), "others that are held themselves shake nothing"


def test_a_driven_joint_that_stays_where_it_is_but_for_noise_is_blocked() -> None:
    noise = [0.0, 0.0007]
    found = follow(200, noise, demand=0.2)[1]
    first = int(np.flatnonzero(found)[0])
    assert found[first] == watch.ANGLE_FROZEN
    assert first * CYCLE == pytest.approx(0.6, abs=0.02)
    assert not any(follow(200, noise, demand=0.05)[1])


def test_a_step_is_no_following_error_and_a_joint_left_behind_is() -> None:
    ramp = [0.005 * k for k in range(200)]
    assert not any(follow(200, ramp, demand=1.0)[1])
    slow = [0.0, 0.002]
    found = follow(400, slow, demand=1.0)[1]
    first = int(np.flatnonzero(found)[0])
    assert found[first] == watch.OFF_TRACK
    assert first * CYCLE == pytest.approx(0.6 + 0.09, abs=0.02)
