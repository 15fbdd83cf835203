"""Curves of the tip in space, followed by an arm of any kind and number of joints.

| symbol | meaning | unit |
|---|---|---|
| x(s) | point of the curve at a distance s along it | m |
| J | by how much the tip moves with each joint | m/rad |
| N | directions of joint space that do not move the tip, as columns | 1 |
| g(s), G(s) | splines through postures, and through their N, at nodes along the curve | rad, 1 |

From node to node the arm is led along the curve: q' = J^+ x' + N N^T z, where z leads joints towards mid-stroke, the
more the nearer they are to an end (liegeois1977). The basis N turns no more than it has to. Anywhere on the curve the
angles are those that solve

    tip(q) = x(s),    G(s)^T (q - g(s)) = 0.

The tip is then on its curve however coarse the nodes are: the splines only say what is done with joints to spare.
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
from layflat.motion.inverse import ASKED, SINGULAR, Inverse, told
from layflat.motion.kinematics import Kinematics
from layflat.motion.path import CLOSE, Shape, half_strokes

NODES = 60  # on a curve, at least
FINE = 200  # nodes on a way as long as the arm's size
PULLS = (8.0, 0.05, 5.0), (16.0, 0.01, 10.0)
"""Of z, a way as long as the arm's size; the part of that on which it sets in; and what comes on top at the ends of
strokes. The second is for where the first does not keep a joint from its end."""
CORRECTIONS = 5  # of angles, at most: each squares the error
EXACT = 1e-13  # correction after which none is needed, rad
FAR = 1e-10  # tip beside its curve, at nodes, m
JUMP = 0.3  # from node to node, rad
HALVINGS = 40  # of an interval, to find where the arm's reach ends


class _Node(NamedTuple):
    s: float
    q: Array
    free: Array  # N, (joints, those that are more than it takes)


class SpacePath(TipPath):
    """A curve of the tip as a path of the joints."""

    def __init__(
        self, machine: Machine, curve: Curve, start: Array, where: str, *, span: tuple[float, float] | None = None
    ) -> None:
        """Follow a curve from the posture `start` (joints,), rad, whose tip is where the curve begins.

        The path is led as far as the arm gets between the distances `span` (m; default: the curve's beginning and end).

        Raises:
            InputError: naming `where`: the arm begins in a singular posture.
        """
        self.curve, self.length, self._where = curve, curve.length, where
        self._names, self._half = list(machine.joints), half_strokes(machine)
        self._inverse, self._kinematics = Inverse(machine), Kinematics(machine)
        self._rank = self._inverse.directions
        if self._inverse.mobility(start[None])[0] < SINGULAR:
            right = "move the joints first, or begin elsewhere"
            raise InputError("begins in a singular posture, such as stretched", where=where, right=right)
        first, last = span or (0.0, self.length)
        for self._pull in PULLS:
            backward, self._low = self._led(start, first)
            forward, self._high = self._led(start, last)
            if (self._low == first and self._high == last) or self._rank == len(start):
                break
        self._lay(backward[:0:-1] + forward)

    def at(self, s: Array) -> Shape:
        """Return angles and their derivatives at distances (points,), m, at which the arm reaches the curve."""
        x, x_1, x_2 = self._curve_at(s)
        g, g_1, g_2 = (self._splines(s, order)[..., 0] for order in range(3))
        G, G_1, G_2 = (self._splines(s, order)[..., 1:].swapaxes(1, 2) for order in range(3))
        q = g
        for _ in range(CORRECTIONS):
            tip, J = self._kinematics.tip_and_jacobian(q)
            inverse = np.linalg.pinv(np.concatenate([J, G], axis=1))
            change = _times(inverse, np.concatenate([x - tip, _times(G, g - q)], axis=1))
            q = q + change
            if np.abs(change).max() < EXACT:
                break
        first = _times(inverse, np.concatenate([x_1, _times(G, g_1) + _times(G_1, g - q)], axis=1))
        _, pulled = self._kinematics.tip_motion(q, first, np.zeros_like(q))
        aside = _times(G, g_2) + 2.0 * _times(G_1, g_1 - first) + _times(G_2, g - q)
        return Shape(q, first, _times(inverse, np.concatenate([x_2 - pulled, aside], axis=1)))

    def border(self, end: float) -> float | None:
        """Return how far along the curve (m), on the way to `end`, the arm reaches; None if it is all of the way."""
        reached = self._high if end > 0.0 else self._low
        return reached if abs(end) > abs(reached) + CLOSE else None

    def checked(self) -> "SpacePath":
        """Return the path itself; raise InputError, saying where and why, if the arm can't follow all of it."""
        end = self.border(self.length)
        if end is not None:
            place = self._curve_at(np.array([end])).value[0][: self.curve.at(np.zeros(1)).value.shape[1]]
            why, right = self._why(end)
            what = f"leaves the arm's reach {end:.3f} m along its {self.length:.3f} m, at {told(place)}, {why}"
            raise InputError(what, where=self._where, right=right)
        return self

    def _curve_at(self, s: Array) -> Shape:
        shape = self.curve.at(s)
        if shape.value.shape[1] == 3:
            return shape
        return Shape(*(np.pad(of, ((0, 0), (0, 3 - of.shape[1]))) for of in shape))

    def _led(self, start: Array, end: float) -> tuple[list[_Node], float]:
        """Return nodes from the start on, on the way to a distance (m), and how far the arm gets."""
        nodes, border = [_Node(0.0, start, self._free(start))], end
        for _ in range(2):  # once more, with nodes as close, where it does not get to the end
            count = max(NODES, int(np.ceil(FINE * abs(border) / self._inverse.size)))
            step, nodes = border / count, nodes[:1]
            while len(nodes) <= count and abs(border) > CLOSE and (found := self._next(nodes[-1], step)):
                nodes.append(found)
            if len(nodes) > count or abs(border) <= CLOSE:
                break
            border = self._stops(nodes[-1], step)
        return nodes, border

    def _stops(self, node: _Node, step: float) -> float:
        """Return how far along the curve the arm gets in a step (m) that it can't go from a node."""
        inside, outside = 0.0, 1.0
        for _ in range(HALVINGS):
            middle = (inside + outside) / 2
            inside, outside = (middle, outside) if self._next(node, middle * step) else (inside, middle)
        return node.s + inside * step

    def _next(self, node: _Node, step: float) -> _Node | None:
        """Return the node a step (m) further along the curve; None if the arm can't get there."""
        q = self._ahead(node, step)
        if q is None or np.any(np.abs(q) > self._half + CLOSE):
            return None
        return _Node(node.s + step, q, self._free(q, node.free))

    def _ahead(self, node: _Node, step: float) -> Array | None:
        """Return angles a step ahead, whatever the strokes; None where the tip does not get there, or is singular."""
        s, q, sign = node.s, node.q, float(np.sign(step))
        k_1 = self._rate(s, q, sign)  # the classical method of Runge and Kutta
        k_2 = self._rate(s + step / 2, q + step / 2 * k_1, sign)
        k_3 = self._rate(s + step / 2, q + step / 2 * k_2, sign)
        k_4 = self._rate(s + step, q + step * k_3, sign)
        ahead = q + step / 6 * (k_1 + 2.0 * k_2 + 2.0 * k_3 + k_4)
        x = self._curve_at(np.array([s + step])).value
        for _ in range(CORRECTIONS):
            tip, J = self._kinematics.tip_and_jacobian(ahead[None])
            way = (x - tip)[0]
            if np.abs(way).max() < FAR:
                break
            ahead = ahead + self._inverted(J[0]) @ way
        values = np.linalg.svd(J[0], compute_uv=False)
        lost = np.abs(way).max() > FAR or np.abs(ahead - q).max() > JUMP
        return None if lost or values[self._rank - 1] < SINGULAR * values[0] else ahead

    def _rate(self, s: float, q: Array, sign: float) -> Array:
        """Return q' at a distance (m); `sign`: of the way along the curve."""
        pull, soon, ends = self._pull
        share = (s / (soon * self._inverse.size)) ** 2
        lead = sign * pull / self._inverse.size * share / (1.0 + share)
        z = -lead * q * (1.0 + ends * (q / self._half) ** 6)
        _, J = self._kinematics.tip_and_jacobian(q[None])
        inverse = self._inverted(J[0])
        rate: Array = inverse @ self._curve_at(np.array([s])).first[0] + z - inverse @ (J[0] @ z)
        return rate

    def _inverted(self, J: Array) -> Array:
        """Return the pseudo-inverse of a Jacobian (3, joints), with the directions that the arm has."""
        U, s, V = np.linalg.svd(J, full_matrices=False)
        k = self._rank
        inverse: Array = (V[:k].T / np.maximum(s[:k], CLOSE)) @ U[:, :k].T
        return inverse

    def _free(self, q: Array, like: Array | None = None) -> Array:
        """Return a basis of what leaves the tip where it is, (joints, directions), turned to be like another."""
        _, J = self._kinematics.tip_and_jacobian(q[None])
        free: Array = np.linalg.svd(J[0])[2][self._rank :].T
        if like is None or free.size == 0:
            return free
        U, _, V = np.linalg.svd(free.T @ like)
        turned: Array = free @ (U @ V)
        return turned

    def _lay(self, nodes: list[_Node]) -> None:
        """Lay splines through nodes."""
        rows = [np.column_stack([node.q, node.free]) for node in nodes]
        if len(nodes) == 1:  # the arm does not get anywhere
            self._splines: BSpline = BSpline(np.array([-1.0, 1.0]), np.array(rows), 0)
        else:
            self._splines = make_interp_spline(
                np.array([node.s for node in nodes]), np.array(rows), min(5, len(nodes) - 1)
            )

    def _why(self, end: float) -> tuple[str, str]:
        """Return why the arm gets no further along the curve than to a distance (m), and what would be right."""
        why, right = self._stopped_by(end)
        goal = self._curve_at(np.array([self.length])).value
        nearest = self._inverse.anywhere(goal, self.at(np.array([end])).value)
        if nearest.missing[0] < ASKED:
            return why, right
        place = told(self._kinematics.tip(nearest.angles)[0])
        return why, f"its end is {1e3 * nearest.missing[0]:.1f} mm out of reach: the nearest place is {place}"

    def _stopped_by(self, end: float) -> tuple[str, str]:
        beyond = min(2e-3 * self.length, self.length - end)
        here = _Node(end, self.at(np.array([end])).value[0], np.zeros((0, 0)))
        ahead = self._ahead(here, beyond)
        place = self._curve_at(np.array([end + beyond])).value
        others = self._inverse.anywhere(place)
        if ahead is None and not others.there[0]:
            return "where the arm ends, stretched or folded", "give a way that stays nearer to the middle of its reach"
        if ahead is None:
            return "where the arm is in a singular posture", "give a way that goes round it, or angles"
        joint = int(np.argmax(np.abs(ahead) - self._half))
        why = f"where joint {self._names[joint]!r} leaves its stroke of +-{np.degrees(self._half[joint]):.6g} deg"
        if others.there[0]:
            return f"{why}: only another posture gets there", "give a way that this one can follow, or angles"
        return why, "give a way within it"


def _times(matrices: Array, vectors: Array) -> NDArray[np.float64]:
    product: Array = np.einsum("pij,pj->pi", matrices, vectors)
    return product
