"""Moves that an arm is sized for: minimum-jerk motions of its joints from rest to rest."""

from itertools import cycle, islice, pairwise
from typing import NamedTuple

import numpy as np

from layflat.arrays import Array
from layflat.design.arm.task import ArmTask
from layflat.errors import DesignError
from layflat.machine import Machine
from layflat.motion.inverse import solve_inverse_kinematics
from layflat.motion.kinematics import Kinematics, tip_motion
from layflat.motion.trajectory import States, quintic

RANDOM_MOVES = 48  # number of random moves, if a task defines none
RANDOM_SEED = 0
MIN_ROTATION = 1e-6  # rotation below which a joint does not move, rad
MOVE_INSTANTS = 41  # instants of a move that are evaluated


class TaskMoves(NamedTuple):
    """Moves of a task."""

    starts: Array  # (moves, joints), rad
    ends: Array  # likewise
    times: Array  # durations, (moves,), s
    instants: int = MOVE_INSTANTS  # of each move that are evaluated

    @property
    def states(self) -> States:
        """Angles, velocities and accelerations at all instants of all moves, (moves x instants, joints) each."""
        share, rate, change = quintic(np.linspace(0.0, 1.0, self.instants)[:, None])
        rotation, time = (self.ends - self.starts)[:, None, :], self.times[:, None, None]
        rows = self.starts[:, None, :] + share * rotation, rate * rotation / time, change * rotation / time**2
        return States(*(row.reshape(-1, self.starts.shape[1]) for row in rows))

    def by_move(self, values: Array) -> Array:
        """Return values at all instants (moves x instants, ...) as (moves, instants, ...)."""
        return values.reshape(len(self.times), self.instants, *values.shape[1:])


def plan_task_moves(task: ArmTask, machine: Machine) -> TaskMoves:
    """Return the moves of a task, for a machine with an arm of the task's geometry.

    Durations are the task's time, or such that the tip reaches its acceleration; moves without motion are left out.

    Raises:
        DesignError: the arm does not reach a point of the task, or nothing moves.
    """
    starts, ends = _move_ends(task, machine)
    goes = np.abs(ends - starts).max(axis=1) > MIN_ROTATION
    if not goes.any():
        raise DesignError("its moves go nowhere", where=task.origin, right="give configurations or points that differ")
    starts, ends = starts[goes], ends[goes]
    moves = TaskMoves(starts, ends, np.full(len(starts), task.time or 1.0))
    if task.acceleration is None:
        return moves
    _, accelerated = tip_motion(machine, *moves.states)
    greatest = np.linalg.norm(moves.by_move(accelerated), axis=2).max(axis=1)
    goes = greatest > MIN_ROTATION
    if not goes.any():
        right = "give time in place of acceleration"
        raise DesignError("its moves leave the tip where it is", where=task.origin, right=right)
    return TaskMoves(starts[goes], ends[goes], np.sqrt(greatest[goes] / task.acceleration))


def _move_ends(task: ArmTask, machine: Machine) -> tuple[Array, Array]:
    """Return the configurations (rad) at which the task's moves begin and end, each (moves, joints).

    They are the described configurations or points in a closed loop, or random ones in the volume or in the strokes.
    """
    half = np.array([0.5 * joint.stroke for joint in task.chain])
    draw = np.random.default_rng(RANDOM_SEED)
    if task.configurations or task.points:
        stops = (
            np.array(task.configurations)
            if task.configurations
            else _reach_points(task, machine, np.array(task.points))
        )
        rows = np.array(list(pairwise(islice(cycle(stops), len(stops) + 1))))
        return rows[:, 0], rows[:, 1]
    if task.volume is not None:
        low, high = np.array(task.volume.low), np.array(task.volume.high)
        corners = np.array([[x, y, z] for x in (0.0, 1.0) for y in (0.0, 1.0) for z in (0.0, 1.0)])
        shares = np.concatenate([corners, draw.uniform(size=(2 * (RANDOM_MOVES - len(corners)), 3))])
        angles = _reach_points(task, machine, low + shares * (high - low))
        # The longest moves are those between opposite corners.
        ends, others = angles[: len(corners)], angles[len(corners) :]
        return np.concatenate([ends, others[::2]]), np.concatenate([ends[::-1], others[1::2]])
    # Configurations with joints at the ends of their strokes first: gravity loads are greatest at some of them.
    starts = draw.uniform(-1.0, 1.0, (RANDOM_MOVES, len(half)))
    starts[: RANDOM_MOVES // 2] = np.sign(starts[: RANDOM_MOVES // 2])
    rotations = draw.uniform(-1.0, 1.0, starts.shape)
    rotations *= task.rotation / np.abs(rotations).max(axis=1, keepdims=True)
    starts *= half
    # A joint that would leave its stroke rotates in the other direction.
    rotations = np.where(np.abs(starts + rotations) > half, -rotations, rotations)
    return starts, np.clip(starts + rotations, -half, half)


def _reach_points(task: ArmTask, machine: Machine, points: Array) -> Array:
    """Return joint angles (rad) that put the tip at points (m); raise DesignError if one is out of reach."""
    solution = solve_inverse_kinematics(machine, points)
    if not solution.reached.all():
        worst = int(solution.distance.argmax())
        nearest = Kinematics(machine).tip(solution.angles[worst : worst + 1])[0]
        what = (
            f"the point {_point_text(points[worst])} is {1e3 * solution.distance[worst]:.0f} mm out of the arm's reach"
        )
        raise DesignError(
            f"{what}, whose nearest is {_point_text(nearest)}",
            where=f"{task.origin}: {'points' if task.points else 'volume'}",
            right="give nearer points, longer links or wider strokes",
        )
    return solution.angles


def _point_text(point: Array) -> str:
    """Return a point (m) as text in mm."""
    x, y, z = 1e3 * point + 0.0
    return f"x = {x:.0f} mm, y = {y:.0f} mm, z = {z:.0f} mm"
