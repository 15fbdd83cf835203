"""Connections of joints: struts from arm plates to the next joint or the tool's flange, and the foot of an arm.

A strut is a tube with flattened ends, the eyes, each bolted by two screws. All lengths are in mm, in the frame of the
link: that of the output of its joint, with the output's axis as z and the arm at mid-stroke as y.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import cos, inf, pi, sin, tan
from typing import TYPE_CHECKING

from layflat.lazy import numpy as np
from layflat.solids.component import Component, axes_towards
from layflat.solids.hardware import hexagon_nut, sleeve, socket_screw, stud
from layflat.solids.loops import circle, rectangle
from layflat.solids.output import link_holes, tie_radius
from layflat.solids.section import CrossSection
from layflat.solids.shapes import Hole, Joined, PartPlace, Prism, Turned, joined, place
from layflat.solids.sizes import MM
from layflat.solids.standard.materials import MATERIALS
from layflat.solids.standard.screws import nut_engagement, screw_for
from layflat.solids.standard.stock import TUBE_OUTER_DIAMETERS, next_tube

if TYPE_CHECKING:
    from layflat.arrays import Array
    from layflat.solids.sizes import JointSizes
    from layflat.solids.standard.threads import Thread

STRUT_SAFETY = 3.0  # required yield over bending stress of a strut that bears half of the joint's torque
MAX_SLENDERNESS = 16.0  # most that a strut is long over its diameter
STRUT_WALL = 2e-3  # of a strut, m
LEAST_COSINE = 0.95  # least cosine between a strut and its eye, else the eye is longer
STEEP_SHARE = 1.5  # length by which an eye is longer then, over the strut's diameter
EYE_EDGE = 1.5  # of an eye beyond the head of its screw, mm
EYE_GAP = 3.0  # of an eye beyond the plate that it lies on, mm
FLANGE_DIAMETER, FLANGE_CIRCLE, FLANGE_THICKNESS = 63.0, 50.0, 6.0  # of the tool's flange, mm (ISO 9409-1-50)
FLANGE_SCREW = 5.0  # tapping hole of M6, mm
CHEEK_THICKNESS, CHEEK_REACH = 5.0, 45.0  # thickness and length of the flange's cheeks, mm
FOOT_GAP = 10.0  # between a foot and what hangs below the joint, mm
FOOT_PLATE = 8.0  # thickness of a foot's plate, mm


@dataclass(frozen=True)
class Seat:
    """Plate on whose face an eye lies, with two holes."""

    near: Array  # hole nearer to the strut, (3,)
    far: Array  # the other hole, (3,)
    normal: Array  # of the face, outwards, of length 1, (3,)
    edge: float  # of the plate beyond the near hole
    thickness: float  # of the plate
    screw: Thread  # size of the screws
    tie: bool = False  # whether a tie passes through a third hole in the middle
    tapped: bool = False  # whether the plate has threads; else nuts lie behind it

    @property
    def direction(self) -> Array:
        """Direction from the far hole to the near one, of length 1, (3,)."""
        step = self.near - self.far
        unit: Array = step / np.linalg.norm(step)
        return unit


def strut_tube(sizes: JointSizes, length: float) -> tuple[float, float]:
    """Return outer diameter and wall of the struts of a joint's link, mm, by bending and slenderness.

    Args:
        sizes: sizes of the joint that turns the link.
        length: of the struts, mm.
    """
    allowed = MATERIALS["aluminium-tube"].yield_stress / STRUT_SAFETY
    for outer in TUBE_OUTER_DIAMETERS:
        inner = outer - 2 * STRUT_WALL
        if inner <= 0:
            continue
        modulus = pi / 32 * (outer**4 - inner**4) / outer
        if sizes.torque / 2 / modulus <= allowed and outer * MM >= length / MAX_SLENDERNESS:
            tube = next_tube(outer, STRUT_WALL)
            return tube.outer * MM, tube.wall * MM
    tube = next_tube(TUBE_OUTER_DIAMETERS[-1], STRUT_WALL)
    return tube.outer * MM, tube.wall * MM


def arm_seats(sizes: JointSizes, *, outer: bool) -> list[Seat]:
    """Return the seats on the outer or inner faces of the upper and the lower arm plate."""
    first, _, last = link_holes(sizes)
    z = sizes.arm_z[1] if outer else sizes.arm_z[0]
    found = []
    for s in (1.0, -1.0):
        normal = np.array([0.0, 0.0, s if outer else -s])
        near, far = np.array([0.0, last, s * z]), np.array([0.0, first, s * z])
        found.append(Seat(near, far, normal, sizes.arm_width / 2, sizes.arm_plate, sizes.screw, tie=True))
    return found


def arm_tie(sizes: JointSizes, *, linked: bool) -> list[Component]:
    """Return the tie that holds the ends of the arm plates apart: a distance tube on a stud through their middle holes.

    Args:
        sizes: sizes of the joint.
        linked: whether eyes of struts lie on the arm plates.
    """
    outside = sizes.arm_z[1] + (2 * STRUT_WALL * MM + 0.04 if linked else 0.0)
    size, half = sizes.screw, sizes.arm_z[0] - 0.01
    y = link_holes(sizes)[1]
    outer = 2 * tie_radius(sizes)
    bore = size.clearance_hole * MM
    end = outside + (size.nut_height + size.pitch) * MM
    tube = sleeve(outer, bore, 2 * half)
    nuts = (place(0.0, y, outside), place(0.0, y, -outside, np.diag([1.0, -1.0, -1.0])))
    return [
        Component("distance tube of the arm", "output", tube, "aluminium-tube", "sawing", (place(0.0, y, -half),),
                  f"tube {outer:g} x {(outer - bore) / 2:.3g}", size=f"{2 * half:.1f} mm long"),
        stud("stud of the arm", "output", size, 2 * end, (place(0.0, y, -end),)),
        hexagon_nut("nut of the arm", "output", size, nuts),
    ]  # fmt: skip


def strut_components(sizes: JointSizes, pairs: list[tuple[Seat, Seat]]) -> list[Component]:
    """Return the struts between pairs of seats, with screws and nuts; arguments: sizes of the joint that turns them."""
    found: list[Component] = []
    for number, (start, end) in enumerate(pairs, 1):
        length = float(np.linalg.norm(end.near - start.near))
        outer, wall = strut_tube(sizes, length)
        shape, overall = _strut(sizes, (start, end), outer, wall)
        name = f"strut {number}" if len(pairs) > 1 else "strut"
        found.append(Component(name, "output", shape, "aluminium-tube", "milling", (place(),),
                               f"tube {outer:g} x {wall:g}", size=f"{overall:.0f} mm long, ends flattened",
                               tags=frozenset({"link"})))  # fmt: skip
        found += _bolts((start, end), 2 * wall)
    return found


def _strut(sizes: JointSizes, seats: tuple[Seat, Seat], outer: float, wall: float) -> tuple[Joined, float]:
    """Return a strut, and the length of tube that it is made from, mm."""
    towards = seats[1].near - seats[0].near
    thickness, least, edge = 2 * wall, 2.2 * sizes.screw.head_diameter * MM, _eye_edge(sizes)
    pieces: list[tuple[Prism | Turned, PartPlace]] = []
    ends, overall = [], 0.0
    for seat, heading in zip(seats, (towards, -towards), strict=True):
        pitch = float(np.linalg.norm(seat.near - seat.far))
        steep = heading @ seat.direction < LEAST_COSINE * float(np.linalg.norm(heading))
        width = max(min(1.4 * outer, 2 * eye_room(sizes) if seat.tie else inf), least)
        beyond = seat.edge + EYE_GAP + (STEEP_SHARE * outer if steep else 0.0)
        long = edge + pitch + beyond
        centre = seat.near + (beyond - long / 2) * seat.direction + (0.02 * seat.normal)
        y = np.cross(seat.normal, seat.direction)
        at = PartPlace(np.column_stack([seat.direction, y, seat.normal]), centre)
        holes = tuple(
            Hole((long / 2 - beyond - share * pitch, 0.0), seat.screw.clearance_hole * MM)
            for share in ((0.0, 0.5, 1.0) if seat.tie else (0.0, 1.0))
        )
        pieces.append((Prism(rectangle(long, width), thickness, holes), at))
        ends.append(seat.near + beyond * seat.direction + (0.02 + thickness / 2) * seat.normal - 0.5 * seat.direction)
        overall += long
    span = ends[1] - ends[0]
    length = float(np.linalg.norm(span))
    tube = sleeve(outer, outer - 2 * wall, length)
    pieces.append((tube, PartPlace(axes_towards(*span), ends[0])))
    return joined(*pieces), overall + length


def eye_room(sizes: JointSizes) -> float:
    """Return the greatest half of the width of an eye on the arm plates that meets no cylinder, mm.

    At the mechanical limit the corner of a wider one is lower than the edge of the cylinder's window.
    """
    along, s, c = link_holes(sizes)[0] - _eye_edge(sizes), sin(sizes.swing), cos(sizes.swing)
    slope = tan(pi - CrossSection(sizes).window_end + sizes.clearance / sizes.radius)
    fall = s + c * slope  # of a corner below the edge over the width
    return (sizes.axis + along * c - along * s * slope) / fall if fall > 0.0 else inf


def _eye_edge(sizes: JointSizes) -> float:
    """Return the length of an eye beyond its farther hole, mm."""
    return sizes.screw.head_diameter * MM / 2 + EYE_EDGE


def _bolts(seats: tuple[Seat, Seat], eye: float) -> list[Component]:
    """Return the screws of both eyes, heads on the eyes, with nuts behind the plates."""
    found = []
    for seat in seats:
        size = seat.screw
        heads, nuts = [], []
        for point in (seat.near, seat.far):
            heads.append(PartPlace(axes_towards(*seat.normal), point + (eye + 0.04) * seat.normal))
            nuts.append(PartPlace(axes_towards(*-seat.normal), point - seat.thickness * seat.normal))
        if seat.tapped:
            one = screw_for(eye / MM, size.name, size.diameter)
        else:
            one = screw_for((eye + seat.thickness) / MM, size.name, nut_engagement(size.name))
            found.append(hexagon_nut("nut of a strut", "output", size, tuple(nuts)))
        found.append(socket_screw("screw of a strut", "output", one, tuple(heads)))
    return [one.tagged("link") for one in found]


def flange(sizes: JointSizes, at: Array, along: Array) -> tuple[Component, list[Seat]]:
    """Return the tool's flange with its cheeks, and the seats on them for the struts.

    Args:
        sizes: sizes of the last joint.
        at: middle of the flange's face, in the link's frame, mm, (3,).
        along: direction in which the tool looks, of length 1, (3,).
    """
    z = np.array([0.0, 0.0, 1.0])
    x = np.cross(z, along)
    x = x / np.linalg.norm(x)
    side = np.cross(along, x)
    pitch = 2.5 * sizes.screw.diameter * MM
    holes = tuple(
        Hole((FLANGE_CIRCLE / 2 * float(np.cos(a)), FLANGE_CIRCLE / 2 * float(np.sin(a))), FLANGE_SCREW, "M6")
        for a in (pi / 4, 3 * pi / 4, 5 * pi / 4, 7 * pi / 4)
    )
    plate = Prism(circle(0.0, 0.0, FLANGE_DIAMETER / 2), FLANGE_THICKNESS, holes)
    width = 2.2 * sizes.screw.head_diameter * MM
    back = PartPlace(np.column_stack([x, side, along]), at - FLANGE_THICKNESS * along)
    pieces: list[tuple[Prism | Turned, PartPlace]] = [(plate, back)]
    seats = []
    half = 0.3 * FLANGE_DIAMETER
    reach = max(CHEEK_REACH, 3.2 * pitch)
    for s in (1.0, -1.0):
        near_distance = reach - 1.2 * sizes.screw.diameter * MM
        cheek = Prism(rectangle(reach, width), CHEEK_THICKNESS, tuple(
            Hole((reach / 2 - near_distance + d, 0.0), sizes.screw.clearance_hole * MM)
            for d in (0.0, pitch)))  # fmt: skip
        # The cheek's own x points along the tool's direction; its outer face looks sideways.
        centre = at - (FLANGE_THICKNESS - 0.5 + reach / 2) * along + s * (half - CHEEK_THICKNESS) * side
        axes = np.column_stack([along, np.cross(s * side, along), s * side])
        pieces.append((cheek, PartPlace(axes, centre)))
        face = centre + s * CHEEK_THICKNESS * side
        near = face + (reach / 2 - near_distance) * along
        seats.append(
            Seat(near, near + pitch * along, s * side, 1.2 * sizes.screw.diameter * MM, CHEEK_THICKNESS, sizes.screw)
        )
    component = Component("tool flange", "output", joined(*pieces), "aluminium", "milling", (place(),),
                          "ISO 9409-1-50-4-M6", tags=frozenset({"link"}))  # fmt: skip
    return component, seats


def foot_components(sizes: JointSizes, places: list[tuple[float, float]], low: float) -> list[Component]:
    """Return the foot below a joint, in the joint's frame: plate, studs, distance tubes, nuts.

    Args:
        sizes: sizes of the joint.
        places: of the studs, mm.
        low: lowest point of the joint along its axis, mm.
    """
    size = sizes.screw
    top, bottom = -sizes.top, low - FOOT_GAP
    length = top - bottom
    plate = Prism(circle(0.0, 0.0, sizes.rim), FOOT_PLATE, tuple(Hole(p, size.clearance_hole * MM) for p in places))
    tube = sleeve(2.2 * size.diameter * MM, size.clearance_hole * MM, length - 0.02)
    end = bottom - FOOT_PLATE - (size.nut_height + size.pitch) * MM
    return [
        Component("foot plate", "body", plate, "aluminium", "laser cutting", (place(z=bottom - FOOT_PLATE),),
                  f"plate {FOOT_PLATE:g}", tags=frozenset({"foot"})),
        Component("distance tube of the foot", "body", tube, "aluminium-tube", "sawing",
                  tuple(place(x, y, bottom + 0.01) for x, y in places),
                  f"tube {2.2 * size.diameter * MM:g} x {(2.2 * size.diameter - size.clearance_hole) / 2 * MM:.3g}",
                  size=f"{length:.1f} mm long", tags=frozenset({"foot"})),
        stud("stud of the foot", "body", size, -sizes.half_length - end,
             tuple(place(x, y, end) for x, y in places)).tagged("foot"),
        hexagon_nut("nut of the foot", "body", size, tuple(
            PartPlace(axes_towards(0, 0, -1), np.array([x, y, bottom - FOOT_PLATE]))
            for x, y in places)).tagged("foot"),
    ]  # fmt: skip
