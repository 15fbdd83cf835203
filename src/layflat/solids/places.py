"""Places of bars, screws and stops in the frame of a joint, mm."""

from __future__ import annotations

from math import asin, cos, hypot, radians, sin, sqrt
from typing import TYPE_CHECKING

from layflat.errors import DesignError
from layflat.lazy import numpy as np
from layflat.solids.loops import HullCircle, hull
from layflat.solids.section import WEBBING_THICKNESS
from layflat.solids.sizes import MM
from layflat.solids.standard.processes import smallest_wall
from layflat.solids.standard.screws import nut_engagement, screw_lengths

if TYPE_CHECKING:
    from layflat.solids.loops import Loop
    from layflat.solids.sizes import JointSizes

EDGE_GAP = 0.3  # between the clamp bars and the cylinder, mm
SCREW_SHARE, END_SHARE = 0.12, -0.22  # places of the clamp's and the end plates' screws over a bar's depth
TIE_ANGLE = radians(189.0)  # of the tie bar on the side of hose A
FOOT_ANGLES = tuple(radians(a) for a in (-50.0, -130.0, 165.0, 15.0))  # of the foot's studs
TONGUE_PITCH = 2.5  # between the holes of a tongue over the diameter of the screws
LEAST_BAR_WALL = 0.7  # around the threads in the ends of a clamp bar, mm
BUSH_WALL = 4.0  # of an end plate around the flange of the bush, mm
TIE_SHARE = 2.0  # diameter of a tie bar over that of the screws in it
STOP_SHARES = (2.0, 1.9, 1.8, 1.7, 1.6, 1.5, 2.2, 2.4, 2.6, 2.8)
"""Distances of a bump stop from the output's axis over half of an arm plate's width, in the order of preference."""
STOP_GAP = 0.1  # least distance of a bump stop from the cylinder, mm
STOP_WALL = 0.6  # wall of a bump stop's rubber over the diameter of its screw


def bar_place(sizes: JointSizes) -> tuple[float, float, float]:
    """Return x and y of the middle of the clamp bar on the side of +x, and its depth along y, mm.

    Raises:
        DesignError: the cylinder is too small for bars with walls around their screws, or no screws fit given bars.
    """
    bar, low = sizes.clamp_bar, _bar_distance(sizes)
    bottom, top = _bar_ends(sizes.inner_radius, low + bar, sizes.tail)
    given = sizes.build.clamp_bar_thickness is not None
    if _bar_room(sizes, top - bottom) < 0.0 or (given and not _screws_fit(sizes, bar)):
        what = f"the screws of the hoses' clamp have no place in bars {bar:g} mm thick"
        raise DesignError(what, where=sizes.label, right="a wider cylinder leaves room")
    return low + bar / 2, (bottom + top) / 2, top - bottom


def _bar_distance(sizes: JointSizes) -> float:
    """Return the distance of a clamp bar from the middle of the joint, mm."""
    return WEBBING_THICKNESS + sizes.hose_thickness


def _bar_ends(inner_radius: float, high: float, tail: float) -> tuple[float, float]:
    """Return the ends of a clamp bar along y, mm, from its distance from the middle and the length of hose in it."""
    if high >= inner_radius:
        return 0.0, 0.0
    return -sqrt(inner_radius**2 - high**2) + EDGE_GAP, -inner_radius + tail


def _bar_room(sizes: JointSizes, depth: float) -> float:
    """Return how much thicker than needed the least wall around the screws of a clamp bar of a depth is, mm."""
    screws = (0.5 - SCREW_SHARE) * depth - sizes.screw.clearance_hole * MM / 2
    ends = (0.5 + END_SHARE) * depth - sizes.screw.tapping_hole * MM / 2
    return min(screws - smallest_wall("milling") * MM, ends - LEAST_BAR_WALL)


def _screws_fit(sizes: JointSizes, bar: float) -> bool:
    """Return whether screws fit the ends of clamp bars of a thickness, mm, and the longest ones reach through both."""
    grip = 2 * (_bar_distance(sizes) + bar + sizes.screw.washer_thickness * MM)
    name = sizes.screw.name
    return bar >= sizes.least_clamp_bar and grip <= (screw_lengths(name)[-1] - nut_engagement(name)) * MM


