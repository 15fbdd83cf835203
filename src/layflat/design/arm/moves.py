"""The moves that an arm is sized for, as its joints go through them: from rest to rest, with least jerk."""

from itertools import cycle, islice, pairwise
from typing import NamedTuple

import numpy as np

from layflat.arrays import Array
from layflat.design.arm.task import ArmTask
from layflat.errors import DesignError
from layflat.machine import Machine
from layflat.motion.inverse import anywhere
from layflat.motion.kinematics import Kinematics, tip_motion
from layflat.motion.trajectory import States, quintic

MOVES = 48  # that are drawn where a task gives none
SEED = 0
STILL = 1e-6  # turn below which a joint stays where it is, rad
INSTANTS = 41  # of a move that are looked at


class Moves(NamedTuple):
    """Moves that a task asks for."""

    starts: Array  # (moves, joints), rad
    ends: Array
    times: Array  # (moves,), s
    instants: int = INSTANTS  # of each that are looked at

    @property
    def states(self) -> States:
        """Angles, velocities and accelerations at all instants of all moves, (moves x instants, joints) each."""
        share, rate, change = quintic(np.linspace(0.0, 1.0, self.instants)[:, None])
        way, time = (self.ends - self.starts)[:, None, :], self.times[:, None, None]
        rows = self.starts[:, None, :] + share * way, rate * way / time, change * way / time**2
        return States(*(of.reshape(-1, self.starts.shape[1]) for of in rows))

    def by_move(self, values: Array) -> Array:
        """Return values at all instants (moves x instants, ...) as (moves, instants, ...)."""
        return values.reshape(len(self.times), self.instants, *values.shape[1:])


def moves_of(task: ArmTask, machine: Machine) -> Moves:
    """Return the moves of a task, for a machine with an arm of its shape.

    Raises:
        DesignError: the arm does not reach a point of the task; it names the nearest that it reaches.
    """
    starts, ends = _ways(task, machine)
    goes = np.abs(ends - starts).max(axis=1) > STILL
    if not goes.any():
        raise DesignError("its moves go nowhere", where=task.origin, right="give poses or points that differ")
    starts, ends = starts[goes], ends[goes]
    moves = Moves(starts, ends, np.full(len(starts), task.time or 1.0))
    if task.acceleration is None:
        return moves
    _, accelerated = tip_motion(machine, *moves.states)
    greatest = np.linalg.norm(moves.by_move(accelerated), axis=2).max(axis=1)
    goes = greatest > STILL
    if not goes.any():
        right = "give time in place of acceleration"
        raise DesignError("its moves leave the tip where it is", where=task.origin, right=right)
    return Moves(starts[goes], ends[goes], np.sqrt(greatest[goes] / task.acceleration))


def _ways(task: ArmTask, machine: Machine) -> tuple[Array, Array]:
    half = np.array([0.5 * joint.stroke for joint in task.chain])
    draw = np.random.default_rng(SEED)
    if task.poses or task.points:
        stops = np.array(task.poses) if task.poses else _postures(task, machine, np.array(task.points))
        rows = np.array(list(pairwise(islice(cycle(stops), len(stops) + 1))))
        return rows[:, 0], rows[:, 1]
    if task.volume is not None:
        low, high = np.array(task.volume.low), np.array(task.volume.high)
        corners = np.array([[x, y, z] for x in (0.0, 1.0) for y in (0.0, 1.0) for z in (0.0, 1.0)])
        shares = np.concatenate([corners, draw.uniform(size=(2 * (MOVES - len(corners)), 3))])
        found = _postures(task, machine, low + shares * (high - low))
        # The longest ways are those from each corner to the one opposite.
        ends, others = found[: len(corners)], found[len(corners) :]
        return np.concatenate([ends, others[::2]]), np.concatenate([ends[::-1], others[1::2]])
    # Postures with joints at their ends first: gravity is worst at some of them.
    starts = draw.uniform(-1.0, 1.0, (MOVES, len(half)))
    starts[: MOVES // 2] = np.sign(starts[: MOVES // 2])
    ways = draw.uniform(-1.0, 1.0, starts.shape)
    ways *= task.turn / np.abs(ways).max(axis=1, keepdims=True)
    starts *= half
    # A joint that would leave its stroke turns the other way.
    ways = np.where(np.abs(starts + ways) > half, -ways, ways)
    return starts, np.clip(starts + ways, -half, half)


def _postures(task: ArmTask, machine: Machine, points: Array) -> Array:
    found = anywhere(machine, points)
    if not found.there.all():
        worst = int(found.missing.argmax())
        nearest = Kinematics(machine).tip(found.angles[worst : worst + 1])[0]
        what = f"the point {_told(points[worst])} is {1e3 * found.missing[worst]:.0f} mm out of the arm's reach"
        raise DesignError(
            f"{what}, whose nearest is {_told(nearest)}",
            where=f"{task.origin}: {'points' if task.points else 'volume'}",
            right="give nearer points, longer links or wider strokes",
        )
    return found.angles


def _told(point: Array) -> str:
    x, y, z = 1e3 * point + 0.0
    return f"x = {x:.0f} mm, y = {y:.0f} mm, z = {z:.0f} mm"
