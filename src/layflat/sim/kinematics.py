"""Where the tip of a machine's arm is."""

import numpy as np

from layflat.arrays import Array
from layflat.machine import Machine, parameters
from layflat.physics.arms import tips_along


def tip_position(machine: Machine, q: Array) -> Array:
    """Position of the tip, (..., 2) in m, x along link 1 at mid-stroke, for angles (..., joints) in rad within +-pi."""
    rows = np.ascontiguousarray(q.reshape(-1, q.shape[-1]))
    tips: Array = tips_along(parameters.arm(machine), (0.0,) * q.shape[-1], rows)
    return tips.reshape(*q.shape[:-1], 2)
