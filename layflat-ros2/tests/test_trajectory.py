"""Goals of FollowJointTrajectory: what is followed, and what is refused."""

from math import inf
from typing import Any

import numpy as np
import pytest
from scipy.interpolate import CubicHermiteSpline

from layflat.machine import load
from layflat_ros2.messages import seconds, stamp, trajectory_point
from layflat_ros2.trajectory import GoalError, GoalReader, TrajectoryGoal

INVALID_GOAL, INVALID_JOINTS, OLD_HEADER_TIMESTAMP = -1, -2, -3  # of FollowJointTrajectory, from its documentation
READER = GoalReader(load("paper-arm"))
START = [0.1, -0.1]  # rad
NOW = 1_780_000_000.0  # s since 1970
TIMES = [0.5, 1.0, 1.8]  # s


def goal_of(positions: Any, times: Any = TIMES, joints: Any = ("large", "small"), **rates: Any) -> dict[str, Any]:
    """A goal whose points have positions and rates, (points, joints)."""
    points = [
        trajectory_point(row, time=time) | {name: list(rows[k]) for name, rows in rates.items()}
        for k, (row, time) in enumerate(zip(positions, times, strict=True))
    ]
    return {"trajectory": {"joint_names": list(joints), "points": points}}


def read(goal: dict[str, Any]) -> TrajectoryGoal:
    return READER.read(goal, START, NOW)


@pytest.fixture
def points() -> Any:
    return np.random.default_rng(1).uniform(-0.4, 0.4, (3, 2))


def test_positions_alone_are_joined_by_lines(points: Any) -> None:
    motion = read(goal_of(points)).motion
    times = np.linspace(0.0, 1.8, 37)
    expected = [
        np.interp(times, [0.0, *TIMES], [start, *column]) for start, column in zip(START, points.T, strict=True)
    ]
    assert motion.angles_at(times) == pytest.approx(np.transpose(expected), abs=1e-12)
    assert not motion.states([1.8, 9.0]).velocities.any()


def test_velocities_make_cubics(points: Any) -> None:
    velocities = np.array([[0.5, -0.3], [0.2, 0.1], [0.0, 0.0]])
    motion = read(goal_of(points, velocities=velocities)).motion
    times = np.linspace(0.0, 1.8, 37)
    for joint in range(2):
        expected = CubicHermiteSpline(
            [0.0, *TIMES], [START[joint], *points[:, joint]], [0.0, *velocities[:, joint]]
        )  # fmt: skip
        assert motion.angles_at(times)[:, joint] == pytest.approx(expected(times), abs=1e-12)
        assert motion.states(times).velocities[:-1, joint] == pytest.approx(expected(times[:-1], 1), abs=1e-11)


def test_accelerations_make_quintics_through_all_that_is_given(points: Any) -> None:
    rates = np.array([[0.5, -0.3], [0.2, 0.1], [0.0, 0.0]])
    motion = read(goal_of(points, velocities=rates, accelerations=2.0 * rates)).motion
    states = motion.states(np.array(TIMES[:2]))
    assert states.angles == pytest.approx(points[:2], abs=1e-12)
    assert states.velocities == pytest.approx(rates[:2], abs=1e-11)
    assert states.accelerations == pytest.approx(2.0 * rates[:2], abs=1e-10)
    fifth = np.diff(motion.angles_at(np.linspace(0.5, 1.0, 9)), 6, axis=0)
    assert np.abs(fifth).max() < 1e-12


def test_joints_may_come_in_any_order(points: Any) -> None:
    swapped = read(goal_of(points[:, ::-1], joints=("small", "large"))).motion
    assert (swapped.angles_at(TIMES) == read(goal_of(points)).motion.angles_at(TIMES)).all()


def test_a_first_point_at_time_0_is_where_the_joints_are() -> None:
    goal = read(goal_of([START, [0.3, 0.0]], [0.0, 1.0]))
    assert goal.motion.duration == 1.0
    assert read(goal_of([START], [0.0])).motion.angles_at([0.0, 1.0]).tolist() == [START, START]


