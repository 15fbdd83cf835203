"""The frame of a joint: cylinder, end plates with bushes, bars that clamp the hoses, tie bars, bump stops."""

from __future__ import annotations

from math import sqrt
from typing import TYPE_CHECKING

from layflat.lazy import numpy as np
from layflat.solids.brake import stud_places
from layflat.solids.component import Component, axes_towards
from layflat.solids.hardware import hexagon_nut, plain_washer, rod, sleeve, socket_screw, stepped, stud
from layflat.solids.inlets import inlet_holes
from layflat.solids.loops import circle, rectangle
from layflat.solids.places import (
    END_SHARE,
    SCREW_SHARE,
    bar_place,
    clamp_heights,
    clamp_line,
    end_plate_loop,
    foot_places,
    frame_places,
    stop_places,
    stop_radius,
    tie_places,
    tie_radius,
    tongue_holes,
)
from layflat.solids.section import WEBBING_THICKNESS, window_loop
from layflat.solids.sensor import STANDOFF_SCREW, standoff_places
from layflat.solids.shapes import ALONG_X, UPSIDE_DOWN, Drilled, Hole, Prism, Turned, place
from layflat.solids.sizes import MM
from layflat.solids.standard.screws import nut_engagement, screw_for

if TYPE_CHECKING:
    from layflat.solids.loops import Loop
    from layflat.solids.section import CrossSection
    from layflat.solids.shapes import PartPlace
    from layflat.solids.sizes import JointSizes

FLANGE_GAP = 0.2  # between a bush's flange and a pocket for it, mm
ACCESS_ROOM = 1e-3  # of a hole for a key around the head of its screw, m


def frame_components(sizes: JointSizes, section: CrossSection) -> list[Component]:
    """Return the components of the frame; arguments: sizes of the joint, and its cross-section."""
    return [
        _cylinder(sizes, section),
        *_end_plates(sizes),
        *_bushes(sizes),
        *_clamp(sizes),
        *_ties(sizes),
        *_stops(sizes),
    ]


def _cylinder(sizes: JointSizes, section: CrossSection) -> Component:
    R, length = sizes.radius, 2 * sizes.half_length
    slot = rectangle(2 * (WEBBING_THICKNESS + sizes.hose_thickness) + 0.2, sizes.radius, (0.0, -R))
    middle = sizes.half_length
    shape = Prism(
        circle(0.0, 0.0, R),
        length,
        drilled=(*inlet_holes(sizes), *_access_holes(sizes)),
        openings=(circle(0.0, 0.0, sizes.inner_radius),),
        pockets=(
            (window_loop(sizes, section), middle - sizes.window, middle + sizes.window),
            (slot, middle - sizes.hose_width / 2 - 1.0, middle + sizes.hose_width / 2 + 1.0),
            *_bush_pockets(sizes),
        ),
    )
    stock = f"tube {2 * R:.4g} x {R - sizes.inner_radius:.3g}"
    return Component("cylinder", "body", shape, "aluminium-tube", "milling", (place(z=-middle),), stock,
                     size=f"{length:.1f} mm long")  # fmt: skip


def _bush_pockets(sizes: JointSizes) -> tuple[tuple[Loop, float, float], ...]:
    """Return the pockets in both ends of the cylinder for the flanges of bushes that reach over its wall."""
    radius, length = sizes.bush.flange * MM / 2 + FLANGE_GAP, 2 * sizes.half_length
    depth = sizes.bush.flange_thickness * MM + FLANGE_GAP
    if sizes.axis + radius <= sizes.inner_radius:
        return ()
    loop = circle(0.0, sizes.axis, radius)
    return (loop, 0.0, depth), (loop, length - depth, length)


