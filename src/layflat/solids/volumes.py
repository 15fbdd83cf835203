"""Volumes and lowest points of shapes without a CAD kernel: areas times heights, Pappus's rule, and less the holes.

Pockets and drilled holes run out of the part and into each other: lines and points within them are counted.
"""

from __future__ import annotations

from itertools import pairwise
from math import pi
from typing import TYPE_CHECKING

from layflat.lazy import numpy as np
from layflat.solids.component import axes_towards
from layflat.solids.loops import circle
from layflat.solids.shapes import Lofted, Prism, Turned
from layflat.solids.sizes import MM

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from numpy.typing import NDArray

    from layflat.arrays import Array
    from layflat.solids.component import Component
    from layflat.solids.loops import Loop
    from layflat.solids.shapes import Drilled, PartPlace, Shape

FINE_STEP = pi / 360  # angle between points of an arc, rad: a circle's area is right to 2e-5
POINT_COUNT = 2048  # points spread through a hole
LINE_COUNT = 400  # lines across a pocket
POINT_STEPS = 1.324717957244746 ** -np.arange(1.0, 3.0)
"""Steps from point to point along two axes that fill a square evenly: powers of the root of x^3 = x + 1."""


def mass_of(component: Component) -> float:
    """Return the mass of one part of a component, kg: as bought, or by the volume of its shape."""
    if component.bought_mass is not None:
        return component.bought_mass
    return volume(component.shape) / MM**3 * component.density


def volume(shape: Shape) -> float:
    """Return the volume of a shape, mm3; holes through hoses, and where joined pieces overlap, count as material."""
    match shape:
        case Prism(outline, height):
            flat = sum(area for area, _ in map(_moments, _cuts(shape)))
            solid = height * (_moments(outline)[0] - flat)
            return solid - sum(_pocket_volumes(shape)) - sum(_hole_volumes(shape))
        case Turned(outline):
            return 2 * pi * _moments(outline)[1] - sum(_hole_volumes(shape))
        case Lofted(sections):
            return _lofted_volume(np.array(sections))
        case _:
            return sum(volume(piece) for piece, _ in shape.placed())


def lowest(shape: Shape, at: PartPlace) -> float:
    """Return the lowest point of a shape at a place, along z of the frame of the place."""
    across = float(np.hypot(*at.axes[2, :2]))
    match shape:
        case Prism(outline, height):
            along = outline.points(FINE_STEP) @ at.axes[2, :2]
            reach = float(along.min()) + min(0.0, height * float(at.axes[2, 2]))
        case Turned(outline):
            radius, z = outline.points(FINE_STEP).T
            reach = float((z * at.axes[2, 2] - radius * across).min())
        case Lofted(sections):
            reach = float((np.vstack(sections) @ at.axes[2]).min())
        case _:
            return min(lowest(piece, place.then(at)) for piece, place in shape.placed())
    return float(at.origin[2]) + reach


def _cuts(shape: Prism) -> list[Loop]:
    """Return the outlines of all that goes through a flat part's whole height."""
    return [*shape.openings, *(circle(*hole.centre, hole.diameter / 2) for hole in shape.holes)]


def _moments(loop: Loop) -> tuple[float, float]:
    """Return area (mm2) and first moment of area about the y-axis (mm3) within a loop, above 0."""
    x, y = loop.points(FINE_STEP).T
    after_x, after_y = np.roll(x, -1), np.roll(y, -1)
    cross = x * after_y - after_x * y
    return abs(float(cross.sum())) / 2, abs(float(cross @ (x + after_x))) / 6


def _lofted_volume(sections: Array) -> float:
    """Return the volume within polygons (sections, corners, 3), with straight lines between and flat ends."""
    total = 0.0
    for first, second in pairwise(sections):
        a, b, c, d = first, np.roll(first, -1, axis=0), np.roll(second, -1, axis=0), second
        # A curved patch has the mean of the volumes of its two pairs of triangles.
        for one, two, three in ((a, b, c), (a, c, d), (a, b, d), (b, c, d)):
            total += _tetrahedra(one, two, three) / 2
    for end, sign in ((sections[0], -1.0), (sections[-1], 1.0)):
        middle = np.broadcast_to(end.mean(axis=0), end.shape)
        total += sign * _tetrahedra(middle, end, np.roll(end, -1, axis=0))
    return abs(total)


def _tetrahedra(a: Array, b: Array, c: Array) -> float:
    """Return the signed volume of tetrahedra between triangles (n, 3) and the origin."""
    return float(np.einsum("ij,ij->", a, np.cross(b, c))) / 6


