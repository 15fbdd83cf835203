"""Plain bushes of polymer with a flange, which run dry and can be washed.

Diameters are those of ISO 3547-1, flanges those of makers' catalogues.
"""

from dataclasses import dataclass
from math import pi

from layflat.errors import DesignError
from layflat.solids.standard.materials import MATERIALS

ALLOWED_PRESSURE = 40e6  # of load over bore times length, Pa: half of what catalogues allow at rest
SIZE_TOLERANCE = 1e-6  # within which a bore is one of the table, m


@dataclass(frozen=True)
class Bush:
    """Plain bush with a flange."""

    bore: float  # m
    outer: float  # m
    flange: float  # diameter, m

    @property
    def flange_thickness(self) -> float:
        """Thickness of its flange, m: that of its wall."""
        return (self.outer - self.bore) / 2

    def designation(self, length: float) -> str:
        """Return the designation of a bush of a length (m), such as "flanged bush ISO 3547 - 8 x 10 x 6, polymer"."""
        sizes = " x ".join(f"{size * 1e3:g}" for size in (self.bore, self.outer, length))
        return f"flanged bush ISO 3547 - {sizes}, polymer"

    def mass(self, length: float) -> float:
        """Return the mass of a bush of a length (m), flange included, kg."""
        body = (self.outer**2 - self.bore**2) * length
        rim = (self.flange**2 - self.outer**2) * self.flange_thickness
        return MATERIALS["POM"].density * pi / 4 * (body + rim)

    def allowed_load(self, length: float) -> float:
        """Return the load that a bush of a length (m) bears, N."""
        return ALLOWED_PRESSURE * self.bore * length


_SIZE_ROWS = (  # bore, outer, flange, mm
    (4, 5.5, 9.5), (5, 7, 11), (6, 8, 12), (8, 10, 15), (10, 12, 18), (12, 14, 20), (15, 17, 23), (17, 19, 25),
    (20, 23, 30), (25, 28, 35), (30, 34, 42), (35, 39, 47), (40, 44, 52), (45, 50, 60), (50, 55, 65), (60, 65, 75),
)  # fmt: skip
BUSHES = tuple(Bush(*(size * 1e-3 for size in row)) for row in _SIZE_ROWS)
"""Known bushes by bore, ascending."""


def bush(bore: float, where: str = "bush") -> Bush:
    """Return the bush of a bore (m).

    Raises:
        DesignError: there is none; the message begins with `where`, and lists the known bores.
    """
    for one in BUSHES:
        if abs(one.bore - bore) <= SIZE_TOLERANCE:
            return one
    known = ", ".join(f"{one.bore * 1e3:g}" for one in BUSHES)
    raise DesignError(f"no bush has a bore of {bore * 1e3:.4g} mm", where=where, right=f"bores are {known} mm")
