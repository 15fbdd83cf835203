"""Triangles of solids; lengths in mm. Needs the extra `cad`."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

from layflat.lazy import numpy as np
from layflat.solids.kernel import kernel, pieces

if TYPE_CHECKING:
    from layflat.arrays import Array

CHORD_ERROR = 0.15  # greatest distance of triangles from a surface, mm
CHORD_ANGLE = 0.35  # greatest angle between neighbouring triangles of a surface, rad


class Mesh(NamedTuple):
    """Triangles of a solid; each face of it has points of its own, so that edges between faces stay sharp."""

    points: Array  # mm, (n, 3)
    normals: Array  # outwards, of length 1, (n, 3)
    triangles: Array  # indices of points, anticlockwise from outside, (m, 3)


def triangulate(solid: Any, error: float = CHORD_ERROR, angle: float = CHORD_ANGLE) -> None:
    """Give a solid, and all copies of it at other places, triangles.

    Args:
        solid: the solid.
        error: greatest distance of triangles from a surface, mm.
        angle: greatest angle between neighbouring triangles of a surface, rad.
    """
    kernel().BRepMesh.BRepMesh_IncrementalMesh(solid, error, False, angle)


def solid_mesh(solid: Any, error: float = CHORD_ERROR, angle: float = CHORD_ANGLE) -> Mesh:
    """Return the triangles of a solid in its own frame.

    Args:
        solid: the solid.
        error: as of `triangulate`.
        angle: as of `triangulate`.
    """
    triangulate(solid, error, angle)
    brep, top = kernel().BRep, kernel().TopLoc
    reversed_face = kernel().TopAbs.TopAbs_REVERSED
    points: list[tuple[float, float, float]] = []
    corners: list[tuple[int, int, int]] = []
    for face in pieces(solid, "FACE"):
        moved = top.TopLoc_Location()
        found = brep.BRep_Tool.Triangulation_s(face, moved)
        if found is None:
            continue
        first, move = len(points) - 1, moved.Transformation()
        for k in range(1, found.NbNodes() + 1):
            node = found.Node(k).Transformed(move)
            points.append((node.X(), node.Y(), node.Z()))
        reverse = face.Orientation() == reversed_face
        for k in range(1, found.NbTriangles() + 1):
            a, b, c = found.Triangle(k).Get()
            corners.append((first + a, first + c, first + b) if reverse else (first + a, first + b, first + c))
    array, triangles = np.array(points), np.array(corners)
    return Mesh(array, _normals(array, triangles), triangles)


def _normals(points: Array, triangles: Array) -> Array:
    """Return the normals of points: means of those of their triangles by area, (n, 3)."""
    a, b, c = (points[triangles[:, k]] for k in range(3))
    areas = np.cross(b - a, c - a)
    rows = triangles.T.ravel()
    sums = np.column_stack([np.bincount(rows, np.tile(areas[:, k], 3), len(points)) for k in range(3)])
    lengths = np.linalg.norm(sums, axis=1, keepdims=True)
    normals: Array = np.where(lengths > 0, sums / np.where(lengths > 0, lengths, 1.0), (0.0, 0.0, 1.0))
    return normals
