"""Time-optimal motion along a path within the capabilities of hoses and valves, from rest to rest.

| symbol | meaning | unit |
|---|---|---|
| s, b | distance along the path; s'^2 | m or rad, that^2/s^2 |
| t | torques of the joints, without dry friction | N m |
| m, c, g | torques per s'', per s'^2, and of gravity (dynamics.py) | N m per that |
| d | damping | N m s/rad |
| R, k | greatest rate of a joint's torque; stiffness of its hoses | N m/s, N m/rad |
| h | time between the middles of two intervals | s |

On a grid of the path b is linear in between, so that s'' = (b_(k+1) - b_k)/(2 ds) and m s'' + c s'^2 + g are linear in
it (bobrow1985, verscheure2009). Two things are not, and are replaced by their tangents at the last solution: damping,
and the time h, which is a convex function of b. The air that passes a valve changes the torque, and fills the hoses of
a joint that rotates by dq: |dt + k dq| <= R h. A tangent of h lies below it, so that each solution of a linear
programme keeps the limits, and the next programme can start from it.

Torques t = m s'' + c s'^2 + d q's' + g are taken in the middles of the grid's intervals, and their changes between
these, from rest to the first, and from the last to rest. Rows of joints stand below each other.

Dry friction counts in the torque that the hoses have to exert, and not in its rate: friction holds a joint while it
reverses, and a joint at rest has the torque of friction before it moves.
"""

from math import cos, inf, pi
from typing import Any

import numpy as np
from scipy import sparse
from scipy.interpolate import CubicSpline
from scipy.optimize import linprog

from layflat.arrays import Array
from layflat.errors import LayflatError
from layflat.machine import Machine
from layflat.motion.dynamics import path_torques
from layflat.motion.kinematics import tip_motion
from layflat.motion.limits import (
    FEEDBACK_RESERVE,
    JointCapabilities,
    TipLimits,
    check_holding_torque,
    joint_capabilities,
)
from layflat.motion.path import SAME_POINT_DISTANCE, JointPath
from layflat.motion.trajectory import PathMotion, RestMotion, Trajectory

__all__ = ["plan_time_optimal"]

GRID_INTERVALS = 240  # with half as many more, durations change by 0.02 %
SLOWDOWN_FACTORS = 1.02 * 1.3 ** np.arange(50.0)  # on the duration, tried in turn until a motion keeps its limits
POLYGON_SIDES = 16  # of the polygon that approximates the circle of the tip's accelerations
MIN_DERIVATIVE = 1e-9  # of an angle or of the tip by s; smaller ones count as zero

Matrix = Any  # sparse


