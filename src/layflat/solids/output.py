"""The output of a joint: cams with the straps' clamps, arm plates, and the rods and shaft through them."""

from __future__ import annotations

from math import cos, pi, sin, sqrt
from typing import TYPE_CHECKING

from layflat.design.straplines import direction_vector
from layflat.errors import DesignError
from layflat.lazy import numpy as np
from layflat.solids.cams import CLAMP_SCREW, cam_loop, cam_part, flat, winding
from layflat.solids.component import Component, axes_towards
from layflat.solids.hardware import hexagon_nut, rod, sleeve, socket_screw, stud
from layflat.solids.loops import HullCircle, hull, rectangle
from layflat.solids.places import end_plate_loop
from layflat.solids.section import FILM_THICKNESS, STRIP_THICKNESS, CrossSection
from layflat.solids.sensor import COUPLED_LENGTH
from layflat.solids.shapes import UPSIDE_DOWN, Hole, PartPlace, Prism, place, turn_about_z
from layflat.solids.sizes import MM, PAD_THICKNESS, SPACER_THICKNESS, kept_by_sizes
from layflat.solids.standard.screws import nut, screw_for

if TYPE_CHECKING:
    from layflat.arrays import Array
    from layflat.solids.sizes import JointSizes

SWING_POINTS = 81  # angles of the arm at which it is looked for its distance from the end plates
TRACK_COUNT = 15  # angles of the arm at which straps are looked for on the way of the link's holes
HOLE_STEP = 0.5  # by which the holes for a link are moved out of the way of straps, mm
TIE_SHARE = 2.2  # diameter of the distance tube between the arm plates over that of its screw
LINK_PITCH = 2.5  # between the holes for a link over the diameter of the screws
RING_THICKNESS = 1.0  # of a retaining ring, mm
RING_GAP = 0.5  # between a retaining ring and the cylinder, mm
RING_SHARE = 1.45  # outer diameter of a retaining ring over the shaft's
SCREW_PITCH = 25.0  # between screws of a strap's clamp, mm
MIRROR_AXES = np.diag([-1.0, 1.0, -1.0])  # the cam of hose B, laid upside down, is the mirror image of that of hose A


def clamp_places(width: float) -> tuple[float, ...]:
    """Return where the screws of a strap's clamp are along its width, mm, from its middle."""
    count = max(1, round(width / SCREW_PITCH))
    return tuple(float(width * ((k + 0.5) / count - 0.5)) for k in range(count))


@kept_by_sizes
def link_holes(sizes: JointSizes) -> tuple[float, float, float]:
    """Return the distances of the holes for a link from the output's axis, mm: screw, tie, screw.

    The first screw's head passes beside the end plates at all angles up to the mechanical limit; straps, cams or
    rollers pass beside the nuts of the screws and the tube around the tie.
    """
    first = _plate_reach(sizes, sizes.screw.head_diameter * MM / 2 + sizes.clearance)
    step = LINK_PITCH * sizes.screw.diameter * MM
    nut_corner = sizes.screw.nut_flats * MM / sqrt(3)
    rooms = (nut_corner, tie_radius(sizes) + sizes.clearance / 2, nut_corner)
    tracks = _strap_tracks(sizes)
    while any(_track_distance(tracks, first + k * step) < room for k, room in enumerate(rooms)):
        first += HOLE_STEP
    return first, first + step, first + 2 * step


def tie_radius(sizes: JointSizes) -> float:
    """Return the radius of the distance tube between the ends of the arm plates, mm."""
    return TIE_SHARE * sizes.screw.diameter * MM / 2


def _strap_tracks(sizes: JointSizes) -> list[Array]:
    """Return lines along cam or roller, and along the strap at angles over the stroke, mm, (n, 2) each.

    They lie in the frame of the arm: the output's axis is at 0, and y along the arm. Straps count with their thickness.
    """
    section, loop = CrossSection(sizes), cam_loop(sizes).points()
    found = [_turned(np.vstack((loop, loop[:1])), sizes.stroke / 2)]
    for angle in np.linspace(-sizes.swing, sizes.swing, TRACK_COUNT):
        path = section.strap_path(sizes.stroke / 2 + float(angle)) - [0.0, sizes.axis]
        steps = np.diff(path, axis=0, append=2 * path[-1:] - path[-2:-1])
        outward = np.stack((-steps[:, 1], steps[:, 0]), axis=-1) / np.hypot(*steps.T)[:, None]
        outer = path + (sizes.strap_thickness + FILM_THICKNESS) * outward
        found += [_turned(path, -float(angle)), _turned(outer, -float(angle))]
    return found


def _turned(points: Array, angle: float) -> Array:
    """Return points (n, 2) rotated anticlockwise by an angle, rad."""
    c, s = cos(angle), sin(angle)
    turned: Array = points @ np.array([[c, s], [-s, c]])
    return turned


