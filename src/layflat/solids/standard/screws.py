"""Screws, nuts, washers and threaded rods of stainless steel A2, with designations and masses.

Masses are computed volumes times the density of A2; a thread counts as a cylinder of its pitch diameter.
"""

from dataclasses import dataclass
from math import pi, sqrt

from layflat.errors import DesignError
from layflat.solids.standard.materials import MATERIALS
from layflat.solids.standard.threads import Thread, thread

LENGTHS = tuple(
    length * 1e-3
    for length in (4, 5, 6, 8, 10, 12, 16, 20, 25, 30, 35, 40, 45, 50, 55, 60, 65, 70, 80, 90, 100, 110, 120)
)
"""Preferred lengths of screws, m (ISO 4762)."""
TAPPED_DEPTH = 1.5  # engaged thread in aluminium over the diameter, for a screw of class 70 to break first (VDI 2230)
NUT_OVERHANG = 2.0  # pitches by which a screw stands out of its nut (ISO 4032: the chamfer carries nothing)
LENGTH_TOLERANCE = 1e-6  # within which a length is a preferred one, m
HEXAGON_AREA = sqrt(3.0) / 2  # of a regular hexagon over its squared width across flats
ROD_LENGTHS = (1.0, 2.0)  # in which threaded rod is sold, m (DIN 976-1)
THIN_NUT_HEIGHTS = {
    "M2.5": 1.6e-3, "M3": 1.8e-3, "M4": 2.2e-3, "M5": 2.7e-3, "M6": 3.2e-3, "M8": 4e-3, "M10": 5e-3, "M12": 6e-3,
}  # fmt: skip
"""Heights of thin nuts, m (ISO 4035)."""
PROPERTY_CLASS = "A2-70"  # of screws, nuts and rods (ISO 3506-1, -2)
PROOF_STRESS = MATERIALS["screw-steel"].yield_stress
"""Stress at 0.2 % strain of class 70, Pa (ISO 3506-1)."""
_DENSITY = MATERIALS["screw-steel"].density


def _round_area(diameter: float) -> float:
    """Return the area of a circle (diameter in m), m2."""
    return pi / 4 * diameter**2


@dataclass(frozen=True)
class Screw:
    """Hexagon socket head cap screw (ISO 4762)."""

    thread: Thread
    length: float  # below the head, m

    @property
    def designation(self) -> str:
        """Designation, such as "ISO 4762 M5 x 16 - A2-70"."""
        return f"ISO 4762 {self.thread.name} x {self.length * 1e3:g} - {PROPERTY_CLASS}"

    @property
    def threaded_length(self) -> float:
        """Length of its thread, m: all of a short screw."""
        return min(self.length, self.thread.thread_length)

    @property
    def mass(self) -> float:
        """Mass, kg."""
        size = self.thread
        head = _round_area(size.head_diameter) * size.head_height - HEXAGON_AREA * size.socket**2 * size.socket_depth
        shank = _round_area(size.diameter) * (self.length - self.threaded_length)
        return _DENSITY * (head + shank + _round_area(size.pitch_diameter) * self.threaded_length)


def screw_lengths(size: str) -> tuple[float, ...]:
    """Return the preferred lengths of a size, m (ISO 4762)."""
    limits = thread(size)
    return tuple(length for length in LENGTHS if limits.shortest <= length + LENGTH_TOLERANCE <= limits.longest + 1e-5)


def screw(size: str, length: float) -> Screw:
    """Return the screw of a size, such as M5, and a preferred length (m).

    Raises:
        DesignError: there is no such size or length; the message lists those that there are.
    """
    lengths = screw_lengths(size)
    for preferred in lengths:
        if abs(length - preferred) <= LENGTH_TOLERANCE:
            return Screw(thread(size), preferred)
    known = ", ".join(f"{preferred * 1e3:g}" for preferred in lengths)
    raise DesignError(
        f"there is no ISO 4762 {size} x {length * 1e3:.6g}", where="screw", right=f"lengths of {size} are {known} mm"
    )


