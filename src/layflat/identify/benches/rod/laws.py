"""The rod of a cylinder that is pushed and pulled: what gas, spring and seals ask of the one who moves it.

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
| b | profile along the stroke, linear between its places | 1 |
| s, v_s | share of the film, and its speed | 1, m/s |

F = (A + A' x) p_g + (A_p + A'_p x) p_m^2 + F_0 + c x + viscous v + friction. A seal takes the shape of the pressure at
which it is held, and not of what a regulator lets through while the rod moves. The friction is s Y tanh(v / v_s), of
the film of lubricant (andersson2007), and a sum of elasto-slip elements (physics/hysteresis), each of which carries its
share of the rest of Y. No log shows how they begin (see `share_carried`).
"""

from math import tanh
from typing import NamedTuple

import numpy as np

from layflat.arrays import Array
from layflat.jit import kernel, law
from layflat.physics.hysteresis.elasto_slip import share_carried, slip


class Rod(NamedTuple):
    """Constants of a rod in its cylinder, in the order of the table.

    Of each element there are its share of all friction and its N/m; of the profile its items, the position of the
    first (m) and how far they lie apart (m).
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
    film_share: float
    film_speed: float
    weights: tuple[float, ...]
    stiffness: tuple[float, ...]
    profile: tuple[float, ...] = (0.0, 0.0)
    profile_from: float = 0.0
    profile_step: float = 1.0
    exponent: float = 1.0
    reference_pressure: float = 1.0  # gauge, Pa


class RodLog(NamedTuple):
    """Signals of a log: position (m), speed (m/s), gauge pressure (Pa), the first force (N), and p_m (Pa)."""

    position: Array
    speed: Array
    pressure: Array
    first: float
    held: float


@law
def smooth_force(rod, x, v, p_g, p_m):
    """Force on the rod without its friction, but for the viscous one, N."""
    shape = (rod.area_growth + rod.area_slope_growth * x) * p_m * p_m
    return (rod.area + rod.area_slope * x) * p_g + shape + rod.offset + rod.spring * x + rod.viscous * v


@law
def profile_at(rod, x):
    """b(x); beyond the profile's ends it is that at the end."""
    last = len(rod.profile) - 1
    place = min(max((x - rod.profile_from) / rod.profile_step, 0.0), 1.0 * last)
    i = min(int(place), last - 1)
    return rod.profile[i] + (place - i) * (rod.profile[i + 1] - rod.profile[i])


@law
def added_by_pressure(rod, p_g):
    """Friction that the pressure adds where there is no profile, N."""
    p = max(p_g, 0.0)
    if rod.exponent == 1.0:
        return rod.slope * p
    return rod.slope * rod.reference_pressure * (p / rod.reference_pressure) ** rod.exponent


@law
def slip_force(rod, x, p_g):
    """Y, N."""
    return max((rod.base + added_by_pressure(rod, p_g)) * (1.0 + profile_at(rod, x)), 0.0)


@law
def film_force(rod, v, level):
    """Force of the film, of a friction `level` (N), at speed v: smooth through rest, and never along the motion."""
    return rod.film_share * level * tanh(v / rod.film_speed)


@kernel
def rod_force(rod, log, force):
    """Force on a rod through a log, N, into `force`, (samples,)."""
    x, v, p, p_m = log.position, log.speed, log.pressure, log.held
    f = np.empty(len(rod.weights))
    level = slip_force(rod, x[0], p[0])
    begun = smooth_force(rod, x[0], v[0], p[0], p_m) + film_force(rod, v[0], level)
    share = share_carried(log.first - begun, level * (1.0 - rod.film_share))
    for j in range(len(f)):
        f[j] = share * rod.weights[j] * level
    for i in range(len(x)):
        move = x[i] - x[i - 1] if i > 0 else 0.0
        level = slip_force(rod, x[i], p[i])
        total = smooth_force(rod, x[i], v[i], p[i], p_m) + film_force(rod, v[i], level)
        for j in range(len(f)):
            f[j] = slip(f[j], rod.stiffness[j], rod.weights[j] * level, move)
            total += f[j]
        force[i] = total