def _track_distance(tracks: list[Array], along: float) -> float:
    """Return the least distance of lines from a point of the arm, mm; `along` is its distance from the axis."""
    point, least = np.array([0.0, along]), np.inf
    for track in tracks:
        start, side = track[:-1], np.diff(track, axis=0)
        share = np.sum((point - start) * side, axis=1) / np.maximum(np.sum(side * side, axis=1), 1e-12)
        apart = start + np.clip(share, 0.0, 1.0)[:, None] * side - point
        least = min(least, float(np.hypot(*apart.T).min()))
    return float(least)


def _plate_reach(sizes: JointSizes, room: float) -> float:
    """Return from which distance from the axis on all points of the arm are a room (mm) beside the end plates."""
    corners = end_plate_loop(sizes).points() - [0.0, sizes.axis]
    sides = np.roll(corners, -1, axis=0) - corners
    normals = np.stack((sides[:, 1], -sides[:, 0]), axis=-1) / np.hypot(*sides.T)[:, None]
    ways = direction_vector(pi / 2 + np.linspace(-sizes.swing, sizes.swing, SWING_POINTS))
    # A plate is convex: a point is outside as soon as it is beyond one of its sides.
    along = ways @ normals.T
    beyond = np.where(along > 1e-6, (room + np.sum(normals * corners, axis=1)) / np.maximum(along, 1e-6), np.inf)
    return float(beyond.min(axis=1).max())


def arm_reach(sizes: JointSizes) -> float:
    """Return the distance of the last hole of an arm plate from the output's axis, mm."""
    return link_holes(sizes)[-1]


def rod_lines(sizes: JointSizes) -> list[float]:
    """Return y of the rods about the output's axis, with the arm along y, mm."""
    return [side * sizes.rod_distance(sizes.rod) for side in sizes.rod_sides]


def arm_plate(sizes: JointSizes) -> Prism:
    """Return an arm plate about the output's axis, with the arm along y: bore, holes of rods and of the link."""
    distance, half = sizes.rod_distance(sizes.rod), sizes.arm_width / 2
    lug = HullCircle(0.0, -distance, sizes.lug_radius(sizes.rod))
    reach = arm_reach(sizes)
    hub = HullCircle(0.0, 0.0, half)
    inside = distance + lug.radius <= half
    loop = hull([hub, HullCircle(0.0, reach, half), *(() if inside else (lug,))])
    rods = tuple(Hole((0.0, y), sizes.rod.clearance_hole * MM) for y in rod_lines(sizes))
    link = tuple(Hole((0.0, y), sizes.screw.clearance_hole * MM) for y in link_holes(sizes))
    return Prism(loop, sizes.arm_plate, (Hole((0.0, 0.0), sizes.shaft), *rods, *link))


def output_components(sizes: JointSizes, angle: float) -> list[Component]:
    """Return the components that turn with the output, at an angle from mid-stroke, rad."""
    out = turn_about_z(angle).then(place(0.0, sizes.axis))
    return [one.moved(out) for one in _at_rest(sizes)]


@kept_by_sizes
def _at_rest(sizes: JointSizes) -> list[Component]:
    """Return the components in the output's frame at mid-stroke."""
    return [*_cams(sizes), *_arm(sizes), *_shaft(sizes)]


def _cams(sizes: JointSizes) -> list[Component]:
    """Return the cams with the clamps of the straps, in the output's frame at mid-stroke."""
    turned = turn_about_z(sizes.stroke / 2)
    width = sizes.strap_width
    kind = sizes.joint.output.kind
    found = _cam(sizes, f"{kind} of hose A", width, (place(z=-width / 2).then(turned),))
    if sizes.double:
        low, high = sizes.cam_b
        mirrored = PartPlace(MIRROR_AXES, np.zeros(3))
        places = tuple(place(z=z).then(turned).then(mirrored) for z in (low, -high))
        found += _cam(sizes, f"{kind} of hose B", width / 2, places)
    return found


def _cam(sizes: JointSizes, name: str, width: float, places: tuple[PartPlace, ...]) -> list[Component]:
    """Return cams of a width (mm) at places, each with strip and screws of its strap's clamp."""
    at = clamp_places(width)
    shape = cam_part(sizes, width, tuple(z + width / 2 for z in at))
    section = CrossSection(sizes)
    holes = CLAMP_SCREW.clearance_hole * MM
    (x, y), normal = flat(sizes)
    high = sizes.strap_thickness + STRIP_THICKNESS + 0.05
    strip, frame = _strip(section, width, holes, at, (x, y), normal)
    screw = screw_for((STRIP_THICKNESS + sizes.strap_thickness) / MM, CLAMP_SCREW.name)
    n = np.array([cos(normal), sin(normal), 0.0])
    heads = tuple(
        PartPlace(axes_towards(*n), np.array([x, y, z + width / 2]) + high * n).then(one) for one in places for z in at
    )
    return [
        Component(name, "output", shape, "aluminium", "milling", places, f"plate {width:g}", tags=frozenset({"cam"})),
        Component(f"strap clamp on the {name}", "output", strip, "stainless-steel", "laser cutting",
                  tuple(frame.then(one) for one in places), f"sheet {STRIP_THICKNESS:g}"),
        socket_screw(f"screw of the strap clamp on the {name}", "output", screw, heads),
    ]  # fmt: skip


