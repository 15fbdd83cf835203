"""Inverse kinematics: joint angles, within the strokes, that place the tip of an arm of any kind at a position.

| symbol | meaning | unit |
|---|---|---|
| q, p | angles, and the reference angles that they should be near to | rad |
| J | Jacobian of the tip's position | m/rad |
| s | singular values of J, greatest first | m/rad |
| e | position error of the tip | m |
| d | damping | m/rad |

A step is J^T (J J^T + d^2)^-1 e (damped least squares), plus the part of p - q in the null space of J (nakamura1986).
Joints at the ends of their strokes stay there. The square of the damping is proportional to the error, as are the
second derivatives that a step neglects: far from the target, steps are short near singular configurations, and the last
steps are Newton's. A search that stalls is restarted from those of many random configurations whose tips are nearest.

A configuration is singular if one of the directions in which the tip can move is lost, as where the arm is stretched.
"""

from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from layflat.arrays import Array
from layflat.errors import InputError
from layflat.machine import Machine
from layflat.motion.kinematics import Kinematics, tip_position
from layflat.motion.path import SAME_POINT_DISTANCE, half_strokes

MAX_STEPS_TO_POSITION = 120  # of a search
MAX_JOINT_STEP = 0.3  # rad
MIN_JOINT_STEP = 1e-8  # a search ends with a smaller step, rad
# A search stalls if, further than a distance (m) from the target, so many steps reduce it by less than this fraction.
STALL_STEPS, STALL_DISTANCE, STALL_PROGRESS = 10, 1e-3, 1e-4
REFERENCE_PULL = 0.5  # fraction of p - q in a step
DAMPING_FACTOR = 0.25  # d^2 over the position error and the arm's size
MIN_DAMPING = 1e-7  # d over the arm's size
POSITION_TOLERANCE = 1e-6  # position error of a solution, m
TARGET_TOLERANCE = 2e-4  # position error for targets that people write, m
MIN_MOBILITY = 0.005  # mobility below which a configuration is singular
ALTERNATIVE_MOBILITY_RATIO = 2.0  # mobility of a position offered in place of a singular one, over `MIN_MOBILITY`
RANK_TOLERANCE = 1e-9  # relative singular value of a direction in which the arm never moves
CONFIGURATION_SAMPLES = 2000  # random configurations from which searches start
RESTART_COUNTS = 8, 40  # of these, tried in turn
ALTERNATIVE_STARTS = 6  # configurations from which a position near a singular one is searched
ALTERNATIVE_MAX_STEPS = 60  # of such a search
STROKE_INTERIOR = 1.0 - 1e-9  # fraction of the strokes in which a fit may start
MOBILITY_MARGIN = 0.02  # relative margin to the minimum mobility in the search
DIFFERENCE_STEP = 1e-6  # of angles, for the gradient of mobility, rad


class InverseSolution(NamedTuple):
    """Configurations for several target positions, and the tip's distance from each target."""

    angles: Array  # (positions, joints), rad
    distance: Array  # (positions,), m

    @property
    def reached(self) -> NDArray[np.bool_]:
        """Return whether the tip reaches its target to 1e-6 m, (positions,)."""
        reached: NDArray[np.bool_] = self.distance < POSITION_TOLERANCE
        return reached


