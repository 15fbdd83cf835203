"""Flat patterns: outlines of parts that are cut from sheet, plate, strip or hose, with their holes and bends; mm.

A part that is bent is drawn in its own section and extruded along its width. Its pattern has the length along the
section's middle line on the x-axis, from the first end on, and the width on the y-axis: the neutral line is assumed in
the middle of the sheet (k = 0.5).
"""

from __future__ import annotations

from dataclasses import dataclass
from math import hypot, pi
from typing import TYPE_CHECKING, NamedTuple

from layflat.lazy import numpy as np
from layflat.solids.blanks import LENGTH_PATTERN
from layflat.solids.loops import Loop, rectangle
from layflat.solids.shapes import Drilled, Hole, Lofted, Prism
from layflat.solids.standard.processes import BEND_SHARES

if TYPE_CHECKING:
    from layflat.arrays import Array
    from layflat.solids.component import Component

CUT_MAKINGS = frozenset({"laser cutting", "milling", "bending", "cutting"})  # that follow a contour
THICKNESS_VARIATION = 0.5  # of a bent sheet's drawn thickness, at mitres
STRAIGHT_SHARE = 0.4  # curvature of a straight piece beside an arc over the arc's, as points show it
SAME_ARC = 1.6  # greatest ratio of curvatures in one arc
SHARP_TURN = 0.12  # turn at one point, above which it is a bend and not part of an arc, rad
DEPTH_STEP = 0.1  # between points at which the axis of a hole is looked at
FOLDED_RATIO = 1.5  # cut length of a hose over its way from the clamp to its end, above which it is folded in two
MIN_CURVATURE = 1e-4  # curvature that counts as straight, 1/mm
SMALLEST_BEND = 0.04  # angle below which an arc is none, rad


class Bend(NamedTuple):
    """Bent or rolled zone of a pattern."""

    start: float  # along the length
    end: float
    radius: float  # inner
    angle: float  # rad; above 0 the ends come towards the viewer

    def __str__(self) -> str:
        side = "up" if self.angle > 0 else "down"
        return f"R{self.radius:.1f} inside, {np.degrees(abs(self.angle)):.1f}° {side}"


@dataclass(frozen=True)
class FlatPart:
    """Pattern of a part of one thickness, seen from above."""

    outline: Loop
    thickness: float
    holes: tuple[Hole, ...] = ()
    openings: tuple[Loop, ...] = ()
    bends: tuple[Bend, ...] = ()
    drilled: tuple[Drilled, ...] = ()  # other than along the thickness
    through: frozenset[int] = frozenset()  # indices of those that come out on the other side
    pockets: tuple[tuple[Loop, float, float], ...] = ()
    profile: Loop | None = None  # of a bent part

    @property
    def box(self) -> Array:
        """Least and greatest x and y of the outline, (2, 2)."""
        points = self.outline.points()
        return np.array([points.min(axis=0), points.max(axis=0)])


def flat_part(component: Component) -> FlatPart | None:
    """Return the pattern of a component, or None if it is turned."""
    shape = component.shape
    if isinstance(shape, Lofted):
        return _hose(component, shape)
    if not isinstance(shape, Prism):
        return None
    path = _middle_line(shape)
    if path is not None:
        return _unrolled(component, shape, path)
    along = [hole for hole in shape.drilled if abs(hole.direction[2]) > 1 - 1e-9 and hole.depth >= shape.height]
    holes = tuple(Hole(hole.start[:2], hole.diameter, hole.thread) for hole in along)
    others = [_in_material(hole, shape) for hole in shape.drilled if hole not in along]
    through = frozenset(k for k, (_, out) in enumerate(others) if out)
    drilled = tuple(hole for hole, _ in others)
    return FlatPart(
        shape.outline, shape.height, (*shape.holes, *holes), shape.openings, (), drilled, through, shape.pockets
    )