def _pocket_volumes(shape: Prism) -> Iterable[float]:
    """Yield the volume that each pocket takes from a flat part."""
    region = [shape.outline, *_cuts(shape)]
    for loop, low, high in shape.pockets:
        start, end = loop.points()[:, 1].min(), loop.points()[:, 1].max()
        y = start + (end - start) * (np.arange(LINE_COUNT) + 0.5) / LINE_COUNT
        # Chords of what is in one of both, but not in the other, are those of all edges together.
        shared = (_chords(region, y) + _chords([loop], y) - _chords([*region, loop], y)) / 2
        yield float(shared.mean() * (end - start)) * max(0.0, min(high, shape.height) - max(low, 0.0))


def _chords(loops: Sequence[Loop], y: Array) -> Array:
    """Return the length of each line along x, at y, that an odd number of loops encloses."""
    found = []
    for loop in loops:
        ax, ay = loop.points(FINE_STEP).T
        bx, by = np.roll(ax, -1), np.roll(ay, -1)
        crossed = (ay > y[:, None]) != (by > y[:, None])
        slope = (bx - ax) / np.where(by == ay, 1.0, by - ay)
        found.append(np.where(crossed, ax + (y[:, None] - ay) * slope, np.inf))
    ends = np.sort(np.hstack(found), axis=1)
    ends[np.isinf(ends)] = 0.0
    count = ends.shape[1] // 2 * 2
    lengths: Array = ends[:, 1:count:2].sum(axis=1) - ends[:, 0:count:2].sum(axis=1)
    return lengths


def _hole_volumes(shape: Prism | Turned) -> Iterable[float]:
    """Yield the volume that each drilled hole takes from a part and its earlier holes have left."""
    for k, hole in enumerate(shape.drilled):
        points = _points_in(hole)
        left = _shape_mask(shape, points)
        for before in shape.drilled[:k]:
            left &= ~_hole_mask(before, points)
        yield float(np.mean(left)) * pi / 4 * hole.diameter**2 * hole.depth


def _points_in(hole: Drilled) -> Array:
    """Return points in a hole, (n, 3), of which each stands for the same volume."""
    counts = np.arange(POINT_COUNT) + 0.5
    area, turn = (counts[:, None] * POINT_STEPS % 1.0).T
    radius, angle, depth = hole.diameter / 2 * np.sqrt(area), 2 * pi * turn, hole.depth * counts / POINT_COUNT
    local = np.column_stack([radius * np.cos(angle), radius * np.sin(angle), depth])
    points: Array = np.array(hole.start) + local @ axes_towards(*hole.direction).T
    return points


def _hole_mask(hole: Drilled, points: Array) -> NDArray[np.bool_]:
    """Return a mask of the points (n, 3) that are within a hole."""
    away = points - np.array(hole.start)
    along = away @ np.array(hole.direction)
    across = np.linalg.norm(away - along[:, None] * np.array(hole.direction), axis=1)
    inside: NDArray[np.bool_] = (along >= 0.0) & (along <= hole.depth) & (across <= hole.diameter / 2)
    return inside


def _shape_mask(shape: Prism | Turned, points: Array) -> NDArray[np.bool_]:
    """Return a mask of the points (n, 3) that are within a shape without its drilled holes."""
    if isinstance(shape, Turned):
        return _loops_mask([shape.outline], np.column_stack([np.hypot(points[:, 0], points[:, 1]), points[:, 2]]))
    z = points[:, 2]
    inside = _loops_mask([shape.outline, *_cuts(shape)], points) & (z >= 0.0) & (z <= shape.height)
    for loop, low, high in shape.pockets:
        inside &= ~(_loops_mask([loop], points) & (z >= low) & (z <= high))
    return inside


def _loops_mask(loops: Iterable[Loop], points: Array) -> NDArray[np.bool_]:
    """Return a mask of the points (n, 2 or more) that an odd number of loops encloses."""
    x, y = points[:, :1], points[:, 1:2]
    odd = np.zeros(len(points), bool)
    for loop in loops:
        ax, ay = loop.points().T
        bx, by = np.roll(ax, -1), np.roll(ay, -1)
        crossed = (ay > y) != (by > y)
        slope = (bx - ax) / np.where(by == ay, 1.0, by - ay)
        odd ^= (np.count_nonzero(crossed & (x < ax + (y - ay) * slope), axis=1) % 2).astype(bool)
    return odd