class InverseKinematics:
    """Inverse kinematics of a machine's arm; a position has the same solution alone and among others."""

    def __init__(self, machine: Machine, *, margin: float = 0.0) -> None:
        """Prepare the arm of a machine, with a margin (rad) to the ends of its strokes."""
        self._kinematics, self._half = Kinematics(machine), half_strokes(machine) - margin

    @property
    def joints(self) -> int:
        """Number of joints."""
        return len(self._half)

    def tip(self, angles: Array) -> Array:
        """Return the tip's position, (3,), m, at angles (joints,), rad."""
        position: Array = self._kinematics.tip(angles[None])[0]
        return position

    @cached_property
    def _samples(self) -> Array:
        """Random configurations all over the strokes, (samples, joints), rad."""
        return np.random.default_rng(0).uniform(-self._half, self._half, (CONFIGURATION_SAMPLES, len(self._half)))

    @cached_property
    def tips(self) -> Array:
        """Positions of the tip all over its workspace, (samples, 3), m."""
        return self._kinematics.tip(self._samples)

    @cached_property
    def size(self) -> float:
        """Approximate diameter of the tip's workspace, m."""
        return float(np.linalg.norm(np.ptp(self.tips, axis=0)))

    @cached_property
    def directions(self) -> int:
        """Number of directions in which the tip can move, up to 3: the rank of the Jacobian."""
        values = self._singular_values(self._samples[:50])
        return int((values > RANK_TOLERANCE * values[:, :1]).sum(axis=1).max())

    def _singular_values(self, q: Array) -> Array:
        return np.asarray(np.linalg.svd(self._kinematics.tip_and_jacobian(q)[1], compute_uv=False), np.float64)

    def mobility(self, q: Array) -> Array:
        """Return the least over the greatest singular value of the Jacobian, (points,), at q (points, joints), rad.

        It is 0 in a singular configuration; directions in which the arm never moves do not count.
        """
        values = self._singular_values(q)
        ratio: Array = values[:, self.directions - 1] / values[:, 0]
        return ratio

    def solve_near(self, positions: Array, angles: Array) -> InverseSolution:
        """Return configurations for positions of the tip by one search each, from reference angles.

        A search that does not reach its position returns the nearest configuration of its steps.

        Args:
            positions: positions of the tip, (positions, 3), m.
            angles: start and reference p of each search, (positions, joints) or (joints,), rad.
        """
        half, count = self._half, len(positions)
        reference = np.clip(np.broadcast_to(angles, (count, len(half))), -half, half)
        best, active, q = InverseSolution(reference.copy(), np.full(count, np.inf)), np.arange(count), reference
        before = best.distance.copy()
        for iteration in range(MAX_STEPS_TO_POSITION):
            tip, J = self._kinematics.tip_and_jacobian(q)
            e = positions[active] - tip
            distance = np.linalg.norm(e, axis=1)
            nearer = (distance < best.distance[active]) | (distance < POSITION_TOLERANCE)
            best.angles[active[nearer]], best.distance[active[nearer]] = q[nearer], distance[nearer]
            d = DAMPING_FACTOR * distance * self.size + (MIN_DAMPING * self.size) ** 2
            ends = np.where(np.abs(q) >= half, np.sign(q), 0.0)
            step = _joint_step(J, e, REFERENCE_PULL * (reference[active] - q), d, ends)
            size = np.abs(step).max(axis=1, keepdims=True)
            going = size[:, 0] > MIN_JOINT_STEP
            if iteration % STALL_STEPS == STALL_STEPS - 1:
                now = best.distance[active]
                going &= (now < STALL_DISTANCE) | (now < (1.0 - STALL_PROGRESS) * before[active])
                before[active] = now
            if not going.any():
                break
            active = active[going]
            scale = np.minimum(1.0, MAX_JOINT_STEP / np.maximum(size, MAX_JOINT_STEP))
            q = np.clip(q + step * scale, -half, half)[going]
        return best

    def solve_globally(self, positions: Array, angles: Array | float = 0.0) -> InverseSolution:
        """Solve as `solve_near` does, with restarts from other configurations where a position is not reached.

        Of the solutions, regular ones are preferred to singular ones, then the one nearest to the reference angles;
        without a solution, the configuration with the least distance is returned.

        Args:
            positions: positions of the tip, (positions, 3), m.
            angles: reference, (positions, joints) or (joints,), rad; default: mid-stroke.
        """
        near = np.broadcast_to(angles, (len(positions), len(self._half)))
        best = self.solve_near(positions, near)
        for starts in RESTART_COUNTS:
            open_rows = np.flatnonzero(self._rank(best) > 0.0)
            if len(open_rows) == 0:
                break
            apart = np.linalg.norm(self.tips - positions[open_rows, None], axis=-1)
            order = np.argsort(apart, axis=1, kind="stable")[:, :starts]
            restarted = self.solve_near(np.repeat(positions[open_rows], starts, axis=0), self._samples[order.ravel()])
            shape = (len(open_rows), starts)
            rank = np.column_stack([self._rank(best)[open_rows], self._rank(restarted).reshape(shape)])
            candidates = np.concatenate([best.angles[open_rows, None], restarted.angles.reshape(*shape, -1)], axis=1)
            distance = np.column_stack([best.distance[open_rows], restarted.distance.reshape(shape)])
            deviation = np.linalg.norm(candidates - near[open_rows, None], axis=-1)
            selected = np.lexsort((deviation, rank), axis=1)[:, 0]
            rows = np.arange(len(open_rows))
            best.angles[open_rows], best.distance[open_rows] = candidates[rows, selected], distance[rows, selected]
        return best

    def _rank(self, solution: InverseSolution) -> Array:
        """Return 0 for a regular solution, 1e-6 for a singular one, and more for a position that is not reached."""
        singular = POSITION_TOLERANCE * (self.mobility(solution.angles) < MIN_MOBILITY)
        rank: Array = np.where(solution.reached, singular, solution.distance + POSITION_TOLERANCE)
        return rank

    def compute_configuration(self, position: Array, angles: Array, where: str) -> Array:
        """Return the configuration, near to reference angles, with the tip at a position to 0.2 mm.

        Args:
            position: position of the tip, (axes,), m.
            angles: reference, (joints,), rad.
            where: source of the position, for messages.

        Returns:
            Angles (joints,), rad.

        Raises:
            InputError: naming `where`, with the nearest regular position: it is out of reach, or reached by singular
                configurations alone.
        """
        axes = len(position)
        target = np.append(position, np.zeros(3 - axes))
        solution = self._refine(target, self.solve_globally(target[None], angles))
        distance, singular = float(solution.distance[0]), bool(self.mobility(solution.angles)[0] < MIN_MOBILITY)
        if distance < TARGET_TOLERANCE and not singular:
            configuration: Array = solution.angles[0]
            return configuration
        tip = (
            self._nearest_regular(target, solution.angles[0]) if singular else self._kinematics.tip(solution.angles)[0]
        )
        nearest = tip[:axes]
        if distance >= TARGET_TOLERANCE:
            what = f"{format_position(position)} is {1e3 * distance:.1f} mm out of the arm's reach"
            raise InputError(what, where=where, right=f"the nearest reachable position is {format_position(nearest)}")
        what = f"{format_position(position)} is where the arm is in a singular configuration, such as stretched"
        away = 1e3 * np.linalg.norm(nearest - position)
        right = f"the nearest regular position is {format_position(nearest)}, {away:.1f} mm away"
        raise InputError(what, where=where, right=right)

    def _refine(self, position: Array, solution: InverseSolution) -> InverseSolution:
        """Return a single position's solution; refined to a local minimum of distance if it misses by 0.2 mm."""
        if solution.distance[0] < TARGET_TOLERANCE:
            return solution
        from scipy.optimize import least_squares  # noqa: PLC0415  # takes long to import

        def error(q: Any) -> Any:
            return self.tip(q) - position

        def jacobian(q: Any) -> Any:
            return self._kinematics.tip_and_jacobian(q[None])[1][0]

        fit = least_squares(
            error,
            np.clip(solution.angles[0], -STROKE_INTERIOR * self._half, STROKE_INTERIOR * self._half),
            jac=jacobian,
            bounds=(-self._half, self._half), xtol=1e-12, ftol=1e-14, gtol=1e-14, max_nfev=200,
        )  # fmt: skip
        distance = float(np.linalg.norm(fit.fun))
        return InverseSolution(fit.x[None], np.array([distance])) if distance < solution.distance[0] else solution

    def _nearest_regular(self, position: Array, angles: Array) -> Array:
        """Return the tip's position nearest to a given one at which the arm is not singular, by local searches."""
        from scipy.optimize import NonlinearConstraint, minimize  # noqa: PLC0415

        min_mobility = ALTERNATIVE_MOBILITY_RATIO * MIN_MOBILITY
        regular = self._samples[self.mobility(self._samples) > min_mobility]
        distances = np.linalg.norm(self._kinematics.tip(regular) - position, axis=1)
        order = np.argsort(distances, kind="stable")[:ALTERNATIVE_STARTS]
        best, nearest = distances[order[0]], self.tip(regular[order[0]])

        def squared_error(q: Any) -> tuple[float, Array]:
            tip, J = self._kinematics.tip_and_jacobian(q[None])
            e = (tip[0] - position) / self.size
            return float(e @ e), 2.0 * J[0].T @ e / self.size

        def mobility(q: Any) -> Any:
            return self.mobility(q[None])[0]

        def gradient(q: Any) -> Array:
            steps = DIFFERENCE_STEP * np.eye(len(q))
            change: Array = self.mobility(q + steps) - self.mobility(q - steps)
            return change / (2.0 * DIFFERENCE_STEP)

        inside = NonlinearConstraint(mobility, (1.0 + MOBILITY_MARGIN) * min_mobility, 1.0, jac=gradient)
        for start in [angles, *regular[order]]:
            fit = minimize(
                squared_error, start, jac=True, method="SLSQP", bounds=list(zip(-self._half, self._half, strict=True)),
                constraints=[inside], options={"ftol": 1e-12, "maxiter": ALTERNATIVE_MAX_STEPS},
            )  # fmt: skip
            q = np.clip(fit.x, -self._half, self._half)
            tip, distance = self.tip(q), float(np.linalg.norm(self.tip(q) - position))
            if distance < best and mobility(q) > min_mobility:
                best, nearest = distance, tip
        return nearest


