"""Deep groove ball bearings of thin series: 619 up to a bore of 8 mm, 618 above it, with two contact seals.

Boundary dimensions are those of ISO 15; masses and static load ratings (ISO 76) are those of makers' catalogues. A
bearing that oscillates slowly under load, as a joint's, is chosen by its static rating.
"""

from dataclasses import dataclass

from layflat.errors import DesignError

SIZE_TOLERANCE = 1e-6  # within which a bore is one of the table, m


@dataclass(frozen=True)
class Bearing:
    """Sealed deep groove ball bearing."""

    number: str  # of series and bore, such as "61805"
    bore: float  # d, m
    outer: float  # D, m
    width: float  # B, m
    static_load: float  # C0, N
    mass: float  # kg

    @property
    def designation(self) -> str:
        """Designation, such as "61805-2RS"."""
        return f"{self.number}-2RS"


_SIZE_ROWS = (
    # number, d, D, B in mm, C0 in N, mass in g
    ("619/4", 4, 11, 4, 180, 1.7),
    ("619/5", 5, 13, 4, 335, 2.5),
    ("619/6", 6, 15, 5, 270, 3.9),
    ("619/8", 8, 19, 6, 465, 7.1),
    ("61800", 10, 19, 5, 830, 5.3),
    ("61801", 12, 21, 5, 915, 6.3),
    ("61802", 15, 24, 5, 1100, 7.4),
    ("61803", 17, 26, 5, 1270, 8.2),
    ("61804", 20, 32, 7, 2320, 18),
    ("61805", 25, 37, 7, 2600, 22),
    ("61806", 30, 42, 7, 2900, 27),
    ("61807", 35, 47, 7, 3350, 30),
    ("61808", 40, 52, 7, 3750, 34),
    ("61809", 45, 58, 7, 6100, 40),
    ("61810", 50, 65, 7, 6800, 52),
    ("61812", 60, 78, 10, 11400, 110),
)

BEARINGS = tuple(
    Bearing(number, d * 1e-3, D * 1e-3, B * 1e-3, float(load), mass * 1e-3)
    for number, d, D, B, load, mass in _SIZE_ROWS
)
"""Known bearings by bore, ascending."""


def bearing(bore: float) -> Bearing:
    """Return the bearing of a bore (m).

    Raises:
        DesignError: there is none; the message lists the known bores.
    """
    for one in BEARINGS:
        if abs(one.bore - bore) <= SIZE_TOLERANCE:
            return one
    known = ", ".join(f"{one.bore * 1e3:g}" for one in BEARINGS)
    raise DesignError(f"no bearing has a bore of {bore * 1e3:.4g} mm", where="bearing", right=f"bores are {known} mm")