def frame_places(sizes: JointSizes) -> list[tuple[float, float]]:
    """Return the places of the screws of an end plate: two in the clamp bars, two in the tie bars, mm."""
    x, y, depth = bar_place(sizes)
    return [(x, y + END_SHARE * depth), (-x, y + END_SHARE * depth), *tie_places(sizes)]


def clamp_line(sizes: JointSizes) -> float:
    """Return y of the screws through both clamp bars, mm."""
    _, y, depth = bar_place(sizes)
    return y + SCREW_SHARE * depth


def clamp_heights(sizes: JointSizes) -> list[float]:
    """Return where the screws of the clamp are along z, mm."""
    room = sizes.hose_width - 2 * sizes.screw.head_diameter * MM
    return [float(z) for z in np.linspace(-0.5, 0.5, sizes.clamp_screws) * room]


def tie_radius(sizes: JointSizes) -> float:
    """Return the radius of a tie bar of the frame, mm."""
    return TIE_SHARE * sizes.screw.diameter * MM / 2


def tie_places(sizes: JointSizes) -> list[tuple[float, float]]:
    """Return the places of the two tie bars, mm."""
    distance = sizes.inner_radius - tie_radius(sizes) - 1.0
    x, y = distance * cos(TIE_ANGLE), distance * sin(TIE_ANGLE)
    return [(x, y), (-x, y)]


def stop_places(sizes: JointSizes) -> list[tuple[float, float]]:
    """Return the places of the bump stops of an end plate, which the arm plates meet at the mechanical limits, mm.

    They lie nearer to the output's axis where they would meet the cylinder.
    """
    low, high = sizes.inner_radius - STOP_GAP, sizes.radius + STOP_GAP
    radius = stop_radius(sizes)
    for share in STOP_SHARES:
        x, y = _stop_place(sizes, share)
        if hypot(x, y) + radius <= low or hypot(x, y) - radius >= high:
            return [(-x, y), (x, y)]
    what = "the bump stops meet the cylinder"
    right = "another output.shaft_offset, or a smaller build.screw, moves them away"
    raise DesignError(what, where=sizes.label, right=right)


def _stop_place(sizes: JointSizes, share: float) -> tuple[float, float]:
    """Return the place of the bump stop on the side of +x; `share` is a distance of `STOP_SHARES`."""
    half = sizes.arm_width / 2
    distance = share * half
    angle = sizes.swing + asin(min(1.0, (half + stop_radius(sizes)) / distance))
    return distance * sin(angle), sizes.axis + distance * cos(angle)


def tongue_holes(sizes: JointSizes) -> list[tuple[float, float]]:
    """Return the two holes of the tongue by which a link carries the joint, the inner one first, mm; none without."""
    if sizes.mount is None:
        return []
    step = TONGUE_PITCH * sizes.screw.diameter * MM
    first = sizes.rim + sizes.screw.head_diameter * MM / 2 + 1.0
    return [(r * cos(sizes.mount), r * sin(sizes.mount)) for r in (first, first + step)]


def foot_places(sizes: JointSizes) -> list[tuple[float, float]]:
    """Return the places of the studs of the foot, mm; none where a link carries the joint."""
    if not sizes.foot:
        return []
    radius = sizes.rim - 1.2 * sizes.screw.diameter * MM
    return [(radius * cos(a), radius * sin(a)) for a in FOOT_ANGLES]


def stop_radius(sizes: JointSizes) -> float:
    """Return the outer radius of a bump stop, mm."""
    return sizes.screw.diameter * MM * (0.5 + STOP_WALL)


def end_plate_loop(sizes: JointSizes) -> Loop:
    """Return the outline of the end plates: around cylinder, bush and bump stops, with the tongue for a link."""
    tongue = [HullCircle(x, y, sizes.arm_width / 2) for x, y in tongue_holes(sizes)[1:]]
    around_bush = HullCircle(0.0, sizes.axis, sizes.bush.flange * MM / 2 + BUSH_WALL)
    stops = [HullCircle(x, y, stop_radius(sizes)) for x, y in stop_places(sizes)]
    return hull([*tongue, HullCircle(0.0, 0.0, sizes.rim), around_bush, *stops])