def format_position(position: Array) -> str:
    """Return a position of the tip, (2,) or (3,), m, as text in mm."""
    return ", ".join(
        f"{axis} = {round(1e3 * value, 1) + 0.0:.1f} mm" for axis, value in zip("xyz", position.tolist(), strict=False)
    )


def solve_inverse_kinematics(machine: Machine, positions: Array, *, margin: float = 0.0) -> InverseSolution:
    """Return configurations of a machine's arm for positions of the tip, as `InverseKinematics.solve_globally` does.

    Args:
        machine: machine with the arm.
        positions: positions of the tip, (positions, 3), m.
        margin: margin to the ends of the strokes, rad.
    """
    return InverseKinematics(machine, margin=margin).solve_globally(positions)


def _joint_step(J: Array, e: Array, null_motion: Array, squared_damping: Array, ends: Array) -> Array:
    """Return the step with joints fixed that are at an end of their stroke (`ends`: its sign, or 0) and would leave."""
    fixed = np.zeros(ends.shape, bool)
    for _ in range(ends.shape[1]):
        step = _damped_step(np.where(fixed[:, None, :], 0.0, J), e, np.where(fixed, 0.0, null_motion), squared_damping)
        leaving = ~fixed & (step * ends > 0.0)
        if not leaving.any():
            break
        fixed |= leaving
    limited: Array = np.where(fixed, 0.0, step)
    return limited


