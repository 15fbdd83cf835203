from math import inf

import numpy as np
import pytest
import ruckig
from hypothesis import given
from hypothesis import strategies as st

from layflat.control.tracking.reference import (
    JERK_LOSS,
    MAX_VELOCITY_RATIO,
    MIN_JERK_SHARE,
    PathLimits,
    Reference,
    advance_reference,
    limit_before_goal,
    next_acceleration,
    path_acceleration,
    stopping_distance,
)

T = 0.005
PACE = PathLimits(
    acceleration=40.0, deceleration=30.0, late_deceleration=40.0, jerk=900.0, velocity=1e3, torque_velocity=inf
)
SPRINGY = PACE._replace(velocity=3.0)


def ways(distance: float, limits: PathLimits = PACE, cycles: int = 400, v: float = 0.0) -> np.ndarray:
    """Angle, velocity and acceleration over cycles on the way to a goal at rest, from a velocity, (cycles, 3)."""
    at, goal = Reference(0.0, v, 0.0), Reference(distance, 0.0, 0.0)
    rows = []
    for _ in range(cycles):
        rows.append(at)
        (a,) = path_acceleration((at,), (goal,), (1.0 if distance > 0.0 else -1.0,), limits, T)
        at = advance_reference(at, a, T)
    return np.array(rows)


@given(st.floats(-3.0, 3.0), st.floats(-1.0, 1.0), st.floats(5.0, 60.0), st.floats(200.0, 4000.0))
def test_a_stop_is_as_long_as_the_quickest_one(v: float, share: float, d: float, j: float) -> None:
    wanted = ruckig.InputParameter(1)
    wanted.control_interface = ruckig.ControlInterface.Velocity
    wanted.current_velocity, wanted.current_acceleration = [v], [share * d]
    wanted.target_velocity, wanted.target_acceleration = [0.0], [0.0]
    wanted.max_acceleration, wanted.max_jerk = [d], [j]
    found = ruckig.Trajectory(1)
    ruckig.Ruckig(1).calculate(wanted, found)
    length = found.at_time(found.duration)[0][0]
    limits = PathLimits(d, d, d, j, inf, inf)
    assert stopping_distance(v, share * d, limits) == pytest.approx(length, abs=1e-9)


@given(st.floats(0.1, 3.0), st.floats(0.0, 1.0), st.floats(0.5, 1.2))
def test_a_stop_is_longer_by_what_springs_take_of_the_jerk(v: float, share: float, u: float) -> None:
    a = share * PACE.deceleration
    rigid = PACE._replace(velocity=inf)
    springy = PACE._replace(velocity=u)
    soft = rigid._replace(jerk=MIN_JERK_SHARE * PACE.jerk)
    assert (
        stopping_distance(v, a, rigid) - 1e-9
        <= stopping_distance(v, a, springy)
        <= stopping_distance(v, a, soft) + 1e-9
    )


@pytest.mark.parametrize("distance", [0.1, 0.7, 2.0])
def test_a_joint_with_springs_gains_speed_more_slowly_and_still_arrives(distance: float) -> None:
    x, v, a = ways(distance, SPRINGY).T
    assert abs(x[-1] - distance) < 1e-3
    assert x.max() < distance + 3e-3
    assert v.max() <= MAX_VELOCITY_RATIO * SPRINGY.velocity + 1e-2
    fast = (v[:-1] > 0.5 * SPRINGY.velocity) & (a[:-1] > 0.0)
    assert np.diff(a)[fast].max(initial=0.0) <= (1.0 - 0.5 * JERK_LOSS) * SPRINGY.jerk * T + 1e-9


@given(st.floats(3.0, 6.0), st.floats(0.91, 0.97))
def test_one_that_is_late_brakes_harder_and_does_not_pass_its_goal(v: float, share: float) -> None:
    left = share * stopping_distance(v, 0.0, PACE)
    x, _, a = ways(left, PACE, 120, v).T
    assert x.max() < left + 3e-3
    assert -PACE.late_deceleration - 1e-9 <= a.min() < -PACE.deceleration
    assert ways(left, PACE._replace(late_deceleration=PACE.deceleration), 120, v)[:, 0].max() > left + 3e-3


@given(st.floats(0.002, 1.5), st.sampled_from([-1.0, 1.0]))
def test_it_arrives_without_passing_its_goal_and_within_its_limits(size: float, sign: float) -> None:
    x, v, a = ways(sign * size, cycles=200).T * sign
    assert abs(x[-1] - size) < 1e-3
    assert x.max() < size + 3e-3
    assert v.min() > -0.06
    assert a.max() <= PACE.acceleration + 1e-9
    assert a.min() >= -1.05 * PACE.deceleration
    assert np.abs(np.diff(a)).max() <= PACE.jerk * T + 1e-9