def _access_holes(sizes: JointSizes) -> tuple[Drilled, ...]:
    """Return the holes in the cylinder, in its own frame, through which a key reaches the screws of the clamp."""
    y, x = clamp_line(sizes), sizes.radius + 1.0
    wide = (sizes.screw.head_diameter + ACCESS_ROOM) * MM
    through = x - 0.7 * sqrt(sizes.inner_radius**2 - y * y)
    return tuple(
        Drilled((s * x, y, sizes.half_length + z), (-s, 0.0, 0.0), wide, through)
        for z in clamp_heights(sizes)
        for s in (1.0, -1.0)
    )


def end_plate(sizes: JointSizes, *, upper: bool) -> Prism:
    """Return an end plate, from its inner face on along z.

    Args:
        sizes: sizes of the joint.
        upper: whether it is the one that carries the angle sensor; the other one carries the brake.
    """
    screw, bore = sizes.screw, sizes.bush.outer * MM
    frame = frame_places(sizes)
    stops = stop_places(sizes)
    mirrored = 1.0 if upper else -1.0  # the lower plate is laid upside down
    holes = [Hole((0.0, sizes.axis), bore), *(Hole(p, screw.clearance_hole * MM) for p in frame)]
    holes += [Hole(p, screw.tapping_hole * MM, screw.name) for p in stops]
    if upper:
        holes += [Hole(p, STANDOFF_SCREW.clearance_hole * MM) for p in standoff_places(sizes)]
    else:
        holes += [Hole(p, screw.tapping_hole * MM, screw.name) for p in stud_places(sizes)]
    holes += [Hole(p, screw.tapping_hole * MM, screw.name) for p in tongue_holes(sizes)]
    if not upper:
        holes += [Hole(p, screw.tapping_hole * MM, screw.name) for p in foot_places(sizes)]
    loop = end_plate_loop(sizes)
    if mirrored < 0:
        loop = loop.mirrored()
        holes = [Hole((-hole.centre[0], hole.centre[1]), hole.diameter, hole.thread) for hole in holes]
    return Prism(loop, sizes.end_plate, tuple(holes))


def _end_plates(sizes: JointSizes) -> list[Component]:
    stock, low = f"plate {sizes.end_plate:g}", sizes.half_length
    turned = np.diag([-1.0, 1.0, -1.0])
    return [
        Component("lower end plate", "body", end_plate(sizes, upper=False), "aluminium", "laser cutting",
                  (place(z=-low, axes=turned),), stock, tags=frozenset({"end plate"})),
        Component("upper end plate", "body", end_plate(sizes, upper=True), "aluminium", "laser cutting",
                  (place(z=low),), stock, tags=frozenset({"end plate"})),
    ]  # fmt: skip


def _bushes(sizes: JointSizes) -> list[Component]:
    one, length = sizes.bush, sizes.end_plate
    flange = one.flange_thickness * MM
    outline = stepped((one.flange * MM / 2, -flange, 0.0), (one.outer * MM / 2 - 0.01, 0.0, length),
                      bore=one.bore * MM / 2 + 0.01)  # fmt: skip
    low = sizes.half_length
    places = (place(0.0, sizes.axis, low), place(0.0, sizes.axis, -low, UPSIDE_DOWN))
    name = one.designation(length / MM)
    return [Component("bush", "body", Turned(outline), "POM", "bought", places, name, one.mass(length / MM))]


