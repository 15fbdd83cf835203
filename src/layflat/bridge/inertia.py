"""Inertia that MuJoCo takes: it refuses, with no room for rounding, moments that no body can have."""

import numpy as np

from layflat.arrays import Array
from layflat.physics.arms.chain.description import ROUNDING

MARGIN = 1e-12  # by which the greatest moment is less than the sum of the others, as a share: MuJoCo's own rounding


def realizable_inertia(inertia: Array) -> Array | None:
    """Return the inertia of a body nearest to one (3, 3) that rounding has put out of reach, or None if it is further.

    A thin plate's greatest moment is the sum of both others. In numbers of six digits, or of sixteen, it is as often
    more than that as less. An inertia that a body can have is returned as it is.
    """
    moments, axes = np.linalg.eigh(inertia)
    excess = moments[2] - (moments[0] + moments[1]) * (1.0 - MARGIN)
    if excess <= 0.0:
        return inertia
    if excess > ROUNDING * moments[2] or moments[0] < 0.0:
        return None
    moments[2] -= excess
    if np.count_nonzero(inertia - np.diag(inertia.diagonal())):
        nearest: Array = axes @ np.diag(moments) @ axes.T
        return 0.5 * (nearest + nearest.T)
    greatest = int(np.argmax(inertia.diagonal()))
    diagonal = inertia.diagonal().copy()
    diagonal[greatest] -= excess
    return np.diag(diagonal)


def nearest_inertia(inertia: Array) -> Array:
    """Return `realizable_inertia` of what a description may have; else, of inertias that nobody checked, the same."""
    nearest = realizable_inertia(inertia)
    return inertia if nearest is None else nearest
