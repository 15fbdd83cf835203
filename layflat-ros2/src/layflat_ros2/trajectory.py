"""Goal of control_msgs/action/FollowJointTrajectory, read and checked: its motion and its tolerances.

Between its points a trajectory is linear where they have positions alone, cubic with velocities, and quintic with
accelerations too, as in ROS's own joint_trajectory_controller.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import IntEnum
from math import degrees, inf, isfinite
from typing import Any

import numpy as np
from scipy.interpolate import BPoly

from layflat.arrays import Array
from layflat.errors import LayflatError
from layflat.machine import Machine
from layflat.motion.trajectory import States, Trajectory
from layflat.rig.abilities import demand_limits
from layflat_ros2.messages import seconds

GOAL_TOLERANCE = np.radians(1.0)  # of an angle at the end where the goal has none, rad
GOAL_TIME_TOLERANCE = 2.0  # within which the end is reached where the goal has none, s
START_TOLERANCE = np.radians(3.0)  # of a first point at time 0, from where the joint is, rad
RATE_FIELDS = ("velocities", "accelerations")


class GoalErrorCode(IntEnum):
    """Error code of the action's result."""

    SUCCESSFUL = 0
    INVALID_GOAL = -1
    INVALID_JOINTS = -2
    OLD_HEADER_TIMESTAMP = -3
    PATH_TOLERANCE_VIOLATED = -4
    GOAL_TOLERANCE_VIOLATED = -5


class GoalError(LayflatError):
    """Goal that can't be followed, or was not, with its error code."""

    def __init__(self, text: str, code: GoalErrorCode = GoalErrorCode.INVALID_GOAL) -> None:
        self.code = code
        super().__init__(text)


@dataclass(frozen=True)
class SplineMotion(Trajectory):
    """Motion through points in time, from rest to rest."""

    splines: Sequence[BPoly]  # of each joint, over s

    def _states(self, times: Array) -> States:
        moving = (times < self.duration)[:, None]
        angles, velocities, accelerations = (
            np.stack([spline(times, order) for spline in self.splines], axis=1) for order in range(3)
        )
        return States(angles, velocities * moving, accelerations * moving)


@dataclass(frozen=True)
class TrajectoryGoal:
    """Motion that is to be followed, and how closely."""

    motion: SplineMotion
    delay: float  # until it begins, s; below 0 it has begun already
    path_tolerance: Array  # of angles on the way, (joints,), rad; infinite where there is none
    goal_tolerance: Array  # of angles at the end, (joints,), rad
    time_tolerance: float  # within which the end is reached, s


