"""Inverse kinematics: angles that bring the tip of an arm of any kind to a place, within the strokes.

| symbol | meaning | unit |
|---|---|---|
| q, p | angles, and those that they are to be near to | rad |
| J | by how much the tip moves with each joint | m/rad |
| s | singular values of J, greatest first | m/rad |
| e | way that the tip still has to go | m |
| d | damping | m/rad |

A step is J^T (J J^T + d^2)^-1 e, which with little damping is the shortest that takes the tip there, and on top as much
towards p as leaves the tip where it is (nakamura1986). Joints at the ends of their strokes stay there. The square of
the damping goes with the way that is left, as do the second derivatives that a step knows nothing of: from afar it is
short where the arm is near a singular posture, and the last steps are Newton's. Where that leads nowhere, it is begun
again from postures all over the strokes whose tips are nearest.

A posture is singular if one of the directions in which the tip can move is lost, as where the arm is stretched.
"""

from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from layflat.arrays import Array
from layflat.errors import InputError
from layflat.machine import Machine
from layflat.motion.kinematics import Kinematics
from layflat.motion.path import half_strokes

STEPS = 120
LONGEST = 0.3  # step of a joint, rad
SHORTEST = 1e-8  # step at which it is over, rad
# Steps within which a tip that is further than `FAR` (m) from its place has to come nearer by a share of that.
PATIENCE, FAR, PROGRESS = 10, 1e-3, 1e-4
TOWARDS = 0.5  # share of the way to p that a step goes
DAMPED = 0.25  # d^2 over the way that is left and the arm's size
LEAST = 1e-7  # d over the arm's size
THERE = 1e-6  # distance at which the tip is at a place, m
ASKED = 2e-4  # the same for a place that somebody wrote down, m
SINGULAR = 0.005  # least over greatest singular value below which a posture is singular
BESIDE = 2.0  # the same of a place that is offered beside a singular one, over it
LOST = 1e-9  # the same where the direction is one that the arm never has
KNOWN = 2000  # postures whose tips are known
STARTS = 8, 40  # of these, from which a search begins in turn
BESIDE_STARTS = 6  # postures from which a place beside a singular one is searched
BESIDE_STEPS = 60  # of such a search
INSIDE = 1.0 - 1e-9  # of the strokes, where a fit may begin
EASE = 0.02  # by which a search keeps further from what is singular than it has to
DIFFERENCE = 1e-6  # of angles, for slopes of mobility, rad


class Found(NamedTuple):
    """Postures that were found, and how far from its place each leaves the tip."""

    angles: Array  # (places, joints), rad
    missing: Array  # (places,), m

    @property
    def there(self) -> NDArray[np.bool_]:
        """Whether the tip is at its place, (places,)."""
        reached: NDArray[np.bool_] = self.missing < THERE
        return reached


