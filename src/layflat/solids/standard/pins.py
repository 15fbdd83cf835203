"""Parallel pins, with designations and masses: soft (ISO 2338) or hardened (ISO 8734)."""

from dataclasses import dataclass
from math import pi

from layflat.errors import DesignError
from layflat.solids.standard.materials import MATERIALS

PIN_LENGTHS = tuple(
    length * 1e-3 for length in (4, 5, 6, 8, 10, 12, 14, 16, 18, 20, 22, 24, 26, 28, 30, 32, 35, 40, 45, 50, 55, 60, 80)
)
"""Preferred lengths, m (ISO 2338)."""
LENGTH_RANGES = {  # of diameters: shortest and longest pin, m (ISO 2338)
    2e-3: (6e-3, 20e-3),
    3e-3: (8e-3, 30e-3),
    4e-3: (8e-3, 40e-3),
    5e-3: (10e-3, 50e-3),
    6e-3: (12e-3, 60e-3),
    8e-3: (14e-3, 80e-3),
    10e-3: (18e-3, 80e-3),
}
SIZE_TOLERANCE = 1e-6  # within which a size is one of the table, m


@dataclass(frozen=True)
class Pin:
    """Parallel pin of tolerance m6."""

    diameter: float  # m
    length: float  # m
    hardened: bool = False  # ISO 8734 in place of ISO 2338

    @property
    def designation(self) -> str:
        """Designation, such as "ISO 2338 6 m6 x 30 - A1"."""
        d, length = self.diameter * 1e3, self.length * 1e3
        return f"ISO 8734 {d:g} x {length:g} - A" if self.hardened else f"ISO 2338 {d:g} m6 x {length:g} - A1"

    @property
    def mass(self) -> float:
        """Mass, kg."""
        density = MATERIALS["bearing-steel" if self.hardened else "stainless-steel"].density
        return density * pi / 4 * self.diameter**2 * self.length


def pin_for(diameter: float, length: float, *, hardened: bool = False) -> Pin:
    """Return the shortest pin of a diameter that is at least as long as demanded.

    Args:
        diameter: nominal, m.
        length: min, m.
        hardened: ISO 8734 in place of ISO 2338.

    Raises:
        DesignError: there is no pin of this diameter, or none as long.
    """
    size = next((d for d in LENGTH_RANGES if abs(d - diameter) <= SIZE_TOLERANCE), None)
    if size is None:
        known = ", ".join(f"{d * 1e3:g}" for d in LENGTH_RANGES)
        raise DesignError(f"there is no pin of {diameter * 1e3:.4g} mm", where="pin", right=f"known are {known} mm")
    shortest, longest = LENGTH_RANGES[size]
    for preferred in PIN_LENGTHS:
        if shortest <= preferred <= longest and preferred + SIZE_TOLERANCE >= length:
            return Pin(size, preferred, hardened)
    what = f"no pin of {size * 1e3:g} mm is {length * 1e3:.4g} mm long"
    raise DesignError(what, where="pin", right=f"the longest is {longest * 1e3:g} mm")
