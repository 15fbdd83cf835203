from __future__ import annotations

from math import hypot, inf, pi

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from layflat.machine import load
from layflat.motion.following import BY_RATES
from layflat.motion.kinematics import tip_position
from layflat.motion.limits import arm_limits
from layflat.motion.meeting import BRAKING, Course, Lane, meet
from layflat.motion.reach import Reach
from layflat.motion.trajectory import States, at_rest
from layflat.motion.travel import tip_peaks

ARM = load("paper-arm-tracking")
REACH = Reach(ARM)
LANE = Lane(REACH, (0.6, -0.23), pi / 2, 0.76)
HERE = at_rest(np.array([-0.4, 0.6]))
LIMITS = arm_limits(ARM, HERE.angles, np.array([0.5, 0.2])).shares(*BY_RATES.shares)


def test_a_lane_knows_what_of_it_the_arm_reaches() -> None:
    assert LANE.path is not None
    for s in np.arange(0.0, 0.76, 0.01).tolist():
        assert bool(REACH.postures(0.6, -0.23 + s)) == (LANE.low - 2e-3 <= s <= LANE.high + 2e-3)
    assert Lane(REACH, (2.0, 0.0), pi / 2, 0.5).path is None


@settings(max_examples=25, deadline=None)
@given(st.floats(0.0, 0.6), st.one_of(st.floats(-0.4, -0.05), st.just(0.0), st.floats(0.05, 0.4)))
def test_arm_and_point_meet_with_one_velocity(along: float, speed: float) -> None:
    course = Course(LANE, along, 10.0, speed)
    found = meet(ARM, HERE, 10.0, course, LIMITS, tip_speed=2.5)
    if found is None:
        assert speed * abs(speed) / (2 * BRAKING) + abs(speed) * 0.6 > abs(course.end - along) or (
            course.enters > 10.0 + 2.0
        )
        return
    last, then = States(*(of[0] for of in found.way.states([found.way.duration]))), course.state(found.time)
    assert found.way.duration == pytest.approx(found.time - 10.0, abs=1e-6)
    assert np.allclose(last, then, atol=1e-5)
    x, y = tip_position(ARM, last.angles).tolist()
    assert hypot(x - 0.6, y - (-0.23 + course.place(found.time))) < 1e-6
    assert course.enters <= found.time <= course.leaves
    assert tip_peaks(ARM, found.way)[0] <= 2.5 * 1.02


def test_what_is_gone_is_not_met() -> None:
    assert meet(ARM, HERE, 0.0, Course(LANE, LANE.high - 0.02, 0.0, 0.4), LIMITS) is None
    assert meet(ARM, HERE, 0.0, Course(LANE, LANE.low - 0.3, 0.0, 0.0), LIMITS) is None


def test_an_arm_that_leaves_a_point_in_time_stops_within_its_reach() -> None:
    for speed in (0.4, -0.4):
        course = Course(LANE, 0.3, 0.0, speed)
        left = abs(course.end - course.place(course.leaves))
        assert left == pytest.approx(0.4**2 / (2 * BRAKING))
    assert Course(LANE, 0.3, 0.0, 0.0).leaves == inf
