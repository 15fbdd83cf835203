"""Force that moves the rod of a cylinder against gas, spring and seals.

| symbol | meaning | unit |
|---|---|---|
| x, v | position, positive into the chamber, and its rate | m, m/s |
| p_g | gauge pressure in the chamber | Pa |
| p_m | gauge pressure at which the chamber is held: the mean of a log | Pa |
| A, A' | area at x = 0, and its growth with position | m2, m |
| A_p, A'_p | growth of both with pressure | m2/Pa, m/Pa |
| c, F_0 | spring, and force at x = 0 without pressure | N/m, N |
| Y | friction of a rod that slips, Y = (Y_0 + Y_1 p_r (p_g/p_r)^n) (1 + b(x)) | N |
| n, p_r | exponent of the pressure, and reference pressure (gauge) | 1, Pa |
| b | profile along the stroke, linear between its positions | 1 |
| s, v_s | fraction of the film in the friction, and its speed | 1, m/s |

F = (A + A' x) p_g + (A_p + A'_p x) p_m^2 + F_0 + c x + viscous v + friction. A seal takes the shape of the pressure at
which it is held, and not of a regulator's error while the rod moves. The friction is s Y tanh(v / v_s), of the film of
lubricant (andersson2007), and a sum of elasto-slip elements (physics/hysteresis), each of which carries its fraction of
the rest of Y. No log shows their initial state (see `carried_fraction`).
"""

from math import tanh
from typing import NamedTuple

import numpy as np

from layflat.arrays import Array
from layflat.jit import kernel, law
from layflat.physics.hysteresis.elasto_slip import carried_fraction, slip_element


class Rod(NamedTuple):
    """Constants of a rod in its cylinder, in the order of the table.

    An element has a fraction of all friction and a stiffness (N/m); the profile has items, the first one's position (m)
    and their distance (m).
    """

    area: float
    area_slope: float
    area_growth: float
    area_slope_growth: float
    spring: float
    offset: float
    base: float
    slope: float
    viscous: float
    film_fraction: float
    film_speed: float
    weights: tuple[float, ...]
    stiffness: tuple[float, ...]
    profile: tuple[float, ...] = (0.0, 0.0)
    profile_from: float = 0.0
    profile_step: float = 1.0
    exponent: float = 1.0
    reference_pressure: float = 1.0  # gauge, Pa


class RodLog(NamedTuple):
    """Signals of a log, (samples,) each, and two numbers."""

    position: Array  # m
    speed: Array  # m/s
    pressure: Array  # gauge, Pa
    first: float  # first measured force, N
    mean_pressure: float  # p_m, Pa


@law
def smooth_force(rod, x, v, p_g, p_m):
    """Return the force on the rod of gas, spring, offset and viscous friction, without slip and film, N."""
    shape = (rod.area_growth + rod.area_slope_growth * x) * p_m * p_m
    return (rod.area + rod.area_slope * x) * p_g + shape + rod.offset + rod.spring * x + rod.viscous * v


@law
def profile_at(rod, x):
    """Return b(x), constant beyond the profile's ends."""
    last = len(rod.profile) - 1
    position = min(max((x - rod.profile_from) / rod.profile_step, 0.0), 1.0 * last)
    i = min(int(position), last - 1)
    return rod.profile[i] + (position - i) * (rod.profile[i + 1] - rod.profile[i])


@law
def pressure_friction(rod, p_g):
    """Return the friction that the pressure adds where there is no profile, N; 0 for a negative pressure."""
    p = max(p_g, 0.0)
    if rod.exponent == 1.0:
        return rod.slope * p
    return rod.slope * rod.reference_pressure * (p / rod.reference_pressure) ** rod.exponent


@law
def slip_force(rod, x, p_g):
    """Return Y, the friction of a rod that slips, N."""
    return max((rod.base + pressure_friction(rod, p_g)) * (1.0 + profile_at(rod, x)), 0.0)


@law
def film_force(rod, v, level):
    """Return the force that moves the film at a friction `level` (N) and speed v: of the sign of v, smooth at 0."""
    return rod.film_fraction * level * tanh(v / rod.film_speed)


@kernel
def rod_force(rod, log, force):
    """Write the force on a rod through a log, N, to `force`, (samples,).

    Elements begin with the common fraction of their friction that explains the first measured force.
    """
    x, v, p, p_m = log.position, log.speed, log.pressure, log.mean_pressure
    f = np.empty(len(rod.weights))
    level = slip_force(rod, x[0], p[0])
    smooth = smooth_force(rod, x[0], v[0], p[0], p_m) + film_force(rod, v[0], level)
    share = carried_fraction(log.first - smooth, level * (1.0 - rod.film_fraction))
    for j in range(len(f)):
        f[j] = share * rod.weights[j] * level
    for i in range(len(x)):
        move = x[i] - x[i - 1] if i > 0 else 0.0
        level = slip_force(rod, x[i], p[i])
        total = smooth_force(rod, x[i], v[i], p[i], p_m) + film_force(rod, v[i], level)
        for j in range(len(f)):
            f[j] = slip_element(f[j], rod.stiffness[j], rod.weights[j] * level, move)
            total += f[j]
        force[i] = total
