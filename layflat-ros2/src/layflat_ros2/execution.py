"""Execution of one goal on a rig: demands in time, feedback, tolerances, and how it ended."""

from dataclasses import dataclass
from math import degrees
from typing import Any

import numpy as np

from layflat.rig.safety.faults import RigState
from layflat.rig.session import RigSession, RigSnapshot
from layflat_ros2.messages import header, trajectory_point
from layflat_ros2.rosbridge import GoalStatus
from layflat_ros2.trajectory import GoalError, GoalErrorCode, TrajectoryGoal

OBEYING_STATES = (RigState.READY, RigState.MOVING)  # states in which demands are obeyed


@dataclass(frozen=True)
class Outcome:
    """End of a goal."""

    status: GoalStatus
    code: GoalErrorCode
    text: str = ""  # for people

    @classmethod
    def of_error(cls, error: GoalError) -> "Outcome":
        """Return the outcome of a goal that was refused or broken off."""
        return cls(GoalStatus.ABORTED, error.code, str(error))

    def values(self) -> dict[str, Any]:
        """Return the action's result."""
        return {"error_code": self.code, "error_string": self.text}


CANCELED_OUTCOME = Outcome(GoalStatus.CANCELED, GoalErrorCode.SUCCESSFUL, "canceled; the joints come to rest")
REPLACED_OUTCOME = Outcome(GoalStatus.CANCELED, GoalErrorCode.SUCCESSFUL, "another goal has come")
LINK_LOST_OUTCOME = Outcome(GoalStatus.ABORTED, GoalErrorCode.INVALID_GOAL, "the link to rosbridge was lost")


class Execution:
    """Execution of a goal, which `step` advances; without further steps the rig comes to rest by itself.

    Args:
        identifier: identifier of the goal.
        goal: the goal.
        now: time of `time.monotonic()`, s.
    """

    def __init__(self, identifier: str, goal: TrajectoryGoal, now: float) -> None:
        self.identifier, self._goal = identifier, goal
        self._begin = now + goal.delay
        self._is_final = False  # whether the final angles are demanded

    def step(self, session: RigSession, shot: RigSnapshot, joints: list[str], now: float) -> Outcome | None:
        """Demand the angles of an instant, and return the outcome once the goal has ended.

        Args:
            session: session on the rig.
            shot: its last cycle.
            joints: names of the joints.
            now: time of `time.monotonic()`, s.
        """
        if shot.state not in OBEYING_STATES:
            text = f"the rig's state is {shot.state.name.lower()}: {shot.fault_text}"
            return Outcome(GoalStatus.ABORTED, GoalErrorCode.INVALID_GOAL, text)
        time = now - self._begin
        if time < 0.0:
            return None
        angles, velocities, accelerations = (rows[0] for rows in self._goal.motion.states([time]))
        if not self._is_final:
            session.ask(angles.tolist(), velocities.tolist(), accelerations.tolist(), at=now)
        error = np.abs(shot["averaged_angle"] - angles)
        if time < self._goal.motion.duration:
            return self._violation(error, self._goal.path_tolerance, joints, GoalErrorCode.PATH_TOLERANCE_VIOLATED)
        self._is_final = True
        late = self._violation(error, self._goal.goal_tolerance, joints, GoalErrorCode.GOAL_TOLERANCE_VIOLATED)
        if late is None:
            return Outcome(GoalStatus.SUCCEEDED, GoalErrorCode.SUCCESSFUL)
        return late if time > self._goal.motion.duration + self._goal.time_tolerance else None

    def feedback(self, shot: RigSnapshot, joints: list[str], now: float) -> dict[str, Any]:
        """Return the action's feedback.

        Args:
            shot: last cycle of the rig.
            joints: names of the joints.
            now: time of `time.monotonic()`, s.
        """
        time = max(now - self._begin, 0.0)
        angles, velocities, _ = (rows[0] for rows in self._goal.motion.states([time]))
        actual, rates = shot["averaged_angle"], shot["averaged_velocity"]
        points = {
            "desired": (angles, velocities), "actual": (actual, rates), "error": (angles - actual, velocities - rates)
        }  # fmt: skip
        message: dict[str, Any] = {"header": header(float(shot["wall"])), "joint_names": joints}
        return message | {name: trajectory_point(*point, time) for name, point in points.items()}

    @staticmethod
    def _violation(error: Any, tolerance: Any, joints: list[str], code: GoalErrorCode) -> Outcome | None:
        """Return the outcome of an error of angles (joints,), rad, beyond its tolerance; None within it."""
        beyond = error - tolerance
        joint = int(np.argmax(beyond))
        if beyond[joint] <= 0.0:
            return None
        limit = f"more than {degrees(tolerance[joint]):.3g} deg"
        return Outcome(
            GoalStatus.ABORTED, code, f"joint {joints[joint]!r} is {degrees(error[joint]):.3g} deg off, {limit}"
        )
