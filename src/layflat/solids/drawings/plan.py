"""Plans: patterns of flat parts seen from above, with holes, bends, radii and what is hidden; mm."""

from __future__ import annotations

from math import atan2, cos, hypot, pi, sin
from typing import TYPE_CHECKING

from layflat.lazy import numpy as np
from layflat.solids.drawings.contours import as_circle, turn_of_arc
from layflat.solids.drawings.dimensions import draw_arrow
from layflat.solids.drawings.pockets import pieces_inside
from layflat.solids.drawings.table import number_text
from layflat.solids.drawings.views import draw_drilled, nominal_diameter
from layflat.solids.loops import ArcSide

if TYPE_CHECKING:
    from layflat.arrays import Array
    from layflat.solids.drawings.flat import FlatPart
    from layflat.solids.drawings.views import View
    from layflat.solids.loops import Loop

LOOSE_RADII = 6  # radii of an outline up to which they are dimensioned


def draw_plan(view: View, part: FlatPart, *, origin: bool) -> None:
    """Draw a pattern from above: outline, openings, holes with numbers and centre lines, bends, and what is hidden.

    Args:
        view: where.
        part: the pattern.
        origin: whether the origin of the hole table is marked.
    """
    for loop in (part.outline, *part.openings):
        view.line(loop.points(), "outline", closed=True)
        ring = as_circle(loop)
        if ring is not None:
            view.cross((ring.x, ring.y), ring.radius)
    for loop, _, _ in part.pockets:
        draw_clipped(view, part, loop)
    for bend in part.bends:
        for x in (bend.start, bend.end):
            view.line([(x, part.box[0, 1]), (x, part.box[1, 1])], "thin")
    for hole in part.holes:
        view.circle(hole.centre, hole.diameter / 2, "outline")
        view.cross(hole.centre, hole.diameter / 2)
        if hole.thread:
            view.circle(hole.centre, nominal_diameter(hole.thread) / 2, "thin", 0.75)
    for drilled in part.drilled:
        draw_drilled(view, drilled, (0, 1))
    if origin:
        draw_origin(view)
    draw_radii(view, part.outline)
    for opening in part.openings:
        draw_radii(view, opening, inside=True)
    numbers = [(hole.centre, max(hole.diameter, nominal_diameter(hole.thread)) / 2) for hole in part.holes]
    numbers += [(hole.start[:2], 0.0) for hole in part.drilled]
    for number, (centre, radius) in enumerate(numbers, 1):
        view.labels.place(view.paper_points(centre), radius * view.scale, str(number))


def draw_origin(view: View) -> None:
    """Mark the origin of coordinates."""
    x, y = view.paper_points((0.0, 0.0))
    angles = np.linspace(0.0, 2 * pi, 24, endpoint=False)
    view.paper.line(np.stack((x + 1.2 * np.cos(angles), y + 1.2 * np.sin(angles)), axis=-1), "thin", closed=True)
    for along, name in (((1.0, 0.0), "x"), ((0.0, 1.0), "y")):
        tip = np.array([x, y]) + 7.0 * np.array(along)
        view.labels.line([(x, y), tip])
        draw_arrow(view.paper, tip, along)
        view.labels.place(tip, 0.0, name, 2.0)


def draw_clipped(view: View, part: FlatPart, loop: Loop) -> None:
    """Draw the outline of a pocket as hidden where it lies in material.

    Args:
        view: where.
        part: the pattern.
        loop: outline of the pocket.
    """
    for piece in pieces_inside(part, loop):
        view.line(piece, "hidden")


def draw_radii(view: View, loop: Loop, *, inside: bool = False) -> None:
    """Dimension the radii of an outline's arcs, each size once; a diameter for a circle.

    Args:
        view: where.
        loop: the outline.
        inside: whether leaders point outwards from inside.
    """
    ring = as_circle(loop)
    if ring is not None:
        out = np.array([cos(pi / 4), sin(pi / 4)])
        tip = view.paper_points(np.array([ring.x, ring.y]) + ring.radius * out)
        view.labels.leader(tip, -out if inside else out, f"Ø{number_text(2 * ring.radius, 1)}")
        return
    arcs: dict[str, list[tuple[Array, Array]]] = {}
    start = loop.start
    for side in loop.sides:
        if isinstance(side, ArcSide):
            centre, turn = turn_of_arc(start, side)
            first = atan2(start[1] - centre[1], start[0] - centre[0])
            radius = hypot(start[0] - centre[0], start[1] - centre[1])
            middle = first + _leader_share(first, turn) * turn
            out = np.array([cos(middle), sin(middle)])
            arcs.setdefault(number_text(radius, 1), []).append((np.array(centre) + radius * out, out))
        start = side.end
    if len(arcs) > LOOSE_RADII:
        return
    for radius_text, places in arcs.items():
        point, out = max(places, key=lambda place: (abs(place[1][0] * place[1][1]), place[0][0]))
        count = f"{len(places)} x " if len(places) > 1 else ""
        view.labels.leader(view.paper_points(point), -out if inside else out, f"{count}R{radius_text}")


def _leader_share(first: float, turn: float) -> float:
    """Return the share of an arc at which its outward direction is closest to a diagonal: there is most room."""
    shares = np.linspace(0.1, 0.9, 33)
    return float(shares[int(np.argmax(np.abs(np.sin(2 * (first + shares * turn)))))])
