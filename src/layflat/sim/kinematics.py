"""Where the tip of a machine's arm is."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from layflat.jit import kernel
from layflat.machine import Machine, parameters
from layflat.physics.plant import tip


@kernel
def _tips(arm, q):
    tips = np.empty((len(q), 2))
    for i in range(len(q)):
        tips[i, 0], tips[i, 1] = tip(arm, q[i])
    return tips


def tip_position(machine: Machine, q: NDArray[np.float64]) -> NDArray[np.float64]:
    """Position of the tip, (..., 2) in m, x along link 1 at mid-stroke, for angles (..., joints) in rad within +-pi."""
    rows = np.ascontiguousarray(q.reshape(-1, q.shape[-1]))
    tips: NDArray[np.float64] = _tips(parameters.arm(machine), rows).reshape(*q.shape[:-1], 2)
    return tips