class Inverse:
    """Inverse kinematics of a machine's arm; each place has the same answer alone and among others."""

    def __init__(self, machine: Machine, *, margin: float = 0.0) -> None:
        """Take the arm of a machine, and a margin (rad) to the ends of its strokes."""
        self._kinematics, self._half = Kinematics(machine), half_strokes(machine) - margin

    @property
    def joints(self) -> int:
        """How many joints the arm has."""
        return len(self._half)

    def tip(self, angles: Array) -> Array:
        """Return where the tip is, (3,), m, at angles (joints,), rad."""
        place: Array = self._kinematics.tip(angles[None])[0]
        return place

    @cached_property
    def _known(self) -> Array:
        """Postures all over the strokes, (postures, joints), rad."""
        return np.random.default_rng(0).uniform(-self._half, self._half, (KNOWN, len(self._half)))

    @cached_property
    def tips(self) -> Array:
        """Places all over where the tip comes to, (places, 3), m."""
        return self._kinematics.tip(self._known)

    @cached_property
    def size(self) -> float:
        """Greatest distance of two places that the tip comes to, about, m."""
        return float(np.linalg.norm(np.ptp(self.tips, axis=0)))

    @cached_property
    def directions(self) -> int:
        """In how many directions the tip can move: 3, or as many as the arm can at all."""
        values = self._singular_values(self._known[:50])
        return int((values > LOST * values[:, :1]).sum(axis=1).max())

    def _singular_values(self, q: Array) -> Array:
        return np.asarray(np.linalg.svd(self._kinematics.tip_and_jacobian(q)[1], compute_uv=False), np.float64)

    def mobility(self, q: Array) -> Array:
        """Return the least over the greatest singular value of postures (points, joints), rad: 0 where singular."""
        values = self._singular_values(q)
        least: Array = values[:, self.directions - 1] / values[:, 0]
        return least

    def near(self, places: Array, angles: Array) -> Found:
        """Return the postures, near to others, with the tip at places, or as near to these as steps from there lead.

        Args:
            places: of the tip, (places, 3), m.
            angles: near to which, (places, joints) or (joints,), rad.
        """
        half, count = self._half, len(places)
        usual = np.clip(np.broadcast_to(angles, (count, len(half))), -half, half)
        best, left, q = Found(usual.copy(), np.full(count, np.inf)), np.arange(count), usual
        before = best.missing.copy()
        for turn in range(STEPS):
            tip, J = self._kinematics.tip_and_jacobian(q)
            e = places[left] - tip
            missing = np.linalg.norm(e, axis=1)
            nearer = (missing < best.missing[left]) | (missing < THERE)
            best.angles[left[nearer]], best.missing[left[nearer]] = q[nearer], missing[nearer]
            d = DAMPED * missing * self.size + (LEAST * self.size) ** 2
            step = _step(J, e, TOWARDS * (usual[left] - q), d, np.where(np.abs(q) >= half, np.sign(q), 0.0))
            size = np.abs(step).max(axis=1, keepdims=True)
            going = size[:, 0] > SHORTEST
            if turn % PATIENCE == PATIENCE - 1:
                now = best.missing[left]
                going &= (now < FAR) | (now < (1.0 - PROGRESS) * before[left])
                before[left] = now
            if not going.any():
                break
            left = left[going]
            q = np.clip(q + step * np.minimum(1.0, LONGEST / np.maximum(size, LONGEST)), -half, half)[going]
        return best

    def anywhere(self, places: Array, angles: Array | float = 0.0) -> Found:
        """As `near`, by default to mid-stroke, but from other postures too where the tip does not come to its place.

        Of postures that bring it there, those that are not singular are preferred, and then the nearest; where none
        does, the one that brings it nearest is returned.
        """
        near = np.broadcast_to(angles, (len(places), len(self._half)))
        best = self.near(places, near)
        for starts in STARTS:
            left = np.flatnonzero(self._rank(best) > 0.0)
            if len(left) == 0:
                break
            apart = np.linalg.norm(self.tips - places[left, None], axis=-1)
            order = np.argsort(apart, axis=1, kind="stable")[:, :starts]
            found = self.near(np.repeat(places[left], starts, axis=0), self._known[order.ravel()])
            shape = (len(left), starts)
            rank = np.column_stack([self._rank(best)[left], self._rank(found).reshape(shape)])
            every = np.concatenate([best.angles[left, None], found.angles.reshape(*shape, -1)], axis=1)
            missing = np.column_stack([best.missing[left], found.missing.reshape(shape)])
            way = np.linalg.norm(every - near[left, None], axis=-1)
            chosen = np.lexsort((way, rank), axis=1)[:, 0]
            rows = np.arange(len(left))
            best.angles[left], best.missing[left] = every[rows, chosen], missing[rows, chosen]
        return best

    def _rank(self, found: Found) -> Array:
        """Return 0 for what is at its place, more where it is singular, and most where it is not there."""
        singular = THERE * (self.mobility(found.angles) < SINGULAR)
        rank: Array = np.where(found.there, singular, found.missing + THERE)
        return rank

    def posture(self, place: Array, angles: Array, where: str) -> Array:
        """Return the posture (joints,), rad, near to another with the tip at a place (axes,), m, to 0.2 mm.

        Raises:
            InputError: naming `where`: it is out of reach, or only singular postures get there; with the nearest place
                that is neither.
        """
        axes = len(place)
        target = np.append(place, np.zeros(3 - axes))
        found = self._polished(target, self.anywhere(target[None], angles))
        missing, singular = float(found.missing[0]), bool(self.mobility(found.angles)[0] < SINGULAR)
        if missing < ASKED and not singular:
            posture: Array = found.angles[0]
            return posture
        instead = (self._beside(target, found.angles[0]) if singular else self._kinematics.tip(found.angles)[0])[:axes]
        if missing >= ASKED:
            what = f"{told(place)} is {1e3 * missing:.1f} mm out of the arm's reach"
            raise InputError(what, where=where, right=f"the nearest place that it reaches is {told(instead)}")
        what = f"{told(place)} is where the arm is in a singular posture, such as stretched"
        right = f"the nearest place beside it is {told(instead)}, {1e3 * np.linalg.norm(instead - place):.1f} mm away"
        raise InputError(what, where=where, right=right)

    def _polished(self, place: Array, found: Found) -> Found:
        """Return a posture that does not reach its place, exactly as near to it as those beside it can be."""
        if found.missing[0] < ASKED:
            return found
        from scipy.optimize import least_squares  # noqa: PLC0415  # takes long to import

        def way(q: Any) -> Any:
            return self.tip(q) - place

        def slope(q: Any) -> Any:
            return self._kinematics.tip_and_jacobian(q[None])[1][0]

        fit = least_squares(
            way,
            np.clip(found.angles[0], -INSIDE * self._half, INSIDE * self._half),
            jac=slope,
            bounds=(-self._half, self._half), xtol=1e-12, ftol=1e-14, gtol=1e-14, max_nfev=200,
        )  # fmt: skip
        missing = float(np.linalg.norm(fit.fun))
        return Found(fit.x[None], np.array([missing])) if missing < found.missing[0] else found

    def _beside(self, place: Array, angles: Array) -> Array:
        """Return the nearest tip to a place that postures bring about which are not singular, by a search from some."""
        from scipy.optimize import NonlinearConstraint, minimize  # noqa: PLC0415

        least, known = BESIDE * SINGULAR, self._known[self.mobility(self._known) > BESIDE * SINGULAR]
        apart = np.linalg.norm(self._kinematics.tip(known) - place, axis=1)
        order = np.argsort(apart, kind="stable")[:BESIDE_STARTS]
        best, nearest = apart[order[0]], self.tip(known[order[0]])

        def way(q: Any) -> tuple[float, Array]:
            tip, J = self._kinematics.tip_and_jacobian(q[None])
            e = (tip[0] - place) / self.size
            return float(e @ e), 2.0 * J[0].T @ e / self.size

        def mobile(q: Any) -> Any:
            return self.mobility(q[None])[0]

        def slope(q: Any) -> Array:
            steps = DIFFERENCE * np.eye(len(q))
            change: Array = self.mobility(q + steps) - self.mobility(q - steps)
            return change / (2.0 * DIFFERENCE)

        inside = NonlinearConstraint(mobile, (1.0 + EASE) * least, 1.0, jac=slope)
        for start in [angles, *known[order]]:
            fit = minimize(
                way, start, jac=True, method="SLSQP", bounds=list(zip(-self._half, self._half, strict=True)),
                constraints=[inside], options={"ftol": 1e-12, "maxiter": BESIDE_STEPS},
            )  # fmt: skip
            q = np.clip(fit.x, -self._half, self._half)
            tip, missing = self.tip(q), float(np.linalg.norm(self.tip(q) - place))
            if missing < best and mobile(q) > least:
                best, nearest = missing, tip
        return nearest


