"""The brake: a disc on the shaft below the joint, pads on the lower end plate and on a beam that springs press."""

from __future__ import annotations

from contextlib import suppress
from math import hypot, pi, sqrt
from typing import TYPE_CHECKING

from layflat.errors import DesignError
from layflat.solids.component import Component, axes_towards
from layflat.solids.hardware import hexagon_nut, plain_washer, rod, sleeve, stepped, stud
from layflat.solids.loops import HullCircle, hull
from layflat.solids.places import frame_places
from layflat.solids.shapes import UPSIDE_DOWN, Drilled, Hole, Prism, Turned, place, turn_about_z
from layflat.solids.sizes import MM, PAD_THICKNESS
from layflat.solids.standard.springs import CompressionSpring, spring_for
from layflat.solids.standard.stock import next_thickness
from layflat.solids.standard.threads import THREADS

if TYPE_CHECKING:
    from layflat.solids.sizes import JointSizes

DISC_SHARES = (0.7, 0.65, 0.6, 0.55, 0.5, 0.45, 0.4)
"""Radii of the disc over the cylinder's, in the order of preference."""
PAD_SHARE = 0.25  # radius of a pad over that of the disc
PAD_EDGE = 1.0  # between a pad and the edge of the disc, mm
STUD_GAP = 1.0  # between a stud's nut and the disc, mm
HUB_GAP = 0.5  # least distance of what presses, and of the pads, from the shaft and the disc's hub, mm
LEAST_BEAM = 3.0  # least thickness of the beam, mm
BEAM_STRESS = 120e6  # allowed in the beam, Pa: half of the yield stress of EN AW-6082 T6
SPRING_SPACES = tuple(size * 1e-3 for size in (8, 10, 12, 15, 20, 25, 30, 40))
"""Lengths that a loaded spring may take, m, tried in this order."""
SPRING_BEYOND = 8e-3  # outer diameter of a spring over that of a washer, m
SET_SCREW = THREADS["M4"]  # in the disc's hub
CYLINDER_HEIGHT = 20.0  # of a short-stroke cylinder, mm
CYLINDER_WALL = 4.0  # around its bore, mm
CYLINDER_BORES = (12.0, 16.0, 20.0, 25.0, 32.0, 40.0, 50.0, 63.0)
"""Bores of short-stroke cylinders, mm (ISO 21287)."""


def disc_radius(sizes: JointSizes) -> float:
    """Return the radius of the disc, mm: as given, or the largest whose studs have room on the end plate."""
    given = sizes.build.disc_diameter
    radii = [share * sizes.radius for share in DISC_SHARES] if given is None else [given / 2 * MM]
    return next((one for one in radii if _stud_room(sizes, one) >= 0.0), radii[0])


def pad_distance(sizes: JointSizes) -> float:
    """Return the distance of the pads from the output's axis, mm."""
    return disc_radius(sizes) * (1 - PAD_SHARE) - PAD_EDGE


def pad_force(sizes: JointSizes) -> float:
    """Return the force on the pads at which the brake slips as described, N: T/(2 mu r)."""
    return sizes.joint.brake.torque / (2 * sizes.build.pad_friction * pad_distance(sizes) / MM)


def stud_places(sizes: JointSizes) -> list[tuple[float, float]]:
    """Return the places of the two studs that carry the beam, beside the disc, mm."""
    x, y = _stud_place(sizes, disc_radius(sizes))
    return [(-x, y), (x, y)]


def _stud_place(sizes: JointSizes, disc: float) -> tuple[float, float]:
    """Return the place of the stud on the side of +x for a disc of a radius, mm."""
    distance = disc * (1 - PAD_SHARE) - PAD_EDGE
    chord = sqrt(disc**2 - distance**2)
    return chord + sizes.screw.washer_diameter * MM / 2 + STUD_GAP, sizes.axis - distance