def _strip(
    section: CrossSection, width: float, hole: float, at: tuple[float, ...], middle: tuple[float, float], normal: float
) -> tuple[Prism, PartPlace]:
    """Return the strip of a strap's clamp, flat on its own xy-plane, and its place in the cam's frame."""
    ends = winding(section.sizes)[-2:]
    length = float(np.hypot(*(ends[1] - ends[0])))
    strip = Prism(rectangle(length, width), STRIP_THICKNESS, tuple(Hole((0.0, z), hole) for z in at))
    n = np.array([cos(normal), sin(normal), 0.0])
    z = np.array([0.0, 0.0, 1.0])
    axes = np.column_stack([np.cross(z, n), z, n])
    return strip, PartPlace(axes, np.array([*middle, width / 2]) + (section.sizes.strap_thickness + 0.04) * n)


def _arm(sizes: JointSizes) -> list[Component]:
    """Return arm plates, spacers and rods, in the output's frame at mid-stroke."""
    low, high = sizes.arm_z
    size, lines = sizes.rod, rod_lines(sizes)
    lug = sizes.lug_radius(size)
    around = [HullCircle(0.0, 0.0, sizes.shaft / 2 + 1.5), *(HullCircle(0.0, y, lug) for y in lines)]
    spacer = Prism(hull(around), SPACER_THICKNESS - 0.02, (
        Hole((0.0, 0.0), sizes.shaft), *(Hole((0.0, y), size.clearance_hole * MM) for y in lines)))  # fmt: skip
    between = [sizes.strap_width / 2, sizes.cam_b[1]] if sizes.double else [sizes.strap_width / 2]
    spacers = tuple(place(z=s * z + (0.01 if s > 0 else 0.01 - SPACER_THICKNESS)) for z in between for s in (1.0, -1.0))
    overhang = size.pitch * MM
    length = 2 * (high + nut(size.name, thin=True).height * MM + overhang)
    rods = tuple(place(0.0, y, -length / 2) for y in lines)
    nuts = tuple(p for y in lines for p in (place(0.0, y, high), place(0.0, y, -high, UPSIDE_DOWN)))
    plates = (place(z=low), place(z=-low, axes=np.diag([-1.0, 1.0, -1.0])))
    return [
        Component("spacer", "output", spacer, "aluminium-sheet", "laser cutting", spacers,
                  f"sheet {SPACER_THICKNESS:g}"),
        Component("arm plate", "output", arm_plate(sizes), "aluminium", "laser cutting", plates,
                  f"plate {sizes.arm_plate:g}", tags=frozenset({"arm plate"})),
        stud("rod of the output", "output", size, length, rods),
        hexagon_nut("nut of the output", "output", size, nuts, thin=True),
    ]  # fmt: skip


def _ring_diameter(sizes: JointSizes) -> float:
    """Return the outer diameter of a retaining ring, mm; raise DesignError where it would meet the cylinder."""
    diameter = RING_SHARE * sizes.shaft + 2.0
    room = sizes.inner_radius - diameter / 2
    if sizes.axis > room:
        what = f"the retaining ring of a shaft of {sizes.shaft:g} mm meets the cylinder"
        raise DesignError(what, where=f"{sizes.design.label}.output", right="a smaller shaft_offset leaves room")
    return diameter


def _shaft(sizes: JointSizes) -> list[Component]:
    """Return the shaft, from the brake's disc to the coupling of the angle sensor, and its retaining rings."""
    top = sizes.top + COUPLED_LENGTH
    low = -(sizes.top + PAD_THICKNESS + sizes.disc + sizes.disc_hub)
    flange = sizes.half_length - sizes.bush.flange_thickness * MM
    ring = sleeve(_ring_diameter(sizes), sizes.shaft + 0.02, RING_THICKNESS)
    places = (place(z=flange - RING_THICKNESS - 0.05), place(z=-flange + 0.05))
    return [
        Component("shaft", "output", rod(sizes.shaft, top - low), "shaft-steel", "turning", (place(z=low),),
                  f"ground bar {sizes.shaft:g} h6", size=f"{top - low:.1f} mm long", tags=frozenset({"shaft"})),
        Component("retaining ring", "output", ring, "spring-steel", "bought", places,
                  f"DIN 471 - {sizes.shaft:g} x {RING_THICKNESS:g}"),
    ]  # fmt: skip
