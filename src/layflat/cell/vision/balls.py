"""From the outline of a ball in a picture to the ball: in closed form, for many at once.

Rays that touch a ball of radius r, whose middle is D away in direction c, make a cone: d . c = cos(a), sin(a) = r / D.
So n = c / cos(a) solves d . n = 1 for all rays d of the outline, a linear problem. The middle is `height_ratio` r over
the plane z = h; seen from p that is p_z + D c_z = h + height_ratio D sin(a), which gives D.

A ball that is flattened by k = height / width, its axis upright, is a ball where all heights are divided by k, and rays
that touch it still touch it there: `upright` takes rays there, `flattened` takes points and rays back.

There are R rays an outline; a is the half angle of the cone (rad), c the direction of the ball's middle (unit vector).
"""

import numpy as np

from layflat.cell.geometry import unit_circle
from layflat.cell.vision.boards import Array

ROUNDS = 5  # of fitting and leaving out
FEWEST = 5  # rays that make a cone; with fewer it is a line


def fit_cones(rays: Array, usable: Array, roundness: Array, least: Array) -> tuple[Array, Array, Array]:
    """Fit the cones that touch balls, by least squares without the rays that are off.

    Args:
        rays: unit vectors to outlines, (B, R, 3).
        usable: 1 for rays that may be on the outline, 0 for others, (B, R).
        roundness: how far rays may be off at last, shares of the cone's half angle, (B,).
        least: how far they may be off in any case, rad, (B,).

    Returns:
        Directions of the balls' middles (B, 3), half angles (B,), rad, and which rays are on the outline, (B, R).
    """
    weights = usable.astype(float)
    for number in range(ROUNDS):
        n = np.where((weights.sum(axis=1) < FEWEST)[:, None], rays.mean(axis=1), _solve(rays, weights))
        length = np.linalg.norm(n, axis=1)
        middle, half = n / length[:, None], np.arccos(1.0 / np.maximum(length, 1.0))
        off = np.abs(angles(rays, middle) - half[:, None])
        typical = _typical(off, weights)
        wide = np.maximum(np.maximum(least, roundness * half), (2.5 if number < ROUNDS - 1 else 0.0) * typical)
        weights = usable * (off <= wide[:, None])
    return middle, half, weights


def angles(rays: Array, middle: Array) -> Array:
    """Return angles between rays (B, R, 3) and directions (B, 3), rad; exact where they are small."""
    away = rays - middle[:, None]
    return np.asarray(2.0 * np.arcsin(np.minimum(np.sqrt(np.einsum("bri,bri->br", away, away)) / 2.0, 1.0)))


def place(
    middle: Array, half: Array, eye: Array, plane: float, height_ratio: Array, flattening: Array
) -> tuple[Array, Array]:
    """Place what rests on the plane z = `plane` from cones where it is a ball: middles (B, 3), half widths (B,), m."""
    eyes, sine = np.array([eye] * len(half)).reshape(-1, 3), np.sin(half)
    eyes[:, 2] /= flattening
    far = (eye[2] - plane) / (height_ratio * sine - flattening * middle[:, 2])
    middles = eyes + far[:, None] * middle
    middles[:, 2] *= flattening
    return middles, far * sine


def upright(rays: Array, flattening: Array) -> Array:
    """Return rays (B, R, 3) to what is flattened by (B,) as rays to balls, unit vectors."""
    scaled = rays / np.stack([np.ones_like(flattening), np.ones_like(flattening), flattening], axis=-1)[:, None]
    return np.asarray(scaled / np.linalg.norm(scaled, axis=-1, keepdims=True))


def flattened(rays: Array, flattening: Array) -> Array:
    """Return rays (B, R, 3) to balls as rays to what is flattened by (B,): the inverse of `upright`."""
    return upright(rays, 1.0 / flattening)


def cone_rays(middle: Array, half: Array, count: int) -> Array:
    """Return rays around cones, evenly, (B, `count`, 3) unit vectors: always from the same side on."""
    side = np.cross(middle, np.array([0.0, 1.0, 0.0]))
    side /= np.linalg.norm(side, axis=1, keepdims=True)
    other = np.cross(side, middle)
    cosine, sine = unit_circle(count).T
    around = cosine[None, :, None] * side[:, None] + sine[None, :, None] * other[:, None]
    return np.asarray(np.cos(half)[:, None, None] * middle[:, None] + np.sin(half)[:, None, None] * around)


def _solve(rays: Array, weights: Array) -> Array:
    weighed = (rays * weights[..., None]).transpose(0, 2, 1)
    A, b = weighed @ rays, weighed.sum(axis=2)
    ridge = 1e-12 * np.maximum(weights.sum(axis=1), 1.0)
    return np.asarray(np.linalg.solve(A + ridge[:, None, None] * np.eye(3), b[..., None])[..., 0])


def _typical(off: Array, weights: Array) -> Array:
    """Return the median of what is off by ray, over those in use."""
    used = np.sort(np.where(weights > 0.0, off, np.inf), axis=1)
    middle = np.maximum(weights.sum(axis=1).astype(int) - 1, 0) // 2
    typical = np.take_along_axis(used, middle[:, None], axis=1)[:, 0]
    return np.asarray(np.where(np.isfinite(typical), typical, 0.0))