def _check_studs(sizes: JointSizes) -> None:
    """Raise DesignError unless the studs have room on the end plate."""
    radius = disc_radius(sizes)
    if _stud_room(sizes, radius) < 0.0:
        what = f"the studs of a brake with a disc of {2 * radius:.4g} mm have no room on the end plate"
        raise DesignError(what, where=sizes.label, right="a smaller disc may have")


def _stud_room(sizes: JointSizes, disc: float) -> float:
    """Return the room of the studs of a disc of a radius, mm: to the end plate's edge, and to its screws' washers."""
    (x, y), screw = _stud_place(sizes, disc), sizes.screw
    beside = min(hypot(x - at, y - along) for at, along in frame_places(sizes))
    washer = (screw.washer_diameter + screw.diameter) / 2 * MM
    return min(sizes.rim - hypot(x, y) - screw.diameter * MM, beside - washer)


def brake_components(sizes: JointSizes, angle: float) -> list[Component]:
    """Return the components of the brake with the output at an angle from mid-stroke, rad; none without a torque.

    Raises:
        DesignError: the studs do not fit on the end plate, or no spring or cylinder is strong enough.
    """
    if sizes.joint.brake.torque <= 0:
        return []
    _check_studs(sizes)
    pads, face = pad_distance(sizes), sizes.top
    radius, turned = PAD_SHARE * disc_radius(sizes), turn_about_z(angle).then(place(0.0, sizes.axis))
    middle = sizes.axis - pads
    pad = rod(2 * radius, PAD_THICKNESS - 0.02)
    disc_low = -(face + PAD_THICKNESS + sizes.disc)
    hub = min(sizes.shaft, pads - radius - HUB_GAP)  # its radius
    outline = stepped((hub, -sizes.disc_hub, 0.0), (disc_radius(sizes), 0.0, sizes.disc), bore=sizes.shaft / 2)
    set_hole = Drilled((hub, 0.0, -sizes.disc_hub / 2), (-1.0, 0.0, 0.0), SET_SCREW.tapping_hole * MM,
                       hub, SET_SCREW.name)  # fmt: skip
    set_screw = rod(SET_SCREW.tapping_hole * MM - 0.02, hub - sizes.shaft / 2 - 0.2)
    at_set = place(sizes.shaft / 2 + 0.1, 0.0, -sizes.disc_hub / 2, axes_towards(1, 0, 0))
    return [
        Component("brake disc", "output", Turned(outline, (set_hole,)), "aluminium", "turning",
                  (place(z=disc_low).then(turned),), f"round bar {2 * disc_radius(sizes):.4g}",
                  tags=frozenset({"disc"})),
        Component("set screw of the disc", "output", set_screw, "screw-steel", "bought",
                  (at_set.then(place(z=disc_low)).then(turned),),
                  f"ISO 4026 {SET_SCREW.name} x {hub - sizes.shaft / 2:.0f} - A2-21H"),
        Component("brake pad", "body", pad, "PA6", "turning",
                  (place(0.0, middle, -face - 0.01, UPSIDE_DOWN),
                   place(0.0, middle, disc_low - 0.01, UPSIDE_DOWN)), f"round bar {2 * radius:.3g}"),
        *_beam(sizes, disc_low - PAD_THICKNESS),
    ]  # fmt: skip


def _beam(sizes: JointSizes, z: float) -> list[Component]:
    """Return the beam below z (mm) with its studs, and what presses it: springs, or a cylinder of a calliper."""
    force, studs = pad_force(sizes), stud_places(sizes)
    radius = PAD_SHARE * disc_radius(sizes)
    span = 2 * studs[1][0]
    least = LEAST_BEAM if sizes.joint.brake.calliper is None else sizes.disc_hub - PAD_THICKNESS + HUB_GAP
    bends = sqrt(6 * force * span / 4 / MM / (BEAM_STRESS * 2 * radius / MM))
    thickness = next_thickness(max(bends, least / MM)) * MM
    screw = sizes.screw
    middle = studs[0][1]
    ends = screw.washer_diameter * MM / 2
    loop = hull([HullCircle(0.0, 0.0, radius), *(HullCircle(x, 0.0, ends) for x, _ in studs)])
    beam = Prism(loop, thickness, tuple(Hole((x, 0.0), screw.clearance_hole * MM) for x, _ in studs))
    low = z - thickness
    found = [
        Component("brake beam", "body", beam, "aluminium", "laser cutting", (place(0.0, middle, low),),
                  f"plate {thickness:g}", tags=frozenset({"calliper"})),
    ]  # fmt: skip
    if sizes.joint.brake.calliper is None:
        return found + _springs(sizes, force / 2, low)
    return found + _cylinder(sizes, force, low, beam)


