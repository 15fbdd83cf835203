from __future__ import annotations

from math import hypot, inf, pi

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from layflat.machine import load
from layflat.motion.kinematics import tip_position
from layflat.motion.limits import arm_limits
from layflat.motion.meeting import BRAKING_DECELERATION, MovingTarget, TargetLine, plan_meeting
from layflat.motion.planar import PlanarReach
from layflat.motion.trajectory import States, rest_states
from layflat.motion.travel import RATE_DEMANDS, tip_peaks

ARM = load("paper-arm-tracking")
REACH = PlanarReach(ARM)
LANE = TargetLine(REACH, (0.6, -0.23), pi / 2, 0.76)
HERE = rest_states(np.array([-0.4, 0.6]))
LIMITS = arm_limits(ARM, HERE.angles, np.array([0.5, 0.2])).scaled(*RATE_DEMANDS.limit_fractions)


def test_a_lane_knows_what_of_it_the_arm_reaches() -> None:
    assert LANE.path is not None
    for s in np.arange(0.0, 0.76, 0.01).tolist():
        assert bool(REACH.configurations(0.6, -0.23 + s)) == (LANE.low - 2e-3 <= s <= LANE.high + 2e-3)
    assert TargetLine(REACH, (2.0, 0.0), pi / 2, 0.5).path is None


@settings(max_examples=25, deadline=None)
@given(st.floats(0.0, 0.6), st.one_of(st.floats(-0.4, -0.05), st.just(0.0), st.floats(0.05, 0.4)))
def test_arm_and_point_meet_with_one_velocity(along: float, speed: float) -> None:
    course = MovingTarget(LANE, along, 10.0, speed)
    found = plan_meeting(ARM, HERE, 10.0, course, LIMITS, tip_speed=2.5)
    if found is None:
        assert speed * abs(speed) / (2 * BRAKING_DECELERATION) + abs(speed) * 0.6 > abs(course.end - along) or (
            course.entry_time > 10.0 + 2.0
        )
        return
    last, then = States(*(of[0] for of in found.motion.states([found.motion.duration]))), course.state(found.time)
    assert found.motion.duration == pytest.approx(found.time - 10.0, abs=1e-6)
    assert np.allclose(last, then, atol=1e-5)
    x, y = tip_position(ARM, last.angles).tolist()
    assert hypot(x - 0.6, y - (-0.23 + course.distance_at(found.time))) < 1e-6
    assert course.entry_time <= found.time <= course.braking_time
    assert tip_peaks(ARM, found.motion)[0] <= 2.5 * 1.02


def test_what_is_gone_is_not_met() -> None:
    assert plan_meeting(ARM, HERE, 0.0, MovingTarget(LANE, LANE.high - 0.02, 0.0, 0.4), LIMITS) is None
    assert plan_meeting(ARM, HERE, 0.0, MovingTarget(LANE, LANE.low - 0.3, 0.0, 0.0), LIMITS) is None


def test_an_arm_that_leaves_a_point_in_time_stops_within_its_reach() -> None:
    for speed in (0.4, -0.4):
        course = MovingTarget(LANE, 0.3, 0.0, speed)
        left = abs(course.end - course.distance_at(course.braking_time))
        assert left == pytest.approx(0.4**2 / (2 * BRAKING_DECELERATION))
    assert MovingTarget(LANE, 0.3, 0.0, 0.0).braking_time == inf
