"""The rod of a cylinder that is pushed and pulled: what gas, spring and seals ask of the one who moves it.

| symbol | meaning | unit |
|---|---|---|
| x, v | position, positive into the chamber, and its rate | m, m/s |
| p_g | gauge pressure in the chamber | Pa |
| A, A' | area at x = 0, and its growth with position | m2, m |
| c, F_0 | spring, and force at x = 0 without pressure | N/m, N |
| Y | force at which all elements of the friction slip, Y = Y_0 + Y_1 p_g | N |

F = (A + A' x) p_g + F_0 + c x + viscous v + friction. The friction is a sum of elasto-slip elements (loss.py); each
carries its share of Y. How they begin a log stands in hysteresis/start.py.
"""

from typing import NamedTuple

import numpy as np

from layflat.arrays import Array
from layflat.identify.benches.hysteresis.start import share_carried
from layflat.jit import kernel, law
from layflat.physics.hysteresis.elasto_slip import slip


class Rod(NamedTuple):
    """What is constant of a rod in its cylinder, in the order of the table; of each element its share and N/m."""

    area: float
    area_slope: float
    spring: float
    offset: float
    base: float
    slope: float
    viscous: float
    weights: tuple[float, ...]
    stiffness: tuple[float, ...]


class RodLog(NamedTuple):
    """What is given of a rod's log: position (m), speed (m/s), gauge pressure (Pa), and the first force (N)."""

    position: Array
    speed: Array
    pressure: Array
    first: float


@law
def smooth_force(rod, x, v, p_g):
    """Force on the rod without the friction that remembers where it turned, N."""
    return (rod.area + rod.area_slope * x) * p_g + rod.offset + rod.spring * x + rod.viscous * v


@law
def slip_force(rod, p_g):
    """Y, N."""
    return rod.base + rod.slope * max(p_g, 0.0)


@kernel
def rod_force(rod, log, force):
    """Force on a rod through a log, N, into `force`, (samples,)."""
    x, v, p = log.position, log.speed, log.pressure
    f = np.empty(len(rod.weights))
    level = slip_force(rod, p[0])
    share = share_carried(log.first - smooth_force(rod, x[0], v[0], p[0]), level)
    for j in range(len(f)):
        f[j] = share * rod.weights[j] * level
    for i in range(len(x)):
        move = x[i] - x[i - 1] if i > 0 else 0.0
        level = slip_force(rod, p[i])
        total = smooth_force(rod, x[i], v[i], p[i])
        for j in range(len(f)):
            f[j] = slip(f[j], rod.stiffness[j], rod.weights[j] * level, move)
            total += f[j]
        force[i] = total
