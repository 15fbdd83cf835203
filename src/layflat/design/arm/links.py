"""Links of a sized arm: round aluminium tubes that bend little under the torque of the joint that turns them.

| symbol | meaning | unit |
|---|---|---|
| T, L | torque at one end, length | N m, m |
| D, w | mean diameter and wall of the tube | m |
| E, I | modulus, second moment of its cross-section, pi/8 D^3 w | Pa, m4 |

A tube that is held at one end and bent by a force at the other, with T where it is held, gives way by T L^2/(3 E I).
"""

from math import hypot, pi
from typing import NamedTuple

from layflat.errors import DesignError

DENSITY, MODULUS = 2700.0, 70e9  # of aluminium, kg/m3 and Pa
WALL = 2e-3  # m
# Outer diameters, m, in which tubes with this wall are commonly sold.
DIAMETERS = tuple(1e-3 * D for D in (25, 30, 35, 40, 45, 50, 60, 70, 80, 90, 100, 120, 150, 180, 200))
SHORTEST = 50e-3  # tube that even a link without length weighs: its bracket, m
GIVES = 0.5e-3  # way that a tube may give for each metre of its length, m/m


class Tube(NamedTuple):
    """A link of a sized arm."""

    length: float  # of which it is made, m
    diameter: float  # outer, m

    @property
    def mass(self) -> float:
        """Of the tube, kg."""
        return pi * (self.diameter - WALL) * WALL * self.length * DENSITY

    @property
    def moments(self) -> tuple[float, float]:
        """Inertias about its middle, along and across its length, kg m2."""
        mean = self.diameter - WALL
        along = 0.25 * self.mass * (mean**2 + WALL**2)
        return along, 0.5 * along + self.mass * self.length**2 / 12.0


def tube(link: tuple[float, float, float], torque: float, where: str) -> Tube:
    """Return the thinnest tube for a link (m) that a joint turns with a torque (N m) at most.

    Raises:
        DesignError: naming `where`: none is stiff enough.
    """
    length = max(hypot(*link), SHORTEST)
    second = torque * length / (3.0 * MODULUS * GIVES)
    wanted = (8.0 * second / (pi * WALL)) ** (1.0 / 3.0) + WALL
    if wanted > DIAMETERS[-1]:
        what = f"a link of {1e3 * length:.0f} mm under {torque:.0f} N m needs a tube of {1e3 * wanted:.0f} mm"
        raise DesignError(
            what, where=where, right=f"at most {1e3 * DIAMETERS[-1]:.0f} mm: ask for less reach or payload"
        )
    return Tube(length, next(D for D in DIAMETERS if wanted <= D))
