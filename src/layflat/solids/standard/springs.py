"""Compression springs of round wire, computed after EN 13906-1, in steps of wire and diameter as in DIN 2098-1.

| symbol | meaning | unit |
|---|---|---|
| d, D | diameter of the wire, mean diameter of the coils | m |
| n | number of active coils; two more are closed and ground | 1 |
| G | shear modulus | Pa |
| R | rate, R = G d^4/(8 D^3 n) | N/m |
| tau | shear stress without correction, tau = 8 D F/(pi d^3) | Pa |
| Lc, Sa | solid length (n + 2) d, sum of the smallest gaps n (0.0015 D^2/d + 0.1 d) | m |

The free length is the one at which the stress of the solid spring is what EN 13906-1 permits, 0.56 of the tensile
strength, so that no spring can be overloaded.
"""

from dataclasses import dataclass
from math import floor, log10, pi

from layflat.errors import DesignError
from layflat.solids.standard.materials import MATERIALS

SHEAR_MODULUS = 81.5e9  # of patented wire, Pa (EN 13906-1)
SOLID_STRESS_SHARE = 0.56  # permitted stress of the solid spring over the tensile strength (EN 13906-1)
WIRE_DIAMETERS = tuple(size * 1e-3 for size in (0.5, 0.63, 0.8, 1.0, 1.25, 1.6, 2.0, 2.5, 3.2, 4.0, 5.0))
"""Diameters of wire, m (DIN 2098-1)."""
MEAN_DIAMETERS = tuple(size * 1e-3 for size in (2.5, 3.2, 4, 5, 6.3, 8, 10, 12.5, 16, 20, 25, 32, 40, 50))
"""Mean diameters of coils, m (DIN 2098-1)."""
SPRING_INDICES = (4.9, 13.0)  # min and max of D/d (DIN 2098-1: about 5 to 12.5)
ACTIVE_COILS = (3.5, 5.5, 8.5, 12.5)  # n (DIN 2098-1)
LENGTH_STEP = 0.5e-3  # of free lengths, m


def wire_strength(wire: float) -> float:
    """Return the tensile strength of wire SH of a diameter (m), Pa; fits EN 10270-1 within 2 %."""
    return (2220.0 - 820.0 * log10(wire * 1e3)) * 1e6


@dataclass(frozen=True)
class CompressionSpring:
    """Compression spring with closed and ground ends."""

    wire: float  # d, m
    mean_diameter: float  # D, m
    coils: float  # n

    @property
    def outer(self) -> float:
        """Outer diameter, m."""
        return self.mean_diameter + self.wire

    @property
    def rate(self) -> float:
        """Rate R, N/m (EN 13906-1)."""
        return SHEAR_MODULUS * self.wire**4 / (8 * self.mean_diameter**3 * self.coils)

    @property
    def solid_length(self) -> float:
        """Solid length Lc, m (EN 13906-1)."""
        return (self.coils + 2) * self.wire

    @property
    def shortest(self) -> float:
        """Shortest length in use, m: solid length and gaps (EN 13906-1)."""
        return self.solid_length + self.coils * (0.0015 * self.mean_diameter**2 / self.wire + 0.1 * self.wire)

    @property
    def free_length(self) -> float:
        """Length without force, m, in steps of 0.5 mm."""
        permitted = SOLID_STRESS_SHARE * wire_strength(self.wire) * pi * self.wire**3 / (8 * self.mean_diameter)
        return floor((self.solid_length + permitted / self.rate) / LENGTH_STEP + 1e-9) * LENGTH_STEP

    @property
    def mass(self) -> float:
        """Mass, kg."""
        length = pi * self.mean_diameter * (self.coils + 2)
        return MATERIALS["spring-steel"].density * pi / 4 * self.wire**2 * length

    @property
    def designation(self) -> str:
        """Designation by wire, mean diameter and free length, such as "spring 2 x 20 x 62, n = 5.5 - EN 10270-1 SH"."""
        sizes = " x ".join(f"{size * 1e3:.4g}" for size in (self.wire, self.mean_diameter, self.free_length))
        return f"spring {sizes}, n = {self.coils:g} - EN 10270-1 SH"

    def force(self, length: float) -> float:
        """Return the force at a length (m), N."""
        return self.rate * max(0.0, self.free_length - length)

    def stress(self, length: float) -> float:
        """Return the shear stress at a length (m), Pa, without correction (EN 13906-1: static load)."""
        return 8 * self.mean_diameter * self.force(length) / (pi * self.wire**3)


SPRINGS = tuple(
    CompressionSpring(wire, mean, coils)
    for wire in WIRE_DIAMETERS
    for mean in MEAN_DIAMETERS
    if SPRING_INDICES[0] <= mean / wire <= SPRING_INDICES[1]
    for coils in ACTIVE_COILS
)
"""Springs to choose from."""


def spring_for(force: float, space: float, outer: float) -> CompressionSpring:
    """Return the spring that is closest above a force when it is compressed to a space.

    Args:
        force: min, N.
        space: length of the spring in place, m.
        outer: max outer diameter, m.

    Raises:
        DesignError: no spring is strong enough in the space.
    """
    fitting = [s for s in SPRINGS if s.outer <= outer and s.shortest <= space < s.free_length]
    strong = [s for s in fitting if s.force(space) >= force]
    if strong:
        return min(strong, key=lambda s: (s.force(space), s.mass))
    strongest = max((s.force(space) for s in fitting), default=0.0)
    what = f"no spring gives {force:.4g} N in {space * 1e3:.4g} mm below {outer * 1e3:.4g} mm wide"
    raise DesignError(what, where="spring", right=f"the strongest gives {strongest:.4g} N: give it more room")