@pytest.mark.parametrize("distance", [0.05, 0.3, 0.7])
def test_it_takes_hardly_longer_than_the_quickest_profile(distance: float) -> None:
    wanted = ruckig.InputParameter(1)
    wanted.current_position, wanted.target_position = [0.0], [distance]
    wanted.max_velocity, wanted.max_acceleration, wanted.max_jerk = [1e3], [PACE.acceleration], [PACE.jerk]
    wanted.min_acceleration = [-PACE.deceleration]
    found = ruckig.Trajectory(1)
    ruckig.Ruckig(1).calculate(wanted, found)
    x = ways(distance)[:, 0]
    arrived = T * int(np.argmax(np.abs(x - distance) < 2e-3))
    assert arrived < 1.05 * found.duration + 3 * T


def test_it_keeps_to_its_speed() -> None:
    v = ways(1.0, PACE._replace(velocity=1.2))[:, 1]
    assert v.max() == pytest.approx(MAX_VELOCITY_RATIO * 1.2, rel=0.02)


def test_a_goal_that_moves_is_caught() -> None:
    at, goal = Reference(0.0, 0.0, 0.0), Reference(0.3, 0.7, 0.0)
    apart = []
    for _ in range(200):
        (a,) = path_acceleration((at,), (goal,), (1.0 if goal.angle > at.angle else -1.0,), PACE, T)
        at, goal = advance_reference(at, a, T), advance_reference(goal, 0.0, T)
        apart.append(abs(goal.angle - at.angle))
    assert min(apart) < 2e-3
    assert apart[-1] < 0.01


def test_what_goes_across_the_way_dies_out() -> None:
    at, goals = [Reference(0.0, 0.0, 0.0), Reference(0.0, 0.5, 0.0)], [Reference(x, 0.0, 0.0) for x in (1.0, 0.0)]
    for _ in range(30):
        a = path_acceleration(tuple(at), tuple(goals), (1.0, 0.0), PACE, T)
        at = [advance_reference(reference, each, T) for reference, each in zip(at, a, strict=True)]
    assert abs(at[1].velocity) < 0.05


@pytest.mark.parametrize("keeps", [False, True])
def test_a_joint_on_the_way_of_another_goal_does_not_pass_its_own(keeps: bool) -> None:
    # The first is far from its goal and goes away from it; the second is soon at its own, and fast.
    at, goals = [Reference(0.2, 3.0, 20.0), Reference(-0.7, 4.0, 20.0)], [Reference(0.0, 0.0, 0.0)] * 2
    furthest = -1.0
    for _ in range(120):
        apart = np.array([goal.angle - one.angle for goal, one in zip(goals, at, strict=True)])
        e = tuple((apart / max(np.linalg.norm(apart), 1e-9)).tolist())
        a = path_acceleration(tuple(at), tuple(goals), e, PACE, T)
        if keeps:
            going = sum(one.velocity * share for one, share in zip(at, e, strict=True))
            joints = zip(a, at, goals, e, strict=True)
            a = tuple(limit_before_goal(*joint, going, PACE, PACE, T) for joint in joints)
        at = [advance_reference(reference, each, T) for reference, each in zip(at, a, strict=True)]
        furthest = max(furthest, at[1].angle)
    assert (furthest < 0.025) is keeps
    if keeps:
        assert max(abs(one.angle) for one in at) < 0.02


@given(st.floats(0.002, 1.5))
def test_a_move_from_rest_is_left_as_it_is(distance: float) -> None:
    at, goal = Reference(0.0, 0.0, 0.0), Reference(distance, 0.0, 0.0)
    for _ in range(100):
        (a,) = path_acceleration((at,), (goal,), (1.0 if goal.angle > at.angle else -1.0,), PACE, T)
        assert (
            limit_before_goal(
                a, at, goal, 1.0, at.velocity, PACE, PathLimits(1.0, 1.0, 1.0, 1.0, PACE.velocity, inf), T
            )
            == a
        )
        at = advance_reference(at, a, T)


def test_nothing_is_left_to_choose_where_the_jerk_decides() -> None:
    a = next_acceleration(1.0, 0.0, 0.0, PACE, T)
    assert a == pytest.approx(PACE.jerk * T, rel=1e-3)
    assert next_acceleration(-inf, 2.0, 0.0, PACE, T) == pytest.approx(-PACE.jerk * T, rel=1e-3)
