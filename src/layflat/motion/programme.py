"""Linear programmes for the speed along a path, on a grid; symbols as in optimal.py.

Torques t = m s'' + c s'^2 + d q's' + g are taken in the middles of the grid's intervals, and their changes between
these, from rest to the first, and from the last to rest. Rows of joints stand below each other.
"""

from math import cos, inf, pi
from typing import Any

import numpy as np
from scipy import sparse
from scipy.optimize import linprog

from layflat.arrays import Array
from layflat.errors import LayflatError
from layflat.machine import Machine
from layflat.motion.dynamics import path_torques
from layflat.motion.kinematics import tip_motion
from layflat.motion.limits import Ability, TipLimits, check_holds
from layflat.motion.path import Path

INTERVALS = 240  # of the grid; with half as many more a motion takes 0.02 % less or more
SLOWER = 1.02 * 1.3 ** np.arange(50.0)  # by these a motion is slowed down, until it keeps its limits
SIDES = 16  # of the polygon in which accelerations of the tip are kept, in place of a circle
STILL = 1e-9  # a derivative by s of an angle or of the tip that is smaller asks for nothing

Matrix = Any  # sparse


class Programme:
    """What a motion along a path has to keep, for b at the nodes of a grid."""

    def __init__(
        self, machine: Machine, path: Path, payload: float, able: Ability, tip: TipLimits, nodes: Array
    ) -> None:
        """Look at a path at nodes (INTERVALS + 1,) with a payload (kg).

        Raises:
            MachineError: the joints can't hold the arm somewhere on the path.
        """
        self.s, self._ds, self._middles = nodes, np.diff(nodes), (nodes[1:] + nodes[:-1]) / 2
        n = INTERVALS
        self._mean: Matrix = sparse.diags([0.5, 0.5], [0, 1], shape=(n, n + 1))
        self._rise: Matrix = sparse.diags([-0.5 / self._ds, 0.5 / self._ds], [0, 1], shape=(n, n + 1))
        self._halves: Matrix = sparse.diags([0.5, 0.5], [0, -1], shape=(n + 1, n))
        speeds = np.abs(path.at(self.s).first) / able.speed
        self._cap = 1.0 / np.maximum(speeds.max(axis=1), STILL) ** 2
        self._take_torques(machine, path, payload, able)
        self._take_tip(machine, path, tip)

    def _take_torques(self, machine: Machine, path: Path, payload: float, able: Ability) -> None:
        asked, joints = path_torques(machine, path, self._middles, payload), range(len(able.torque))
        most, least = able.room(asked.rate)
        check_holds(machine, asked.gravity, most, least, payload)
        self._scale = np.repeat(able.torque, INTERVALS)
        self._most, self._least, self._gravity, self._damping = (
            of.T.ravel() for of in (most, least, asked.gravity, able.damping * asked.rate)
        )
        self._torque: Matrix = sparse.vstack(
            [
                sparse.diags(asked.mass[:, j]) @ self._rise + sparse.diags(asked.centrifugal[:, j]) @ self._mean
                for j in joints
            ]
        )
        n = INTERVALS
        self._change: Matrix = sparse.block_diag([sparse.diags([1.0, -1.0], [0, -1], shape=(n + 1, n)) for _ in joints])
        angles = path.at(np.concatenate([self.s[:1], self._middles, self.s[-1:]])).value
        fixed = able.stiffness * np.diff(angles, axis=0)
        first, last = path_torques(machine, path, self.s[[0, -1]], payload).gravity
        fixed[0] -= first
        fixed[-1] += last
        self._fixed, self._rate = fixed.T.ravel(), np.repeat(able.rate, n + 1)

    def _take_tip(self, machine: Machine, path: Path, tip: TipLimits) -> None:
        self._tip: Matrix = sparse.csr_matrix((0, INTERVALS + 1))
        if tip.speed == tip.acceleration == inf:
            return
        first, _ = tip_motion(machine, *path.at(self.s))
        self._cap = np.minimum(self._cap, (tip.speed / np.maximum(np.linalg.norm(first, axis=1), STILL)) ** 2)
        if tip.acceleration < inf:
            first, second = _in_their_plane(*tip_motion(machine, *path.at(self._middles)))
            angles = 2.0 * pi * np.arange(SIDES) / SIDES
            inside = tip.acceleration * cos(pi / SIDES)
            self._tip = sparse.vstack(
                [
                    sparse.diags(first @ way / inside) @ self._rise + sparse.diags(second @ way / inside) @ self._mean
                    for way in np.stack([np.cos(angles), np.sin(angles)], axis=1)
                ]
            )

    def times(self, b: Array) -> Array:
        """Return the time that each interval takes, s."""
        speed = np.sqrt(b)
        taken: Array = 2.0 * self._ds / (speed[1:] + speed[:-1])
        return taken

    def slowed(self, b: Array) -> Array:
        """Return what of a b is slow enough for all limits; raise LayflatError if nothing is."""
        for factor in SLOWER:
            slow: Array = b / factor**2
            if self._keeps(slow):
                return slow
        raise LayflatError("no motion along the path keeps all limits, however slow")

    def _keeps(self, b: Array) -> bool:
        torque = self._torque @ b + self._damping * self._repeated(np.sqrt(self._mean @ b)) + self._gravity
        change, given = self._change @ torque + self._fixed, self._rate * self._repeated(self._halves @ self.times(b))
        held = np.all((torque <= self._most) & (torque >= self._least)) and np.all(np.abs(change) <= given)
        return bool(held and np.all(b <= self._cap) and np.all(self._tip @ b <= 1.0))

    def improved(self, b: Array, step: float) -> Array:
        """Return the b of the linear programme about b that takes least time, between b / step and b x step."""
        # Scaled by b itself, which differs by many orders of magnitude between rest and full speed.
        column: Matrix = sparse.diags(b).tocsc()[:, 1:-1]
        slopes = self._slopes(b)
        rows, right = self._rows(b, slopes)
        bounds: Any = np.stack(
            [np.full(INTERVALS - 1, 1.0 / step), np.minimum(step, self._cap[1:-1] / b[1:-1])], axis=1
        )
        found: Any = linprog(slopes.sum(axis=0) @ column / self.times(b).sum(), rows @ column, right, bounds=bounds)
        if found.status != 0:
            raise LayflatError(f"no quickest motion was found: {found.message}")
        better = b.copy()
        better[1:-1] *= found.x
        return better

    def _slopes(self, b: Array) -> Matrix:
        """Return the derivatives of the intervals' times by b."""
        speed = np.sqrt(b)
        common, inner = -self._ds / (speed[1:] + speed[:-1]) ** 2, np.where(speed > 0.0, speed, inf)  # b is 0 at rest
        return sparse.diags([common / inner[:-1], common / inner[1:]], [0, 1], shape=(INTERVALS, INTERVALS + 1))

    def _rows(self, b: Array, slopes: Matrix) -> tuple[Matrix, Array]:
        """Return rows, and what they may come to at most; each is a limit with everything in its own size."""
        speed, joints = np.sqrt(self._mean @ b), len(self._gravity) // INTERVALS
        damped = sparse.diags(self._damping) @ sparse.vstack([sparse.diags(0.5 / speed) @ self._mean] * joints)
        torque, rest = self._torque + damped, self._gravity + self._damping * self._repeated(0.5 * speed)
        h = self._repeated(self._halves @ self.times(b))
        later: Matrix = sparse.diags(self._rate) @ sparse.vstack([self._halves @ slopes] * joints)
        given, change = self._rate * h - later @ b, self._change @ torque
        fixed, per_torque, per_change = self._change @ rest + self._fixed, 1.0 / self._scale, 1.0 / (self._rate * h)
        sized, finely = sparse.diags(per_torque), sparse.diags(per_change)
        rows = [sized @ torque, -sized @ torque, finely @ (change - later), finely @ (-change - later), self._tip]
        right = [
            *(per_torque * (self._most - rest), per_torque * (rest - self._least)),
            *(per_change * (given - fixed), per_change * (given + fixed), np.ones(self._tip.shape[0])),
        ]
        return sparse.vstack(rows).tocsr(), np.concatenate(right)

    def _repeated(self, of: Array) -> Array:
        """Return what is the same for all joints, once for each of them."""
        return np.tile(of, len(self._gravity) // INTERVALS)


def _in_their_plane(first: Array, second: Array) -> tuple[Array, Array]:
    """Return derivatives of the tip's position (points, axes) in the plane, for points in space in the one of both."""
    if first.shape[1] == 2:
        return first, second
    size = np.linalg.norm(first, axis=1)
    along = first / np.maximum(size, STILL)[:, None]
    ahead = np.sum(second * along, axis=1)
    aside = np.linalg.norm(second - ahead[:, None] * along, axis=1)
    return np.stack([size, 0.0 * size], axis=1), np.stack([ahead, aside], axis=1)