def _in_material(hole: Drilled, shape: Prism) -> tuple[Drilled, bool]:
    """Return the part of a hole that lies in a prism's material, and whether the hole comes out again.

    Args:
        hole: across the prism's axis.
        shape: the prism.
    """
    from matplotlib.path import Path  # noqa: PLC0415

    depths = np.arange(0.0, hole.depth + DEPTH_STEP / 2, DEPTH_STEP)
    axis = np.array(hole.start) + depths[:, None] * np.array(hole.direction)
    inside = Path(shape.outline.points()).contains_points(axis[:, :2])
    inside &= (axis[:, 2] > 0) & (axis[:, 2] < shape.height)
    for opening in shape.openings:
        inside &= ~Path(opening.points()).contains_points(axis[:, :2])
    if not inside.any():
        return hole, False
    first = int(inside.argmax())
    beyond = np.flatnonzero(~inside[first:])
    if not beyond.size:
        return hole, False
    start = axis[max(first - 1, 0)]
    depth = float(depths[first + beyond[0]] - depths[max(first - 1, 0)])
    return hole._replace(start=(float(start[0]), float(start[1]), float(start[2])), depth=depth), True


def cut_by_contour(component: Component, part: FlatPart | None) -> bool:
    """Return whether a part is made by cutting along the contour of its pattern, so that it has a DXF file."""
    made = component.making in CUT_MAKINGS and not component.material.endswith("tube")
    return part is not None and made and not part.pockets


def cut_length(component: Component) -> float | None:
    """Return the length to cut (mm) that a component's size states, if it does."""
    found = LENGTH_PATTERN.search(component.size)
    return float(found[1]) if found else None


def _middle_line(shape: Prism) -> Array | None:
    """Return the middle line of a section, (n, 2), if it is that of a sheet thinner than its extrusion, else None."""
    points = shape.outline.points()
    if len(points) % 2 or shape.holes or shape.openings:
        return None
    half = len(points) // 2
    one, other = points[:half], points[half:][::-1]
    across = np.hypot(*(one - other).T)
    thickness = float(np.median(across))
    path: Array = (one + other) / 2
    if thickness > min(shape.height, float(_lengths(path)[-1])) or np.ptp(across) > THICKNESS_VARIATION * thickness:
        return None
    return path


def _lengths(path: Array) -> Array:
    """Return the length of a line (n, 2) from its first point to each of its points, (n,)."""
    lengths: Array = np.r_[0.0, np.cumsum(np.hypot(*np.diff(path, axis=0).T))]
    return lengths


def _bend_share(component: Component) -> float:
    """Return the inner radius of a sharp bend over the sheet's thickness."""
    return BEND_SHARES.get(component.material, (1.0, ""))[0]


def _unrolled(component: Component, shape: Prism, path: Array) -> FlatPart:
    """Return the pattern of a sheet whose section has a middle line (n, 2)."""
    along = _lengths(path)
    points = shape.outline.points()
    thickness = float(np.median(np.hypot(*(points[: len(path)] - points[len(path) :][::-1]).T)))
    spare = max((cut_length(component) or 0.0) - float(along[-1]), 0.0) if component.making == "cutting" else 0.0
    holes = tuple(
        Hole((spare / 2 + _along_path(hole, path, along), hole.start[2]), hole.diameter, hole.thread)
        for hole in shape.drilled
    )
    bends = _bends(path, along, thickness, thickness * _bend_share(component)) if component.making == "bending" else ()
    length = float(along[-1] + spare)
    outline = rectangle(length, shape.height, (length / 2, shape.height / 2))
    return FlatPart(outline, thickness, holes, bends=bends, profile=shape.outline if bends else None)


def _along_path(hole: Drilled, path: Array, along: Array) -> float:
    """Return where along a middle line (n, 2) with lengths (n,) a hole through the sheet crosses it."""
    start, direction = np.array(hole.start[:2]), np.array(hole.direction[:2])
    normal = np.array([-direction[1], direction[0]])
    across, depth = (path - start) @ normal, (path - start) @ direction
    for k in np.flatnonzero(across[:-1] * across[1:] <= 0):
        share = across[k] / (across[k] - across[k + 1]) if across[k] != across[k + 1] else 0.0
        if -1e-6 <= depth[k] + share * (depth[k + 1] - depth[k]) <= hole.depth + 1e-6:
            return float(along[k] + share * (along[k + 1] - along[k]))
    return float(along[int(np.argmin(np.hypot(*(path - start).T)))])


