"""The rod of a cylinder that is pushed and pulled: what gas, spring and seals ask of the one who moves it.

| symbol | meaning | unit |
|---|---|---|
| x, v | position, positive into the chamber, and its rate | m, m/s |
| p_g | gauge pressure in the chamber | Pa |
| A, A' | area at x = 0, and its growth with position | m2, m |
| c, F_0 | spring, and force at x = 0 without pressure | N/m, N |
| Y | force at which all elements of the friction slip, Y = Y_0 + Y_1 p_g | N |

F = (A + A' x) p_g + F_0 + c x + viscous v + friction. The friction is a sum of elasto-slip elements (loss.py); each
carries its share of Y.
"""

from typing import NamedTuple

from layflat.jit import law


class Rod(NamedTuple):
    """What is constant of a rod in its cylinder, in the order of the table."""

    area: float
    area_slope: float
    spring: float
    offset: float
    base: float
    slope: float
    viscous: float


@law
def smooth_force(rod, x, v, p_g):
    """Force on the rod without the friction that remembers where it turned, N."""
    return (rod.area + rod.area_slope * x) * p_g + rod.offset + rod.spring * x + rod.viscous * v


@law
def slip_force(rod, p_g):
    """Y, N."""
    return rod.base + rod.slope * max(p_g, 0.0)