def _damped_step(J: Array, e: Array, null_motion: Array, squared_damping: Array) -> Array:
    """Return the damped least-squares step for errors e, plus the projection of `null_motion` on the null space."""
    U, s, V = np.linalg.svd(J, full_matrices=False)
    components = s / (s * s + squared_damping[:, None]) * np.einsum("pxk,px->pk", U, e)
    components -= (s > RANK_TOLERANCE * s[:, :1]) * np.einsum("pkj,pj->pk", V, null_motion)
    step: Array = null_motion + np.einsum("pkj,pk->pj", V, components)
    return step


def tip_axes(machine: Machine) -> list[str]:
    """Return the axes along which the tip of a machine's arm has coordinates: x and y, in space z too."""
    return list("xyz")[: tip_position(machine, np.zeros(len(machine.joints))).shape[-1]]


def solve_tip_demand(machine: Machine, positions: Array, near: Array, where: str) -> Array:
    """Return joint angles for demanded positions of the tip; each configuration is near to the one before it.

    Args:
        machine: machine with the arm.
        positions: positions of the tip, (instants, axes), m.
        near: reference angles of the first configuration, (joints,), rad.
        where: source of the positions, for messages.

    Returns:
        Angles (instants, joints), rad.

    Raises:
        InputError: naming `where`: a position is out of reach, or reached by singular configurations alone.
    """
    inverse, before, angles = InverseKinematics(machine), near, np.empty((len(positions), len(machine.joints)))
    last = tip_position(machine, near)
    for k, position in enumerate(positions):
        if np.linalg.norm(position - last) > SAME_POINT_DISTANCE:
            before, last = inverse.compute_configuration(position, before, where), position
        angles[k] = before
    return angles