def _bends(path: Array, along: Array, thickness: float, inner: float) -> tuple[Bend, ...]:
    """Return the arcs of a middle line (n, 2).

    Args:
        path: middle line.
        along: lengths from its first point, (n,).
        thickness: of the sheet.
        inner: radius of bends that are drawn as corners.
    """
    steps = np.diff(along)
    headings = np.unwrap(np.arctan2(*np.diff(path, axis=0).T[::-1]))
    turns = np.r_[0.0, np.diff(headings), 0.0]
    sharp = np.abs(turns) > SHARP_TURN
    found = [_sharp_bend(float(along[k]), -float(turns[k]), inner, thickness) for k in np.flatnonzero(sharp)]
    turns[sharp] = 0.0
    curvature = (turns[:-1] + turns[1:]) / 2 / steps
    curvature[[0, -1]] *= 2  # they have a neighbour at one end only
    # A straight piece between arcs seems curved by half of their turn at both of its ends.
    beside = np.maximum(np.abs(np.r_[0.0, curvature[:-1]]), np.abs(np.r_[curvature[1:], 0.0]))
    curved = (np.abs(curvature) > STRAIGHT_SHARE * beside) & (np.abs(curvature) > MIN_CURVATURE)
    groups: list[list[int]] = []
    for k in np.flatnonzero(curved):
        last = groups[-1][-1] if groups else -9
        ratio = curvature[k] / curvature[last]
        if last == k - 1 and 1 / SAME_ARC <= ratio <= SAME_ARC:
            groups[-1].append(int(k))
        else:
            groups.append([int(k)])
    for group in groups:
        bent = float(np.median(curvature[group]))
        start, end = float(along[group[0]]), float(along[group[-1] + 1])
        # Seen from above, the normal of the pattern points to the right of the line's heading.
        if (end - start) * abs(bent) > SMALLEST_BEND:
            found.append(Bend(start, end, 1 / abs(bent) - thickness / 2, -(end - start) * bent))
    return tuple(sorted(found))


def _sharp_bend(middle: float, angle: float, radius: float, thickness: float) -> Bend:
    """Return a bend that is drawn as a corner.

    Args:
        middle: where it is along the length.
        angle: rad, with its sign.
        radius: inner.
        thickness: of the sheet.
    """
    half = abs(angle) * (radius + thickness / 2) / 2
    return Bend(middle - half, middle + half, radius, angle)


def _hose(component: Component, shape: Lofted) -> FlatPart:
    """Return the pattern of a hose that is laid flat, with the holes at its clamped end, or ends if it is folded."""
    sections = np.array(shape.sections)
    path = sections.mean(axis=1)[:, :2]
    along = _lengths(path)
    first = sections[0]
    gap = float(np.ptp(first[:, :2] @ _unit(first[:, :2])))
    height = float(np.ptp(first[:, 2]))
    width = height + (pi / 2 - 1) * gap
    length = cut_length(component) or float(along[-1])
    outline = rectangle(length, width, (length / 2, width / 2))
    holes = [
        Hole((_along_path(hole, path, along), hole.start[2] + width / 2), hole.diameter, hole.thread)
        for hole in shape.drilled
    ]
    if length > FOLDED_RATIO * along[-1]:
        holes += [Hole((length - x, y), diameter, thread) for (x, y), diameter, thread in holes]
    return FlatPart(outline, gap, tuple(holes))


def _unit(points: Array) -> Array:
    """Return the direction of the longest extent of a section's points in the plane (n, 2), as a unit vector."""
    apart = points - points[0]
    furthest = apart[int(np.argmax(np.hypot(*apart.T)))]
    unit: Array = furthest / hypot(*furthest)
    return unit
