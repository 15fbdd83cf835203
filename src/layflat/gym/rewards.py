"""Reward of a step: the closer the tip to its goal, the greater.

It is -(d / L + d / (d + l)), from 0 at the goal down to about -2: the first term leads from afar, the second rewards
the last millimetres.

| symbol | meaning | unit |
|---|---|---|
| d | distance of the tip from the goal at the end of the step | m |
| L, l | `FAR_SCALE`, `NEAR_SCALE` | m |
"""

from typing import Any

import numpy as np

from layflat.arrays import Array

FAR_SCALE, NEAR_SCALE = 0.5, 0.01  # m
SUCCESS_DISTANCE = 0.002  # within which the tip is there, m: section 4.2 of the paper


def tip_distances(tips: Array, goals: Array) -> Array:
    """Return the distances between tips and goals, (arms,), m, from positions (3, arms), m."""
    apart = tips - goals
    np.multiply(apart, apart, out=apart)
    squared: Array = np.add.reduce(apart)
    return np.sqrt(squared, out=squared)


def step_rewards(distances: Array) -> Array:
    """Return the rewards, (arms,), at distances (arms,), m."""
    near: Array = distances + NEAR_SCALE
    np.divide(distances, near, out=near)
    near += distances * (1.0 / FAR_SCALE)
    return np.negative(near, out=near)


def step_info(distances: Array) -> dict[str, Any]:
    """Return the information of a step: the distance (m), and whether the tip is there, (arms,) each."""
    return {"distance": distances, "is_success": distances < SUCCESS_DISTANCE}