def told(place: Array) -> str:
    """Return a place of the tip (2,) or (3,), m, as text."""
    return ", ".join(
        f"{axis} = {round(1e3 * at, 1) + 0.0:.1f} mm" for axis, at in zip("xyz", place.tolist(), strict=False)
    )


def anywhere(machine: Machine, places: Array, *, margin: float = 0.0) -> Found:
    """Return postures of a machine's arm with the tip at places (places, 3), m: see `Inverse.anywhere`."""
    return Inverse(machine, margin=margin).anywhere(places)


def _step(J: Array, e: Array, aside: Array, d: Array, ended: Array) -> Array:
    # Joints at an end (by its side; 0: none) that the step would take further stay there; the others are asked again.
    held = np.zeros(ended.shape, bool)
    for _ in range(ended.shape[1]):
        step = _through(np.where(held[:, None, :], 0.0, J), e, np.where(held, 0.0, aside), d)
        more = ~held & (step * ended > 0.0)
        if not more.any():
            break
        held |= more
    stepped: Array = np.where(held, 0.0, step)
    return stepped


def _through(J: Array, e: Array, aside: Array, d: Array) -> Array:
    # What goes aside does not move the tip. `d`: its square.
    U, s, V = np.linalg.svd(J, full_matrices=False)
    shares = s / (s * s + d[:, None]) * np.einsum("pxk,px->pk", U, e)
    shares -= (s > LOST * s[:, :1]) * np.einsum("pkj,pj->pk", V, aside)
    step: Array = aside + np.einsum("pkj,pk->pj", V, shares)
    return step
