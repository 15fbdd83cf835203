"""Angles that bring the tip of any arm to a place: the nearest to others, within the strokes.

| symbol | meaning | unit |
|---|---|---|
| q, p | angles, and those that they are to be near to | rad |
| J | by how much the tip moves with each joint | m/rad |
| e | way that the tip still has to go | m |
| d | damping | m |

A step is J^T (J J^T + d^2)^-1 e, which with little damping is the shortest that takes the tip there, and on top as much
towards p as leaves the tip where it is. Joints at the ends of their strokes stay there. Damping follows the way that is
left, so that steps near a singular posture stay short, and the last ones are Newton's. Source: nakamura1986.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from layflat.arrays import Array
from layflat.machine import Machine
from layflat.motion.kinematics import jacobian, joints_in_space
from layflat.motion.path import half_strokes

STEPS = 80
LONGEST = 0.3  # step of a joint, rad
TOWARDS = 0.3  # share of the way to p that a step goes
DAMPED = 0.3, 1e-9  # d per way that is left; least d, m
THERE = 1e-6  # distance at which the tip is at a place, m


class Found(NamedTuple):
    """Postures that were found, and how far from its place each leaves the tip."""

    angles: Array  # (places, joints), rad
    missing: Array  # (places,), m

    @property
    def there(self) -> NDArray[np.bool_]:
        """Whether the tip is at its place, (places,)."""
        reached: NDArray[np.bool_] = self.missing < THERE
        return reached


def angles_at(machine: Machine, places: Array, near: Array, *, margin: float = 0.0) -> Found:
    """Return the postures, near to others, with the tip at places, or as near to these as steps from there lead.

    Args:
        machine: with an arm of any kind.
        places: of the tip, (places, 3), m.
        near: angles (places, joints) or (joints,), rad.
        margin: to the ends of the strokes, rad.
    """
    half, count = half_strokes(machine) - margin, len(places)
    usual = np.clip(np.broadcast_to(near, (count, len(half))), -half, half)
    q, best = usual.copy(), Found(usual.copy(), np.full(count, np.inf))
    for last in np.arange(STEPS) == STEPS - 1:
        e = places - joints_in_space(machine, q)[0][:, -1]
        missing = np.linalg.norm(e, axis=1)
        nearer = (missing < best.missing) | (missing < THERE)
        best.angles[nearer], best.missing[nearer] = q[nearer], missing[nearer]
        if last:
            break
        step = _step(jacobian(machine, q), e, TOWARDS * (usual - q), np.abs(q) >= half, np.sign(q))
        size = np.abs(step).max(axis=1, keepdims=True)
        if size.max() < 1e-13:
            break
        q = np.clip(q + step * np.minimum(1.0, LONGEST / np.maximum(size, LONGEST)), -half, half)
    return best


def anywhere(machine: Machine, places: Array, *, margin: float = 0.0, starts: int = 16) -> Found:
    """As `angles_at`, near to mid-stroke, or from whichever of many postures leads nearest to a place."""
    half = half_strokes(machine)
    best = angles_at(machine, places, 0.0 * half, margin=margin)
    draw = np.random.default_rng(0)
    for _ in range(starts):
        left = ~best.there
        if not left.any():
            break
        found = angles_at(machine, places[left], draw.uniform(-half, half), margin=margin)
        nearer = found.missing < best.missing[left]
        at = np.flatnonzero(left)[nearer]
        best.angles[at], best.missing[at] = found.angles[nearer], found.missing[nearer]
    return best


def _step(J: Array, e: Array, aside: Array, ended: NDArray[np.bool_], side: Array) -> Array:
    # Joints at an end that the step would take further stay there, and the others are asked again.
    held = np.zeros_like(ended)
    for _ in range(2):
        free = np.where(held[:, None, :], 0.0, J)
        step = _through(free, e, np.where(held, 0.0, aside))
        held = held | (ended & (step * side > 0.0))
    return np.where(held, 0.0, step)


def _through(J: Array, e: Array, aside: Array) -> Array:
    d = np.maximum(DAMPED[0] * np.linalg.norm(e, axis=1), DAMPED[1])
    square = J @ J.swapaxes(1, 2) + (d * d)[:, None, None] * np.eye(3)
    # What goes aside must not move the tip.
    wanted = e - np.einsum("pxj,pj->px", J, aside)
    step: Array = aside + np.einsum("pxj,px->pj", J, np.linalg.solve(square, wanted[..., None])[..., 0])
    return step
