"""Metric coarse threads M2.5 to M12, with sizes of heads, nuts, washers and holes."""

from dataclasses import dataclass
from math import pi

from layflat.errors import DesignError

PITCH_DEPTH = 0.649519  # d - d2 over the pitch (ISO 724)
CORE_DEPTH = 1.226869  # d - d3 over the pitch (ISO 724)


@dataclass(frozen=True)
class Thread:
    """Metric coarse thread (ISO 261) and the sizes that standards tie to it, m."""

    name: str  # such as "M5"
    diameter: float  # d, nominal
    pitch: float  # P (ISO 261)
    tapping_hole: float  # drill (ISO 2306)
    clearance_hole: float  # medium series (ISO 273)
    head_diameter: float  # of a socket screw, plain head (ISO 4762)
    socket: float  # across the flats of its hexagon socket (ISO 4762)
    socket_depth: float  # at least (ISO 4762)
    shortest: float  # screw (ISO 4762)
    longest: float  # screw (ISO 4762)
    nut_flats: float  # across the flats (ISO 4032)
    nut_height: float  # max (ISO 4032)
    washer_hole: float  # (ISO 7089)
    washer_diameter: float  # (ISO 7089)
    washer_thickness: float  # (ISO 7089)

    @property
    def head_height(self) -> float:
        """Height of a socket screw's head, m: the nominal diameter (ISO 4762)."""
        return self.diameter

    @property
    def pitch_diameter(self) -> float:
        """Pitch diameter d2, m: of the cylinder of about the thread's volume (ISO 724)."""
        return self.diameter - PITCH_DEPTH * self.pitch

    @property
    def stress_area(self) -> float:
        """Stress area, m2: of the mean of pitch and core diameter (ISO 898-1)."""
        return pi / 4 * (self.diameter - (PITCH_DEPTH + CORE_DEPTH) / 2 * self.pitch) ** 2

    @property
    def thread_length(self) -> float:
        """Thread of a screw that is not threaded up to its head, m: 2 d + 12 mm (ISO 4762)."""
        return 2 * self.diameter + 12e-3


_SIZE_ROWS = (
    # d, P, tap, clearance | head: dk, s, t, shortest, longest | nut: s, m | washer: d1, d2, h; mm
    (2.5, 0.45, 2.05, 2.9, 4.5, 2, 1.1, 4, 25, 5, 2, 2.7, 6, 0.5),
    (3, 0.5, 2.5, 3.4, 5.5, 2.5, 1.3, 5, 30, 5.5, 2.4, 3.2, 7, 0.5),
    (4, 0.7, 3.3, 4.5, 7, 3, 2, 6, 40, 7, 3.2, 4.3, 9, 0.8),
    (5, 0.8, 4.2, 5.5, 8.5, 4, 2.5, 8, 50, 8, 4.7, 5.3, 10, 1),
    (6, 1, 5, 6.6, 10, 5, 3, 10, 60, 10, 5.2, 6.4, 12, 1.6),
    (8, 1.25, 6.8, 9, 13, 6, 4, 12, 80, 13, 6.8, 8.4, 16, 1.6),
    (10, 1.5, 8.5, 11, 16, 8, 5, 16, 100, 16, 8.4, 10.5, 20, 2),
    (12, 1.75, 10.2, 13.5, 18, 10, 6, 20, 120, 18, 10.8, 13, 24, 2.5),
)

THREADS = {f"M{row[0]}": Thread(f"M{row[0]}", *(round(size * 1e-3, 8) for size in row)) for row in _SIZE_ROWS}
"""Known threads by name."""


def thread(name: str, where: str = "screw") -> Thread:
    """Return a known thread, such as M5.

    Raises:
        DesignError: the thread is unknown; the message begins with `where`, and lists the known ones.
    """
    if name not in THREADS:
        raise DesignError(f"unknown size {name!r}", where=where, right=f"known sizes are {', '.join(THREADS)}")
    return THREADS[name]
