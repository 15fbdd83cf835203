"""Triangles of parts within a budget, for scenes that browsers draw without a graphics device."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from layflat.lazy import numpy as np
from layflat.solids import cad
from layflat.solids.meshes import solid_mesh
from layflat.solids.shapes import Joined, Lofted, Prism, Shape, Turned

if TYPE_CHECKING:
    from collections.abc import Sequence

    from layflat.arrays import Array
    from layflat.solids.component import Component

CHORD_ERRORS = (2.0, 1.0, 0.5)  # of triangles, coarsest first, mm: a pixel of a scene is about 2 mm
MAX_CHORD_ANGLE = 1.6  # between neighbouring triangles, rad: small cylinders become prisms


def coarse_triangles(components: Sequence[Component], budget: int) -> dict[Shape, Array]:
    """Return the corners of triangles of parts without holes, mm, (n, 3, 3), in the frames of their shapes.

    They are as fine as the budget allows; where the coarsest are too many, the smallest parts are left out.

    Args:
        components: parts to draw.
        budget: most triangles of all parts together.
    """
    plain = {one.shape: without_holes(one.shape) for one in components}
    numbers = dict.fromkeys(plain.values(), 0)
    for one in components:
        numbers[plain[one.shape]] += one.quantity
    solids = {shape: cad.solid(shape) for shape in numbers}

    def count(triangles: dict[Shape, Array]) -> int:
        return sum(numbers[shape] * len(corners) for shape, corners in triangles.items())

    chosen: dict[Shape, Array] = {}
    for error in CHORD_ERRORS:  # a mesh that is there is only replaced by a finer one
        meshes = {shape: solid_mesh(solid, error, MAX_CHORD_ANGLE) for shape, solid in solids.items()}
        found = {shape: mesh.points[mesh.triangles] for shape, mesh in meshes.items()}
        if chosen and count(found) > budget:
            break
        chosen = found
    for shape in sorted(chosen, key=lambda one: _extent(chosen[one])):
        if count(chosen) <= budget:
            break
        del chosen[shape]
    return {shape: chosen[own] for shape, own in plain.items() if own in chosen}


def without_holes(shape: Shape) -> Shape:
    """Return a shape without its round holes."""
    match shape:
        case Prism():
            return replace(shape, holes=(), drilled=())
        case Turned() | Lofted():
            return replace(shape, drilled=())
        case Joined():
            return Joined(tuple((without_holes(piece), origin, axes) for piece, origin, axes in shape.pieces))  # type: ignore[misc]


def _extent(corners: Array) -> float:
    """Return the greatest extent of triangles along an axis of their frame, mm."""
    points = corners.reshape(-1, 3)
    return float(np.ptp(points, axis=0).max())
