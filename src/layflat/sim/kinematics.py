"""Where the tip of a machine's arm is."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from layflat.machine import Machine, parameters
from layflat.physics.arms import tips_along


def tip_position(machine: Machine, q: NDArray[np.float64]) -> NDArray[np.float64]:
    """Position of the tip, (..., 2) in m, x along link 1 at mid-stroke, for angles (..., joints) in rad within +-pi."""
    rows = np.ascontiguousarray(q.reshape(-1, q.shape[-1]))
    tips: NDArray[np.float64] = tips_along(parameters.arm(machine), (0.0,) * q.shape[-1], rows)
    return tips.reshape(*q.shape[:-1], 2)
