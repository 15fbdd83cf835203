"""Force on a rod through a measured motion: see laws.py and hysteresis/start.py."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from layflat.identify.benches.hysteresis.start import share_carried
from layflat.identify.benches.rod.laws import Rod, slip_force, smooth_force
from layflat.jit import kernel
from layflat.parallel import on_all_cores
from layflat.physics.hysteresis.elasto_slip import slip

Array = NDArray[np.float64]


class RodLog(NamedTuple):
    """What is given of a rod's log: position (m), speed (m/s), gauge pressure (Pa), and the first force (N)."""

    position: Array
    speed: Array
    pressure: Array
    first: float


@kernel
def _force(rod, weights, stiffness, log, force):
    x, v, p = log.position, log.speed, log.pressure
    f = np.empty(len(weights))
    level = slip_force(rod, p[0])
    share = share_carried(log.first - smooth_force(rod, x[0], v[0], p[0]), level)
    for j in range(len(f)):
        f[j] = share * weights[j] * level
    for i in range(len(x)):
        move = x[i] - x[i - 1] if i > 0 else 0.0
        level = slip_force(rod, p[i])
        total = smooth_force(rod, x[i], v[i], p[i])
        for j in range(len(f)):
            f[j] = slip(f[j], stiffness[j], weights[j] * level, move)
            total += f[j]
        force[i] = total


def rod_forces(rods: Sequence[Rod], weights: Array, stiffness: Array, log: RodLog) -> Array:
    """Force on a rod through a log, (candidates, samples), N.

    Args:
        rods: one a candidate.
        weights: share of every element in the friction, (candidates, elements).
        stiffness: of every element, N/m, (candidates, elements).
        log: what is given.
    """
    forces = np.empty((len(rods), len(log.position)))
    on_all_cores(lambda i: _force(rods[i], weights[i], stiffness[i], log, forces[i]), range(len(rods)))
    return forces