def _clamp(sizes: JointSizes) -> list[Component]:
    """Return the bars that clamp the hoses back to back, with their screws and nuts."""
    x, y, depth = bar_place(sizes)
    screw, length, bar = sizes.screw, 2 * sizes.half_length, sizes.clamp_bar
    across = clamp_heights(sizes)
    hole = screw.clearance_hole * MM
    deep = 3 * screw.diameter * MM
    ends = tuple(
        Drilled((END_SHARE * depth, s * length / 2, bar / 2), (0.0, -s, 0.0), screw.tapping_hole * MM, deep, screw.name)
        for s in (1.0, -1.0)
    )  # fmt: skip
    holes = tuple(Hole((SCREW_SHARE * depth, z), hole) for z in across)
    shape = Prism(rectangle(depth, length), bar, holes, drilled=ends)
    places = (place(x - bar / 2, y, 0.0, ALONG_X), place(-x - bar / 2, y, 0.0, ALONG_X))
    washer = screw.washer_thickness * MM
    side = x + bar / 2
    grip = 2 * (side + washer)
    one = screw_for(grip / MM, screw.name, nut_engagement(screw.name))
    line = clamp_line(sizes)
    right = [place(side, line, z, axes_towards(1, 0, 0)) for z in across]
    left = [place(-side, line, z, axes_towards(-1, 0, 0)) for z in across]
    heads = tuple(place(side + washer, line, z, axes_towards(1, 0, 0)) for z in across)
    nuts = tuple(place(-side - washer, line, z, axes_towards(-1, 0, 0)) for z in across)
    return [
        Component("clamp bar", "body", shape, "aluminium", "milling", places, f"flat bar {depth:.1f} x {bar:g}",
                  size=f"{length:.1f} mm long", tags=frozenset({"clamp bar"})),
        plain_washer("washer of the clamp", "body", screw, (*right, *left)),
        socket_screw("screw of the clamp", "body", one, heads),
        hexagon_nut("nut of the clamp", "body", screw, nuts),
    ]  # fmt: skip


def _ties(sizes: JointSizes) -> list[Component]:
    """Return the tie bars, and the screws that hold the end plates on them and on the clamp bars."""
    screw, length = sizes.screw, 2 * sizes.half_length
    diameter = 2 * tie_radius(sizes)
    ends = tuple(
        Drilled((0.0, 0.0, z), (0.0, 0.0, d), screw.tapping_hole * MM, 3 * screw.diameter * MM, screw.name)
        for z, d in ((0.0, 1.0), (length, -1.0))
    )
    bar = Turned(rod(diameter, length).outline, ends)
    frame = frame_places(sizes)
    washer = screw.washer_thickness * MM
    one = screw_for((sizes.end_plate + washer) / MM, screw.name)
    return [
        Component("tie bar", "body", bar, "aluminium", "turning",
                  tuple(place(tx, ty, -length / 2) for tx, ty in tie_places(sizes)), f"round bar {diameter:g}",
                  size=f"{length:.1f} mm long"),
        plain_washer("washer of an end plate", "body", screw, _on_faces(frame, sizes.top)),
        socket_screw("screw of an end plate", "body", one, _on_faces(frame, sizes.top + washer)),
    ]  # fmt: skip


def _stops(sizes: JointSizes) -> list[Component]:
    """Return the bump stops: rubber sleeves on studs that reach from the end plates to the arm plates."""
    screw, inner = sizes.screw, sizes.half_length
    reach = inner - sizes.cam_b[1] - sizes.clearance
    rubber = sleeve(2 * stop_radius(sizes), screw.tapping_hole * MM, reach)
    stops = stop_places(sizes)
    low = [place(x, y, -inner) for x, y in stops]
    high = [place(x, y, inner, UPSIDE_DOWN) for x, y in stops]
    long = reach + sizes.end_plate
    return [
        Component("bump stop", "body", rubber, "rubber", "cutting", (*low, *high),
                  f"rubber hose {2 * stop_radius(sizes):g} x {stop_radius(sizes) - screw.diameter * MM / 2:.3g}",
                  size=f"{reach:.1f} mm long"),
        stud("stud of a bump stop", "body", screw, long,
             (*(place(x, y, -sizes.top) for x, y in stops), *(place(x, y, inner - reach) for x, y in stops))),
    ]  # fmt: skip


def _on_faces(points: list[tuple[float, float]], top: float) -> tuple[PartPlace, ...]:
    """Return places of screws on the outer faces of both end plates."""
    upper = [place(x, y, top) for x, y in points]
    return (*upper, *(place(x, y, -top, UPSIDE_DOWN) for x, y in points))