def test_stamps_tolerances_and_defaults(points: Any) -> None:
    goal = goal_of(points)
    plain = read(goal)
    assert (plain.delay, plain.time_tolerance) == (0.0, 2.0)
    assert plain.path_tolerance.tolist() == [inf, inf]
    assert plain.goal_tolerance == pytest.approx(np.radians(1.0))
    goal["trajectory"]["header"] = {"stamp": stamp(NOW + 0.25)}
    goal["path_tolerance"] = [{"name": "small", "position": 0.05}]
    goal["goal_tolerance"] = [{"name": "large", "position": -1.0}, {"name": "small", "position": 0.01}]
    goal["goal_time_tolerance"] = stamp(0.5)
    read_back = read(goal)
    assert read_back.delay == pytest.approx(0.25, abs=1e-6)
    assert read_back.time_tolerance == 0.5
    assert read_back.path_tolerance.tolist() == [inf, 0.05]
    assert read_back.goal_tolerance.tolist() == [inf, 0.01]


@pytest.mark.parametrize("time", [0.0, 1e-9, 1.5, -0.25, NOW + 0.123456789])
def test_times_are_kept(time: float) -> None:
    assert seconds(stamp(time)) == pytest.approx(time, abs=1e-6)
    assert 0 <= stamp(time)["nanosec"] < 1_000_000_000


SMALL = [[0.1, 0.0], [0.2, 0.0]]


@pytest.mark.parametrize(
    ("goal", "code", "text"),
    [
        ({}, INVALID_GOAL, "the goal is no FollowJointTrajectory: KeyError('trajectory')"),
        ({"trajectory": 3}, INVALID_GOAL, "the goal is no FollowJointTrajectory"),
        (goal_of([], []), INVALID_GOAL, "the trajectory has no points; give one at least"),
        (goal_of(SMALL, [1, 2], ("large", "wrist")), INVALID_JOINTS, "has the joints large, wrist; give each of large"),
        (goal_of(SMALL, [1, 2], ("large", "large")), INVALID_JOINTS, "has the joints large, large; give each of large"),
        (goal_of([[0.1]], [1], ("large",)), INVALID_JOINTS, "has the joints large; give each of large, small once"),
        (goal_of(SMALL, [1, 1]), INVALID_GOAL, "times from the start do not increase; give each point a later one"),
        (goal_of(SMALL, [-1, 1]), INVALID_GOAL, "times from the start do not increase"),
        (goal_of(SMALL, [1, 2], velocities=[[], [0, 0]]), INVALID_GOAL, "some points have velocities and others none"),
        (goal_of(SMALL, [1, 2], velocities=[[0, 0], [0, 1]]), INVALID_GOAL, "the last point moves on; give it"),
        (goal_of(SMALL, [1, 2], velocities=[[0, None], [0, 0]]), INVALID_GOAL, "velocities of a point are [0, None];"),
        (goal_of([[0.1, 0.0, 0.0]], [1]), INVALID_GOAL, "positions of a point are [0.1, 0.0, 0.0]; give one finite"),
        (goal_of([[0.1, 2.0]], [1]), INVALID_GOAL, "joint 'small' goes to 114.6 deg; keep inside the working stroke"),
        (goal_of([[0.9, 0.0]], [0.1]), INVALID_GOAL, "joint 'large' moves at 458.4 deg/s; it can do 175.7 deg/s at"),
        (goal_of([[0.9, 0.0]], [0]), INVALID_GOAL, "joint 'large' begins at 51.57 deg and is at 5.73 deg; begin"),
    ],
)  # fmt: skip
def test_what_can_not_be_followed_is_refused(goal: dict[str, Any], code: int, text: str) -> None:
    with pytest.raises(GoalError) as refusal:
        read(goal)
    assert refusal.value.code == code
    assert str(refusal.value).startswith(text)
    assert "\n" not in str(refusal.value)


def test_a_spline_that_leaves_the_stroke_between_its_points_is_refused() -> None:
    goal = goal_of([[1.0, 0.0], [1.0, 0.0]], [1.0, 2.0], velocities=[[2.5, 0.0], [0.0, 0.0]])
    with pytest.raises(GoalError, match=r"joint 'large' goes to .* deg; keep inside"):
        read(goal)


def test_an_old_stamp_and_a_foreign_tolerance_are_refused() -> None:
    old, foreign = goal_of(SMALL, [1, 2]), goal_of(SMALL, [1, 2])
    old["trajectory"]["header"] = {"stamp": stamp(NOW - 5.0)}
    foreign["goal_tolerance"] = [{"name": "wrist", "position": 0.1}]
    for goal, code in ((old, OLD_HEADER_TIMESTAMP), (foreign, INVALID_JOINTS)):
        with pytest.raises(GoalError) as refusal:
            read(goal)
        assert refusal.value.code == code
