"""Stock that workshops keep: plates, flat bars, round tubes and ground shafts."""

from collections.abc import Sequence
from dataclasses import dataclass

from layflat.errors import DesignError

PLATE_THICKNESSES = tuple(size * 1e-3 for size in (1, 1.5, 2, 2.5, 3, 4, 5, 6, 8, 10, 12, 15, 20, 25, 30))
"""Thicknesses of sheet and plate, m (of EN 485-3 and EN 485-4, those in stock)."""
TUBE_OUTER_DIAMETERS = tuple(
    size * 1e-3
    for size in (
        *(10, 12, 15, 16, 20, 22, 25, 28, 30, 32, 35, 40, 45, 50, 55, 60, 65, 70, 75, 80, 85, 90, 95, 100, 105),
        *(110, 115, 120, 125, 130, 140, 150, 160, 170, 180, 190, 200, 220, 250, 280, 300),
    )
)
"""Outer diameters of round tubes, m (EN 755-8)."""
TUBE_WALLS = tuple(size * 1e-3 for size in (1, 1.5, 2, 2.5, 3, 4, 5, 6, 8, 10))
"""Walls of round tubes, m (EN 755-8)."""
THINNEST_WALL = 1.0 / 60.0  # wall of a tube in stock over its outer diameter
H6_TOLERANCES = ((6e-3, 8e-6), (10e-3, 9e-6), (18e-3, 11e-6), (30e-3, 13e-6), (50e-3, 16e-6), (80e-3, 19e-6))
"""Largest diameter of each range from 3 mm on and its tolerance of class h6, m (ISO 286-2)."""
SIZE_TOLERANCE = 1e-7  # within which a size is one of the table, m


@dataclass(frozen=True)
class RoundTube:
    """Round tube."""

    outer: float  # diameter, m
    wall: float  # m

    @property
    def inner(self) -> float:
        """Inner diameter, m."""
        return self.outer - 2 * self.wall


def next_size(minimum: float, sizes: Sequence[float], stock: str) -> float:
    """Return the smallest size in stock that is not below a minimum.

    Args:
        minimum: m.
        sizes: in stock, ascending, m.
        stock: its name in messages, such as "plate".

    Raises:
        DesignError: all sizes are smaller.
    """
    for size in sizes:
        if size + SIZE_TOLERANCE >= minimum:
            return size
    right = f"the largest in stock is {sizes[-1] * 1e3:g} mm"
    raise DesignError(f"{minimum * 1e3:.4g} mm are needed", where=stock, right=right)


def next_thickness(minimum: float) -> float:
    """Return the thinnest plate in stock that is not below a thickness (m); raise DesignError if there is none."""
    return next_size(minimum, PLATE_THICKNESSES, "plate")


def next_tube(outer: float, wall: float) -> RoundTube:
    """Return the smallest tube with an outer diameter and a wall not below those given (m).

    Raises:
        DesignError: no tube is as wide, as thick, or its wall leaves no bore.
    """
    diameter = next_size(outer, TUBE_OUTER_DIAMETERS, "tube")
    tube = RoundTube(diameter, next_size(max(wall, THINNEST_WALL * diameter), TUBE_WALLS, "tube wall"))
    if tube.inner <= 0:
        what = f"a wall of {tube.wall * 1e3:g} mm leaves no bore in {diameter * 1e3:g} mm"
        raise DesignError(what, where="tube wall", right="a thinner wall")
    return tube
