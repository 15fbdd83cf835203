"""Joint paths on which the tip follows a curve in space, for an arm of any kind and number of joints.

| symbol | meaning | unit |
|---|---|---|
| x(s) | point of the curve at a distance s along it | m |
| J | Jacobian of the tip's position | m/rad |
| N | basis of the null space of J, as columns | 1 |
| g(s), G(s) | splines through configurations, and through their N, at nodes along the curve | rad, 1 |

From node to node the path is integrated: q' = J^+ x' + N N^T z, where z moves joints towards mid-stroke, the more the
nearer they are to an end (liegeois1977). The basis N is aligned with that of the node before. Between nodes the angles
solve

    tip(q) = x(s),    G(s)^T (q - g(s)) = 0.

The tip is then on its curve however coarse the nodes are: the splines only determine the redundant joints.
Derivatives are exact: with A the rows of J and G^T, A q' = (x', G^T g' - G'^T (q - g)), and A q'' likewise, from x''
less how q' alone accelerates the tip.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import BSpline, make_interp_spline

from layflat.arrays import Array
from layflat.errors import InputError
from layflat.machine import Machine
from layflat.motion.curve import Curve, TipPath
from layflat.motion.inverse import MIN_MOBILITY, TARGET_TOLERANCE, InverseKinematics, format_position
from layflat.motion.kinematics import Kinematics
from layflat.motion.path import SAME_POINT_DISTANCE, CurveDerivatives, half_strokes
from layflat.motion.planar import PlanarPath
from layflat.physics.arms.planar import PlanarArmPart

MIN_NODES = 60  # on a curve
NODES_PER_ARM_SIZE = 200  # nodes per length of the arm's size
CENTRING_PULLS = (8.0, 0.05, 5.0), (16.0, 0.01, 10.0)
"""Rate of z per length of the arm's size, the part of this length on which z rises, and its increase at the ends of
strokes. The second set is used if a joint reaches its end with the first."""
MAX_CORRECTIONS = 5  # Newton steps of angles: each squares the error
CORRECTION_TOLERANCE = 1e-13  # last correction, rad
NODE_TOLERANCE = 1e-10  # distance of the tip from its curve at nodes, m
MAX_NODE_JUMP = 0.3  # change of an angle from node to node, rad
BORDER_BISECTIONS = 40  # of the interval in which the arm's reach ends


class _PathNode(NamedTuple):
    s: float
    q: Array
    null_space: Array  # N, (joints, redundant joints)


class SpacePath(TipPath):
    """Joint path of an arm of any kind whose tip follows a curve."""

    def __init__(
        self, machine: Machine, curve: Curve, start: Array, where: str, *, span: tuple[float, float] | None = None
    ) -> None:
        """Integrate the path as far as the arm reaches.

        Args:
            machine: machine with the arm.
            curve: curve of the tip.
            start: configuration (joints,), rad, with the tip at the beginning of the curve.
            where: source of the curve, for messages.
            span: distances along the curve between which the path is needed, m; default: its beginning and its end.

        Raises:
            InputError: naming `where`: the arm begins in a singular configuration.
        """
        self.curve, self.length, self._where = curve, curve.length, where
        self._names, self._half = list(machine.joints), half_strokes(machine)
        self._inverse, self._kinematics = InverseKinematics(machine), Kinematics(machine)
        self._rank = self._inverse.directions
        if self._inverse.mobility(start[None])[0] < MIN_MOBILITY:
            right = "move the joints first, or begin elsewhere"
            raise InputError("begins in a singular configuration, such as stretched", where=where, right=right)
        first, last = span or (0.0, self.length)
        for self._pull in CENTRING_PULLS:
            backward, self._low = self._integrate(start, first)
            forward, self._high = self._integrate(start, last)
            if (self._low == first and self._high == last) or self._rank == len(start):
                break
        self._fit_splines(backward[:0:-1] + forward)

    def evaluate(self, s: Array) -> CurveDerivatives:
        """Return angles and their derivatives at distances (points,), m, at which the arm reaches the curve."""
        x, x_1, x_2 = self._curve_at(s)
        g, g_1, g_2 = (self._splines(s, order)[..., 0] for order in range(3))
        G, G_1, G_2 = (self._splines(s, order)[..., 1:].swapaxes(1, 2) for order in range(3))
        q = g
        for _ in range(MAX_CORRECTIONS):
            tip, J = self._kinematics.tip_and_jacobian(q)
            inverse = np.linalg.pinv(np.concatenate([J, G], axis=1))
            change = _multiply_rows(inverse, np.concatenate([x - tip, _multiply_rows(G, g - q)], axis=1))
            q = q + change
            if np.abs(change).max() < CORRECTION_TOLERANCE:
                break
        first = _multiply_rows(
            inverse, np.concatenate([x_1, _multiply_rows(G, g_1) + _multiply_rows(G_1, g - q)], axis=1)
        )
        _, pulled = self._kinematics.tip_motion(q, first, np.zeros_like(q))
        aside = _multiply_rows(G, g_2) + 2.0 * _multiply_rows(G_1, g_1 - first) + _multiply_rows(G_2, g - q)
        return CurveDerivatives(q, first, _multiply_rows(inverse, np.concatenate([x_2 - pulled, aside], axis=1)))

    def reach_limit(self, end: float) -> float | None:
        """Return the distance (m) at which reach (or the path's span) ends before `end`; None if it reaches `end`."""
        reached = self._high if end > 0.0 else self._low
        return reached if abs(end) > abs(reached) + SAME_POINT_DISTANCE else None

    def check_reachable(self) -> "SpacePath":
        """Return the path itself; raise InputError with place and reason if the arm can't follow all of it."""
        end = self.reach_limit(self.length)
        if end is not None:
            place = self._curve_at(np.array([end])).value[0][: self.curve.evaluate(np.zeros(1)).value.shape[1]]
            why, right = self._explain_end_of_reach(end)
            what = (
                f"leaves the arm's reach {end:.3f} m along its {self.length:.3f} m, at {format_position(place)}, {why}"
            )
            raise InputError(what, where=self._where, right=right)
        return self

    def _curve_at(self, s: Array) -> CurveDerivatives:
        """Return the curve at distances s in three dimensions; a plane one has z = 0."""
        shape = self.curve.evaluate(s)
        if shape.value.shape[1] == 3:
            return shape
        return CurveDerivatives(*(np.pad(values, ((0, 0), (0, 3 - values.shape[1]))) for values in shape))

    def _integrate(self, start: Array, end: float) -> tuple[list[_PathNode], float]:
        """Return nodes from the start towards a distance (m), and the distance that the arm reaches."""
        nodes, border = [_PathNode(0.0, start, self._null_space(start))], end
        for _ in range(2):  # once more up to the border, if the reach ends before the end
            count = max(MIN_NODES, int(np.ceil(NODES_PER_ARM_SIZE * abs(border) / self._inverse.size)))
            step, nodes = border / count, nodes[:1]
            while (
                len(nodes) <= count and abs(border) > SAME_POINT_DISTANCE and (following := self._next(nodes[-1], step))
            ):
                nodes.append(following)
            if len(nodes) > count or abs(border) <= SAME_POINT_DISTANCE:
                break
            border = self._border_after(nodes[-1], step)
        return nodes, border

    def _border_after(self, node: _PathNode, step: float) -> float:
        """Return the distance (m) at which the reach ends within a step (m) from a node."""
        inside, outside = 0.0, 1.0
        for _ in range(BORDER_BISECTIONS):
            middle = (inside + outside) / 2
            inside, outside = (middle, outside) if self._next(node, middle * step) else (inside, middle)
        return node.s + inside * step

    def _next(self, node: _PathNode, step: float) -> _PathNode | None:
        """Return the node a step (m) further along the curve; None if the arm does not reach it."""
        q = self._ahead(node, step)
        if q is None or np.any(np.abs(q) > self._half + SAME_POINT_DISTANCE):
            return None
        return _PathNode(node.s + step, q, self._null_space(q, node.null_space))

    def _ahead(self, node: _PathNode, step: float) -> Array | None:
        """Return angles a step (m) ahead, beyond strokes too; None if out of reach or singular."""
        s, q, sign = node.s, node.q, float(np.sign(step))
        k_1 = self._rate(s, q, sign)  # the classical method of Runge and Kutta
        k_2 = self._rate(s + step / 2, q + step / 2 * k_1, sign)
        k_3 = self._rate(s + step / 2, q + step / 2 * k_2, sign)
        k_4 = self._rate(s + step, q + step * k_3, sign)
        ahead = q + step / 6 * (k_1 + 2.0 * k_2 + 2.0 * k_3 + k_4)
        x = self._curve_at(np.array([s + step])).value
        for _ in range(MAX_CORRECTIONS):
            tip, J = self._kinematics.tip_and_jacobian(ahead[None])
            error = (x - tip)[0]
            if np.abs(error).max() < NODE_TOLERANCE:
                break
            ahead = ahead + self._pseudo_inverse(J[0]) @ error
        values = np.linalg.svd(J[0], compute_uv=False)
        lost = np.abs(error).max() > NODE_TOLERANCE or np.abs(ahead - q).max() > MAX_NODE_JUMP
        return None if lost or values[self._rank - 1] < MIN_MOBILITY * values[0] else ahead

    def _rate(self, s: float, q: Array, sign: float) -> Array:
        """Return q' at a distance s (m) and angles q; `sign` is that of the direction along the curve."""
        pull, rise, ends = self._pull
        onset = (s / (rise * self._inverse.size)) ** 2
        gain = sign * pull / self._inverse.size * onset / (1.0 + onset)
        z = -gain * q * (1.0 + ends * (q / self._half) ** 6)
        _, J = self._kinematics.tip_and_jacobian(q[None])
        inverse = self._pseudo_inverse(J[0])
        rate: Array = inverse @ self._curve_at(np.array([s])).first[0] + z - inverse @ (J[0] @ z)
        return rate

    def _pseudo_inverse(self, J: Array) -> Array:
        """Return the pseudo-inverse of a Jacobian (3, joints), with the rank of the arm."""
        U, s, V = np.linalg.svd(J, full_matrices=False)
        k = self._rank
        inverse: Array = (V[:k].T / np.maximum(s[:k], SAME_POINT_DISTANCE)) @ U[:, :k].T
        return inverse

    def _null_space(self, q: Array, reference: Array | None = None) -> Array:
        """Return a basis of the null space of J, (joints, directions), rotated to be nearest to a reference."""
        _, J = self._kinematics.tip_and_jacobian(q[None])
        basis: Array = np.linalg.svd(J[0])[2][self._rank :].T
        if reference is None or basis.size == 0:
            return basis
        U, _, V = np.linalg.svd(basis.T @ reference)
        rotated: Array = basis @ (U @ V)
        return rotated

    def _fit_splines(self, nodes: list[_PathNode]) -> None:
        """Fit splines of configuration and null space through the nodes, over the distance along the curve."""
        rows = [np.column_stack([node.q, node.null_space]) for node in nodes]
        if len(nodes) == 1:  # the arm can't move along the curve
            self._splines: BSpline = BSpline(np.array([-1.0, 1.0]), np.array(rows), 0)
        else:
            self._splines = make_interp_spline(
                np.array([node.s for node in nodes]), np.array(rows), min(5, len(nodes) - 1)
            )

    def _explain_end_of_reach(self, end: float) -> tuple[str, str]:
        """Return why the arm can follow the curve only up to a distance along it (m), and advice.

        If the curve's end is out of reach, the advice is the nearest reachable position of the tip.
        """
        why, right = self._border_reason(end)
        goal = self._curve_at(np.array([self.length])).value
        nearest = self._inverse.solve_globally(goal, self.evaluate(np.array([end])).value)
        if nearest.distance[0] < TARGET_TOLERANCE:
            return why, right
        place = format_position(self._kinematics.tip(nearest.angles)[0])
        away = f"{1e3 * nearest.distance[0]:.1f} mm out of reach"
        return why, f"its end is {away}: the nearest reachable position is {place}"

    def _border_reason(self, end: float) -> tuple[str, str]:
        """Return why the path ends at a distance, m, and advice."""
        beyond = min(2e-3 * self.length, self.length - end)
        here = _PathNode(end, self.evaluate(np.array([end])).value[0], np.zeros((0, 0)))
        ahead = self._ahead(here, beyond)
        place = self._curve_at(np.array([end + beyond])).value
        others = self._inverse.solve_globally(place)
        if ahead is None and not others.reached[0]:
            return "where the arm ends, stretched or folded", "give a path nearer to the middle of its reach"
        if ahead is None:
            return "where the arm is in a singular configuration", "give a path that goes round it, or angles"
        joint = int(np.argmax(np.abs(ahead) - self._half))
        why = f"where joint {self._names[joint]!r} leaves its stroke of +-{np.degrees(self._half[joint]):.6g} deg"
        if others.reached[0]:
            return f"{why}: only another configuration gets there", "give a path that this one can follow, or angles"
        return why, "give a path within it"


def _multiply_rows(matrices: Array, vectors: Array) -> NDArray[np.float64]:
    """Return the product of each point's matrix and vector, (points, rows)."""
    product: Array = np.einsum("pij,pj->pi", matrices, vectors)
    return product


def tip_path(
    machine: Machine, curve: Curve, start: Array, where: str, *, span: tuple[float, float] | None = None
) -> TipPath:
    """Return the joint path on which the tip follows a curve.

    Args:
        machine: machine with the arm: a `PlanarPath` for planar arms, else a `SpacePath`.
        curve: curve of the tip.
        start: configuration (joints,), rad, with the tip at the beginning of the curve.
        where: source of the curve, for messages.
        span: distances along the curve between which the path is needed, m; default: its beginning and its end.

    Raises:
        InputError: naming `where`: the arm has too few joints, or begins in a singular configuration.
    """
    if isinstance(machine.arm, PlanarArmPart):
        return PlanarPath(machine, curve, start, where)
    return SpacePath(machine, curve, start, where, span=span)