def _studs(sizes: JointSizes, low: float) -> list[Component]:
    """Return studs from the lower end plate to below z (mm), each with a nut there."""
    screw, inner = sizes.screw, -sizes.half_length - 1.0
    end = low - (screw.nut_height + screw.pitch) * MM
    places = tuple(place(x, y, end) for x, y in stud_places(sizes))
    nuts = tuple(place(x, y, low, UPSIDE_DOWN) for x, y in stud_places(sizes))
    return [
        stud("stud of the brake", "body", screw, inner - end, places),
        hexagon_nut("nut of the brake", "body", screw, nuts),
    ]


def _springs(sizes: JointSizes, force: float, low: float) -> list[Component]:
    """Return the springs on both studs below the beam, with washers and nuts; each presses with a force, N."""
    screw, one = sizes.screw, _spring(sizes, force)
    inner = one.outer - 2 * one.wire
    length = max(one.free_length - force / one.rate, one.shortest) * MM
    shape = sleeve(one.outer * MM, inner * MM, length)
    springs = tuple(place(x, y, low - length) for x, y in stud_places(sizes))
    washers = tuple(place(x, y, low - length, UPSIDE_DOWN) for x, y in stud_places(sizes))
    return [
        Component("brake spring", "body", shape, "spring-steel", "bought", springs, one.designation, one.mass,
                  size=f"tightened to {length:.1f} mm: {force:.0f} N"),
        plain_washer("washer of a brake spring", "body", screw, washers),
        *_studs(sizes, low - length - screw.washer_thickness * MM),
    ]  # fmt: skip


def _spring(sizes: JointSizes, force: float) -> CompressionSpring:
    """Return the shortest spring around a stud that presses with a force, N."""
    screw = sizes.screw
    for space in SPRING_SPACES:
        with suppress(DesignError):
            one = spring_for(force, space, screw.washer_diameter + SPRING_BEYOND)
            if one.outer - 2 * one.wire > screw.diameter:
                return one
    what = f"no spring for {force:.0f} N goes around a stud {screw.name}"
    right = "a larger build.disc_diameter needs less force; or give another build.screw"
    raise DesignError(what, where=sizes.label, right=right)


def _cylinder(sizes: JointSizes, force: float, low: float, beam: Prism) -> list[Component]:
    """Return the short-stroke cylinder that presses the beam with a force (N), and the bridge that it stands on."""
    pressure = sizes.design.pressure
    need = 2 * sqrt(force / (pi * pressure)) * MM
    bore = next((size for size in CYLINDER_BORES if size >= need), None)
    if bore is None:
        what = f"no short-stroke cylinder presses with {force:.0f} N at {pressure / 1e5:.3g} bar"
        raise DesignError(what, where=sizes.label, right="a larger build.disc_diameter needs less force")
    outer, middle = bore + 2 * CYLINDER_WALL, stud_places(sizes)[0][1]
    body = rod(outer, CYLINDER_HEIGHT)
    bridge = low - CYLINDER_HEIGHT - beam.height
    return [
        Component("brake cylinder", "body", body, "aluminium", "bought",
                  (place(0.0, middle, low - CYLINDER_HEIGHT),), f"short-stroke cylinder ISO 21287 - {bore:g} x 5"),
        Component("bridge of the brake", "body", beam, "aluminium", "laser cutting", (place(0.0, middle, bridge),),
                  f"plate {beam.height:g}"),
        *_studs(sizes, bridge),
    ]  # fmt: skip