class PathProgramme:
    """Constraints on b at the nodes of a grid, of a motion along a path."""

    def __init__(
        self,
        machine: Machine,
        path: JointPath,
        payload: float,
        capabilities: JointCapabilities,
        tip: TipLimits,
        nodes: Array,
    ) -> None:
        """Compute the constraints.

        Args:
            machine: machine whose arm moves.
            path: path of its joints.
            payload: kg.
            capabilities: capabilities of the joints.
            tip: limits of the tip's motion.
            nodes: distances along the path, (GRID_INTERVALS + 1,), m or rad.

        Raises:
            MachineError: the joints can't hold the arm somewhere on the path.
        """
        self.s, self._ds, self._middles = nodes, np.diff(nodes), (nodes[1:] + nodes[:-1]) / 2
        n = GRID_INTERVALS
        self._mean: Matrix = sparse.diags([0.5, 0.5], [0, 1], shape=(n, n + 1))
        self._rise: Matrix = sparse.diags([-0.5 / self._ds, 0.5 / self._ds], [0, 1], shape=(n, n + 1))
        self._halves: Matrix = sparse.diags([0.5, 0.5], [0, -1], shape=(n + 1, n))
        speeds = np.abs(path.evaluate(self.s).first) / capabilities.speed
        self._cap = 1.0 / np.maximum(speeds.max(axis=1), MIN_DERIVATIVE) ** 2
        self._set_torque_limits(machine, path, payload, capabilities)
        self._set_tip_limits(machine, path, tip)

    def _set_torque_limits(
        self, machine: Machine, path: JointPath, payload: float, capabilities: JointCapabilities
    ) -> None:
        """Set the rows that limit torques and their changes; raise MachineError if a payload (kg) can't be held."""
        required, joints = path_torques(machine, path, self._middles, payload), range(len(capabilities.torque))
        upper, lower = capabilities.torque_bounds(required.rate)
        check_holding_torque(machine, required.gravity, upper, lower, payload)
        self._scale = np.repeat(capabilities.torque, GRID_INTERVALS)
        self._upper, self._lower, self._gravity, self._damping = (
            rows.T.ravel() for rows in (upper, lower, required.gravity, capabilities.damping * required.rate)
        )
        self._torque: Matrix = sparse.vstack(
            [
                sparse.diags(required.mass[:, j]) @ self._rise + sparse.diags(required.centrifugal[:, j]) @ self._mean
                for j in joints
            ]
        )
        n = GRID_INTERVALS
        self._change: Matrix = sparse.block_diag([sparse.diags([1.0, -1.0], [0, -1], shape=(n + 1, n)) for _ in joints])
        angles = path.evaluate(np.concatenate([self.s[:1], self._middles, self.s[-1:]])).value
        fixed = capabilities.stiffness * np.diff(angles, axis=0)
        first, last = path_torques(machine, path, self.s[[0, -1]], payload).gravity
        fixed[0] -= first
        fixed[-1] += last
        self._fixed, self._rate = fixed.T.ravel(), np.repeat(capabilities.rate, n + 1)

    def _set_tip_limits(self, machine: Machine, path: JointPath, tip: TipLimits) -> None:
        """Set the rows that limit the tip's acceleration, by a polygon in its plane, and lower the cap by its speed."""
        self._tip: Matrix = sparse.csr_matrix((0, GRID_INTERVALS + 1))
        if tip.speed == tip.acceleration == inf:
            return
        first, _ = tip_motion(machine, *path.evaluate(self.s))
        self._cap = np.minimum(self._cap, (tip.speed / np.maximum(np.linalg.norm(first, axis=1), MIN_DERIVATIVE)) ** 2)
        if tip.acceleration < inf:
            first, second = _project_to_plane(*tip_motion(machine, *path.evaluate(self._middles)))
            angles = 2.0 * pi * np.arange(POLYGON_SIDES) / POLYGON_SIDES
            inside = tip.acceleration * cos(pi / POLYGON_SIDES)
            self._tip = sparse.vstack(
                [
                    sparse.diags(first @ normal / inside) @ self._rise
                    + sparse.diags(second @ normal / inside) @ self._mean
                    for normal in np.stack([np.cos(angles), np.sin(angles)], axis=1)
                ]
            )

    def times(self, b: Array) -> Array:
        """Return the duration of each interval, s."""
        speed = np.sqrt(b)
        durations: Array = 2.0 * self._ds / (speed[1:] + speed[:-1])
        return durations

    def slow_down(self, b: Array) -> Array:
        """Return b of the same motion slowed down until it keeps all limits; raise LayflatError if none does."""
        for factor in SLOWDOWN_FACTORS:
            slow: Array = b / factor**2
            if self._keeps_limits(slow):
                return slow
        raise LayflatError("no motion along the path keeps all limits, however slow")

    def _keeps_limits(self, b: Array) -> bool:
        """Return whether the squared speeds b keep all limits, without any linearization."""
        torque = self._torque @ b + self._damping * self._repeated(np.sqrt(self._mean @ b)) + self._gravity
        change = self._change @ torque + self._fixed
        allowed = self._rate * self._repeated(self._halves @ self.times(b))
        within = np.all((torque <= self._upper) & (torque >= self._lower)) and np.all(np.abs(change) <= allowed)
        return bool(within and np.all(b <= self._cap) and np.all(self._tip @ b <= 1.0))

    def improve(self, b: Array, step: float) -> Array:
        """Return the b of minimum duration by the linear programme about b, between b / step and b x step.

        Raises:
            LayflatError: the programme has no solution.
        """
        # Scaled by b itself, which varies by many orders of magnitude between rest and full speed.
        column: Matrix = sparse.diags(b).tocsc()[:, 1:-1]
        slopes = self._slopes(b)
        rows, right = self._rows(b, slopes)
        bounds: Any = np.stack(
            [np.full(GRID_INTERVALS - 1, 1.0 / step), np.minimum(step, self._cap[1:-1] / b[1:-1])], axis=1
        )
        result: Any = linprog(slopes.sum(axis=0) @ column / self.times(b).sum(), rows @ column, right, bounds=bounds)
        if result.status != 0:
            raise LayflatError(f"no quickest motion was found: {result.message}")
        improved = b.copy()
        improved[1:-1] *= result.x
        return improved

    def _slopes(self, b: Array) -> Matrix:
        """Return the derivatives of the intervals' times by b."""
        speed = np.sqrt(b)
        common, inner = -self._ds / (speed[1:] + speed[:-1]) ** 2, np.where(speed > 0.0, speed, inf)  # b is 0 at rest
        return sparse.diags(
            [common / inner[:-1], common / inner[1:]], [0, 1], shape=(GRID_INTERVALS, GRID_INTERVALS + 1)
        )

    def _rows(self, b: Array, slopes: Matrix) -> tuple[Matrix, Array]:
        """Return the rows of the linear inequalities and their upper bounds, each scaled by its limit."""
        speed, joints = np.sqrt(self._mean @ b), len(self._gravity) // GRID_INTERVALS
        damped = sparse.diags(self._damping) @ sparse.vstack([sparse.diags(0.5 / speed) @ self._mean] * joints)
        torque, rest = self._torque + damped, self._gravity + self._damping * self._repeated(0.5 * speed)
        h = self._repeated(self._halves @ self.times(b))
        later: Matrix = sparse.diags(self._rate) @ sparse.vstack([self._halves @ slopes] * joints)
        allowed, change = self._rate * h - later @ b, self._change @ torque
        fixed, per_torque, per_change = self._change @ rest + self._fixed, 1.0 / self._scale, 1.0 / (self._rate * h)
        sized, finely = sparse.diags(per_torque), sparse.diags(per_change)
        rows = [sized @ torque, -sized @ torque, finely @ (change - later), finely @ (-change - later), self._tip]
        right = [
            *(per_torque * (self._upper - rest), per_torque * (rest - self._lower)),
            *(per_change * (allowed - fixed), per_change * (allowed + fixed), np.ones(self._tip.shape[0])),
        ]
        return sparse.vstack(rows).tocsr(), np.concatenate(right)

    def _repeated(self, rows: Array) -> Array:
        """Return rows that all joints share, repeated for each joint."""
        return np.tile(rows, len(self._gravity) // GRID_INTERVALS)


def _project_to_plane(first: Array, second: Array) -> tuple[Array, Array]:
    """Return derivatives of the tip's position in the plane that both span, (points, 2)."""
    if first.shape[1] == 2:
        return first, second
    size = np.linalg.norm(first, axis=1)
    along = first / np.maximum(size, MIN_DERIVATIVE)[:, None]
    tangential = np.sum(second * along, axis=1)
    normal = np.linalg.norm(second - tangential[:, None] * along, axis=1)
    return np.stack([size, 0.0 * size], axis=1), np.stack([tangential, normal], axis=1)


INITIAL_STEP_RATIO = 4.0  # greatest factor on b from one solution to the next, at first
CONVERGENCE_GAIN = 1e-5  # relative reduction of the duration that ends the iteration
MAX_PROGRAMMES = 60  # linear programmes on a grid
GRID_PASSES = 2  # nodes of the first are even in the time of the initial motion, of the next in that of its solution
INITIAL_DURATION = 0.02  # of the initial motion, too short for any arm, s


def plan_time_optimal(
    machine: Machine, path: JointPath, *, payload: float | None = None, tip: TipLimits | None = None,
    reserve: float = FEEDBACK_RESERVE, capabilities: JointCapabilities | None = None,
) -> Trajectory:  # fmt: skip
    """Return the quickest motion along a path, from rest to rest; a `RestMotion` of 0 s if the path has no length.

    Args:
        machine: machine whose arm moves.
        path: path of its joints.
        payload: kg; default: the machine's.
        tip: limits of the tip's motion; default: none.
        reserve: fraction of speeds, torques and torque rates that is left to feedback, 0 to 1.
        capabilities: capabilities of the joints; default: those of hoses and valves.

    Raises:
        MachineError: the arm can't hold itself somewhere on the path, or has no valves.
        LayflatError: no motion along the path keeps all limits.
    """
    if path.length < SAME_POINT_DISTANCE:
        return RestMotion(0.0, path.end)
    mass = machine.arm.payload if payload is None else payload
    usable, tip = (capabilities or joint_capabilities(machine)).with_reserve(reserve), tip or TipLimits()
    s = _min_jerk_motion(path.length)
    for _ in range(GRID_PASSES):
        times = np.linspace(0.0, s.x[-1], GRID_INTERVALS + 1)
        programme = PathProgramme(machine, path, mass, usable, tip, s(times))
        b = _solve_programmes(programme, programme.slow_down(s(times, 1) ** 2))
        s = CubicSpline(np.append(0.0, np.cumsum(programme.times(b))), programme.s, bc_type="clamped")
    return PathMotion(float(s.x[-1]), path, lambda times: (s(times), s(times, 1), s(times, 2)))


def _min_jerk_motion(length: float) -> CubicSpline:
    """Return the distance over time (s) of a minimum-jerk motion of a length in `INITIAL_DURATION`.

    It begins with t^3, as a motion by torques of limited rate does.
    """
    u = np.linspace(0.0, 1.0, GRID_INTERVALS + 1)
    return CubicSpline(INITIAL_DURATION * u, length * u**3 * (10.0 - 15.0 * u + 6.0 * u**2), bc_type="clamped")


def _solve_programmes(programme: PathProgramme, b: Array) -> Array:
    """Return the b to which linear programmes converge from an initial one, the best of `MAX_PROGRAMMES` at most."""
    duration, step = programme.times(b).sum(), INITIAL_STEP_RATIO
    for _ in range(MAX_PROGRAMMES):
        solution = programme.improve(b, step)
        gain = 1.0 - programme.times(solution).sum() / duration
        if gain > 0.0:
            b, duration = solution, programme.times(solution).sum()
        else:
            step = step**0.5
        if abs(gain) < CONVERGENCE_GAIN:
            break
    return b