def screw_for(grip: float, size: str, engagement: float | None = None) -> Screw:
    """Return the shortest screw that clamps parts and engages its thread deeply enough.

    Args:
        grip: thickness of the clamped parts with washers, without the tapped one, m.
        size: thread, such as M5.
        engagement: length in the tapped part, m; default: `TAPPED_DEPTH` diameters. For a nut: `nut_engagement`.

    Raises:
        DesignError: the size is unknown, or its longest screw is too short.
    """
    need = grip + (TAPPED_DEPTH * thread(size).diameter if engagement is None else engagement)
    for length in screw_lengths(size):
        if length + LENGTH_TOLERANCE >= need:
            return Screw(thread(size), length)
    what = f"no ISO 4762 {size} is {need * 1e3:.4g} mm long"
    right = f"the longest is {screw_lengths(size)[-1] * 1e3:g} mm: clamp thinner parts, or use a threaded rod"
    raise DesignError(what, where="screw", right=right)


@dataclass(frozen=True)
class Nut:
    """Hexagon nut (ISO 4032), or a thin one (ISO 4035)."""

    thread: Thread
    thin: bool = False

    @property
    def height(self) -> float:
        """Height, m."""
        return THIN_NUT_HEIGHTS[self.thread.name] if self.thin else self.thread.nut_height

    @property
    def designation(self) -> str:
        """Designation, such as "ISO 4032 M5 - A2-70" or "ISO 4035 M5 - A2-025"."""
        standard, strength = ("ISO 4035", "A2-025") if self.thin else ("ISO 4032", PROPERTY_CLASS)
        return f"{standard} {self.thread.name} - {strength}"

    @property
    def mass(self) -> float:
        """Mass, kg."""
        size = self.thread
        return _DENSITY * self.height * (HEXAGON_AREA * size.nut_flats**2 - _round_area(size.pitch_diameter))


@dataclass(frozen=True)
class Washer:
    """Plain washer (ISO 7089)."""

    thread: Thread

    @property
    def designation(self) -> str:
        """Designation, such as "ISO 7089 5 - 200 HV - A2"."""
        return f"ISO 7089 {self.thread.diameter * 1e3:g} - 200 HV - A2"

    @property
    def mass(self) -> float:
        """Mass, kg."""
        size = self.thread
        ring = _round_area(size.washer_diameter) - _round_area(size.washer_hole)
        return _DENSITY * size.washer_thickness * ring


@dataclass(frozen=True)
class ThreadedRod:
    """Threaded rod (DIN 976-1), cut to length."""

    thread: Thread
    length: float  # m

    @property
    def designation(self) -> str:
        """Designation, such as "DIN 976-1 M6 x 150 - A2-70"."""
        return f"DIN 976-1 {self.thread.name} x {round(self.length * 1e3, 1):g} - {PROPERTY_CLASS}"

    @property
    def mass(self) -> float:
        """Mass, kg."""
        return _DENSITY * self.length * _round_area(self.thread.pitch_diameter)


def nut(size: str, *, thin: bool = False) -> Nut:
    """Return the nut, or the thin one, of a size, such as M5."""
    return Nut(thread(size), thin)


def washer(size: str) -> Washer:
    """Return the washer of a size, such as M5."""
    return Washer(thread(size))


def nut_engagement(size: str) -> float:
    """Return the length of thread that a nut needs, m: its height and an overhang."""
    return thread(size).nut_height + NUT_OVERHANG * thread(size).pitch


def threaded_rod(size: str, length: float) -> ThreadedRod:
    """Return the threaded rod of a size, cut to a length (m).

    Raises:
        DesignError: the size is unknown, or the length more than a rod's.
    """
    if not 0 < length <= ROD_LENGTHS[-1]:
        right = f"rods are sold in {' and '.join(f'{sold:g}' for sold in ROD_LENGTHS)} m"
        raise DesignError(f"a threaded rod of {length:.4g} m", where="screw", right=right)
    return ThreadedRod(thread(size), length)