class GoalReader:
    """Reader of the goals of a machine: `GoalReader(machine).read(goal, angles, time_of_day)`."""

    def __init__(self, machine: Machine) -> None:
        self._joints = list(machine.joints)
        self._half_strokes = [0.5 * joint.stops.working_stroke for joint in machine.joints.values()]
        self._max_speeds, self._cycle = demand_limits(machine).speed, machine.cycle

    def read(self, goal: Mapping[str, Any], start: Sequence[float], now: float) -> TrajectoryGoal:
        """Return a goal as it is to be followed.

        Args:
            goal: its fields.
            start: demanded angles of all joints at present, from base to tip, rad.
            now: time of day, s since 1970.

        Raises:
            GoalError: it makes no sense, or the machine can't follow it.
        """
        try:
            trajectory = goal["trajectory"]
            order = self._order(trajectory["joint_names"])
            times, columns = self._columns(trajectory["points"], order)
            begins = seconds(trajectory.get("header", {}).get("stamp", {}))
            path = self._tolerances(goal.get("path_tolerance", []), inf)
            end = self._tolerances(goal.get("goal_tolerance", []), float(GOAL_TOLERANCE))
            within = seconds(goal.get("goal_time_tolerance", {})) or GOAL_TIME_TOLERANCE
        except (KeyError, TypeError, ValueError, AttributeError) as error:
            raise GoalError(f"the goal is no FollowJointTrajectory: {error!r}") from None
        delay = begins - now if begins else 0.0
        if delay + times[-1] < 0.0:
            text = f"the trajectory ended {-delay - times[-1]:.3g} s ago; send a new stamp"
            raise GoalError(text, GoalErrorCode.OLD_HEADER_TIMESTAMP)
        motion = self._motion(times, columns, np.array(start))
        self._check(motion)
        return TrajectoryGoal(motion, delay, path, end, within)

    def _order(self, names: Sequence[str]) -> list[int]:
        """Return the columns of the goal in the order of the joints; raise GoalError unless each is there once."""
        if sorted(names) != sorted(self._joints):
            has = f"has the joints {', '.join(map(str, names)) or 'none'}"
            raise GoalError(f"{has}; give each of {', '.join(self._joints)} once", GoalErrorCode.INVALID_JOINTS)
        return [list(names).index(name) for name in self._joints]

    def _columns(self, points: Sequence[Mapping[str, Any]], order: Sequence[int]) -> tuple[Array, list[Array]]:
        """Return the times (points,) and positions, velocities, accelerations that all points have, (points, joints).

        Raises:
            GoalError: there is no point, times do not increase, or rows are no finite numbers.
        """
        if not points:
            raise GoalError("the trajectory has no points; give one at least")
        times = np.array([seconds(point["time_from_start"]) for point in points])
        if times[0] < 0.0 or np.any(np.diff(times) <= 0.0):
            raise GoalError("times from the start do not increase; give each point a later one")
        columns = []
        for name in ("positions", *RATE_FIELDS):
            rows = [point.get(name) or [] for point in points]
            if name in RATE_FIELDS and not all(rows):
                if any(rows):
                    raise GoalError(f"some points have {name} and others none; give them to all or none")
                break
            columns.append(np.array([self._row(row, name, order) for row in rows]))
        if len(columns) > 1 and np.any(columns[1][-1] != 0.0):
            raise GoalError("the last point moves on; give it velocities of 0")
        return times, columns

    def _row(self, row: Sequence[Any], name: str, order: Sequence[int]) -> list[float]:
        """Return a row of a point in the order of the joints."""
        numbers = [value for value in row if isinstance(value, int | float) and isfinite(value)]
        if len(row) != len(order) or len(numbers) != len(row):
            raise GoalError(f"{name} of a point are {list(row)}; give one finite number a joint")
        return [float(row[column]) for column in order]

    def _tolerances(self, entries: Sequence[Mapping[str, Any]], default: float) -> Array:
        """Return tolerances of angles, (joints,), rad: a negative one is none, and 0 is the default."""
        limits = np.full(len(self._joints), default)
        for entry in entries:
            if entry["name"] not in self._joints:
                raise GoalError(
                    f"tolerance of {entry['name']!r}, which is none of {self._joints}", GoalErrorCode.INVALID_JOINTS
                )
            value = float(entry.get("position", 0.0))
            limits[self._joints.index(entry["name"])] = inf if value < 0.0 else value or default
        return limits

    def _motion(self, times: Array, columns: list[Array], start: Array) -> SplineMotion:
        """Return the motion from rest at `start` through the points.

        Raises:
            GoalError: the first point is at time 0, and elsewhere.
        """
        if times[0] == 0.0:
            for name, at, present in zip(self._joints, columns[0][0], start, strict=True):
                if abs(at - present) > START_TOLERANCE:
                    where = f"joint {name!r} begins at {degrees(at):.4g} deg and is at {degrees(present):.4g} deg"
                    raise GoalError(f"{where}; begin there, or give the first point a later time")
        else:
            times = np.insert(times, 0, 0.0)
            rest = np.zeros_like(start)
            columns = [np.vstack([first, rows]) for first, rows in zip((start, rest, rest), columns, strict=False)]
        if len(times) == 1:
            times, columns = np.array([0.0, self._cycle]), [np.vstack([rows, rows]) for rows in columns]
        derivatives = np.stack(columns, axis=1)  # (points, orders, joints)
        splines = [BPoly.from_derivatives(times, derivatives[:, :, joint]) for joint in range(len(self._joints))]
        return SplineMotion(float(times[-1]), splines)

    def _check(self, motion: SplineMotion) -> None:
        """Check a motion between its points, too: inside the working stroke, and no faster than the joints."""
        angles, velocities, _ = motion.rows(self._cycle)
        for joint, (name, half) in enumerate(zip(self._joints, self._half_strokes, strict=True)):
            furthest = float(angles[np.argmax(np.abs(angles[:, joint])), joint])
            if abs(furthest) > half * (1.0 + 1e-9):
                inside = f"inside the working stroke of +-{degrees(half):.4g} deg"
                raise GoalError(f"joint {name!r} goes to {degrees(furthest):.4g} deg; keep {inside}")
            speed, limit = float(np.abs(velocities[:, joint]).max()), float(self._max_speeds[joint])
            if speed > limit:
                most = f"it can do {degrees(limit):.4g} deg/s at most"
                raise GoalError(f"joint {name!r} moves at {degrees(speed):.4g} deg/s; {most}")
