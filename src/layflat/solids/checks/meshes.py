"""Triangles of placed parts, and the least distance between them; lengths in mm."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property, partial
from itertools import combinations
from typing import TYPE_CHECKING, Any

from layflat.lazy import numpy as np
from layflat.solids import cad
from layflat.solids.meshes import solid_mesh
from layflat.solids.shapes import Lofted

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Sequence

    from layflat.arrays import Array
    from layflat.solids.component import Component
    from layflat.solids.shapes import PartPlace, Shape

CHORD_TOLERANCE = 0.05  # most that triangles lie inside a curved face, mm
CHORD_ANGLE = 0.4  # most between two triangles of a curved face, rad
ENCLOSING_MARGIN = 1e-3  # most that the kernel lays a solid beside its sections, mm
PAIRS_AT_ONCE = 20_000  # pairs of triangles whose distances are computed together
TRIANGLE_EDGES = ((0, 1), (1, 2), (2, 0))
LEAST_SQUARE = 1e-18  # that stands for the squared length of an edge of no length, mm2


@dataclass(frozen=True, eq=False)
class PartMesh:
    """Surface of one placed part as triangles, which are made when they are asked for."""

    component: Component
    make: Callable[[], Array]  # function that returns the corners of the triangles, (n, 3, 3)
    outer: PartMesh | None = None  # surface that encloses the part and takes no CAD kernel, if there is one

    @cached_property
    def triangles(self) -> Array:
        """Corners of the triangles, (n, 3, 3)."""
        return self.make()

    @cached_property
    def boxes(self) -> tuple[Array, Array]:
        """Lower and upper corners of the triangles' bounding boxes, (n, 3) each."""
        a, b, c = (self.triangles[:, k] for k in range(3))  # a fifth of the time of least values along an axis
        return np.minimum(np.minimum(a, b), c), np.maximum(np.maximum(a, b), c)

    @cached_property
    def span(self) -> tuple[Array, Array]:
        """Lower and upper corner of the triangles' common bounding box, (3,) each."""
        low, high = self.boxes
        return low.min(axis=0), high.max(axis=0)

    @property
    def box(self) -> tuple[Array, Array]:
        """Lower and upper corner of a box that holds the part, (3,) each; of parts with an outer surface, its box."""
        if self.outer is None:
            return self.span
        low, high = self.outer.span
        return low - ENCLOSING_MARGIN, high + ENCLOSING_MARGIN

    def moved(self, at: PartPlace) -> PartMesh:
        """Return the part where its frame has a place in another frame."""
        outer = self.outer.moved(at) if self.outer else None
        return PartMesh(self.component, lambda: self.triangles @ at.axes.T + at.origin, outer)


@dataclass(frozen=True)
class MeshStore:
    """Triangles of shapes, each computed once."""

    solid: Callable[[Shape], Any] = cad.solid  # function that returns the solid of a shape, mm
    _triangles: dict[Shape, Array] = field(default_factory=dict)

    def parts(self, components: Iterable[Component]) -> list[PartMesh]:
        """Return all parts of components as meshes, each at its place."""
        meshes = [PartMesh(one, partial(self.triangles, one.shape), _outer_mesh(one)) for one in components]
        return [mesh.moved(place) for mesh in meshes for place in mesh.component.places]

    def triangles(self, shape: Shape) -> Array:
        """Return the triangles of a shape in its own frame, (n, 3, 3)."""
        if shape not in self._triangles:
            mesh = solid_mesh(self.solid(shape), CHORD_TOLERANCE, CHORD_ANGLE)
            self._triangles[shape] = mesh.points[mesh.triangles]
        return self._triangles[shape]


def _outer_mesh(component: Component) -> PartMesh | None:
    """Return a surface around a shape that is laid through sections; None for other shapes."""
    shape = component.shape
    return PartMesh(component, partial(enclosing_triangles, shape)) if isinstance(shape, Lofted) else None


def enclosing_triangles(shape: Lofted) -> Array:
    """Return triangles that enclose a shape, (n, 3, 3): its faces lie in the tetrahedra of their corners."""
    sections = np.array(shape.sections)
    edges = np.stack((sections, np.roll(sections, -1, axis=1)), axis=2)
    corners = np.concatenate((edges[:-1], edges[1:]), axis=2).reshape(-1, 4, 3)  # of each face between two sections
    faces = [corners[:, chosen] for chosen in combinations(range(4), 3)]
    ends = [np.stack((np.broadcast_to(end[0], end[2:].shape), end[1:-1], end[2:]), axis=1) for end in sections[[0, -1]]]
    return np.concatenate((*faces, *ends))


def least_distance(first: PartMesh, second: PartMesh, reach: float) -> float:
    """Return the least distance of two parts' surfaces, 0 where they cross, infinity beyond a reach.

    Args:
        first: one part.
        second: the other part.
        reach: distance up to which it matters, mm.
    """
    if first.outer or second.outer:  # far from what encloses a part is far from the part
        around = _surface_distance(first.outer or first, second.outer or second, reach + ENCLOSING_MARGIN)
        if around == float("inf"):
            return around
    return _surface_distance(first, second, reach)


def _surface_distance(first: PartMesh, second: PartMesh, reach: float) -> float:
    """Return the least distance of two parts' triangles, 0 where they cross, infinity beyond a reach, mm."""
    one, other = _near(first, second, reach), _near(second, first, reach)
    if not one.size or not other.size:
        return float("inf")
    (low, high), (other_low, other_high) = first.boxes, second.boxes
    close = np.ones((len(one), len(other)), bool)
    for axis in range(3):
        close &= low[one, axis][:, None] <= other_high[other, axis] + reach
        close &= other_low[other, axis] <= high[one, axis][:, None] + reach
    i, k = np.nonzero(close)
    least = float("inf")
    for begin in range(0, len(i), PAIRS_AT_ONCE):
        chosen = slice(begin, begin + PAIRS_AT_ONCE)
        a, b = first.triangles[one[i[chosen]]], second.triangles[other[k[chosen]]]
        least = min(least, float(triangle_distances(a, b).min()))
        if least == 0.0:
            break
    return least if least <= reach else float("inf")


def _near(part: PartMesh, other: PartMesh, reach: float) -> Any:
    """Return the numbers of the triangles of a part whose boxes are within a reach (mm) of another part's box."""
    (low, high), (other_low, other_high) = part.boxes, other.span
    return np.nonzero(((low <= other_high + reach) & (high >= other_low - reach)).all(axis=1))[0]


def box_gaps(first: Sequence[PartMesh], second: Sequence[PartMesh]) -> Array:
    """Return the distances of the bounding boxes of parts along the axis on which they are farthest apart, (n, m)."""
    low, high = (np.array([part.box[k] for part in first]) for k in (0, 1))
    other_low, other_high = (np.array([part.box[k] for part in second]) for k in (0, 1))
    gaps: Array = np.maximum(low[:, None] - other_high, other_low - high[:, None]).max(axis=-1)
    return gaps


def triangle_distances(a: Array, b: Array) -> Array:
    """Return the distances of pairs of triangles, (n,), from their corners, (n, 3, 3) each; 0 where they cross."""
    least = np.full(len(a), np.inf)
    for first, second in ((a, b), (b, a)):
        least = np.minimum(least, _corner_distances(first, second))
        least[_crosses(first, second)] = 0.0
    for i, j in TRIANGLE_EDGES:
        for k, m in TRIANGLE_EDGES:
            least = np.minimum(least, segment_distances(a[:, i], a[:, j], b[:, k], b[:, m]))
    return least


def segment_distances(p: Array, q: Array, r: Array, s: Array) -> Array:
    """Return the distances of pairs of segments, (n,) (ericson2005, section 5.1.9).

    Args:
        p: starts of the first segments, (n, 3).
        q: their ends.
        r: starts of the second segments.
        s: their ends.
    """
    one, two, apart = q - p, s - r, p - r
    a, e = (np.maximum(_dot(v, v), LEAST_SQUARE) for v in (one, two))
    b, c, f = _dot(one, two), _dot(one, apart), _dot(two, apart)
    across = a * e - b * b
    parallel = across <= 1e-12 * a * e
    along = np.where(parallel, 0.0, (b * f - c * e) / np.where(parallel, 1.0, across))
    along = np.clip(along, 0.0, 1.0)
    other = np.clip((b * along + f) / e, 0.0, 1.0)
    along = np.clip((b * other - c) / a, 0.0, 1.0)
    gap = apart + along[:, None] * one - other[:, None] * two
    distances: Array = np.sqrt(_dot(gap, gap))
    return distances


def _corner_distances(corners: Array, triangles: Array) -> Array:
    """Return the least distances of corners from triangles above which they lie, (n,); infinity where none does."""
    normal, area = _normals(triangles)
    least = np.full(len(corners), np.inf)
    for k in range(3):
        height = _dot(corners[:, k] - triangles[:, 0], normal) / np.sqrt(area)
        foot = corners[:, k] - (height / np.sqrt(area))[:, None] * normal
        inside = _inside(foot, triangles, normal)
        least = np.where(inside, np.minimum(least, np.abs(height)), least)
    return least


def _crosses(edged: Array, triangles: Array) -> Any:
    """Return which pairs have an edge of the first triangle that goes through the second one, (n,)."""
    normal, _ = _normals(triangles)
    heights = [_dot(edged[:, k] - triangles[:, 0], normal) for k in range(3)]
    crossed = np.zeros(len(edged), bool)
    for i, j in TRIANGLE_EDGES:
        through = heights[i] * heights[j] < 0
        share = np.where(through, heights[i] / np.where(through, heights[i] - heights[j], 1.0), 0.0)
        point = edged[:, i] + share[:, None] * (edged[:, j] - edged[:, i])
        crossed |= through & _inside(point, triangles, normal)
    return crossed


def _normals(triangles: Array) -> tuple[Array, Array]:
    """Return normals of triangles, (n, 3), not of length 1, and their squares, (n,)."""
    normal = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    return normal, np.maximum(_dot(normal, normal), LEAST_SQUARE)


def _inside(points: Array, triangles: Array, normal: Array) -> Any:
    """Return which points in the planes of triangles lie inside them, (n,)."""
    edges = np.roll(triangles, -1, axis=1) - triangles
    turned = np.cross(edges, points[:, None] - triangles)
    return (np.einsum("nkj,nj->nk", turned, normal) >= 0).all(axis=1)


def _dot(a: Array, b: Array) -> Array:
    products: Array = np.einsum("ij,ij->i", a, b)
    return products


def segment_mesh(component: Component, start: Array, end: Array) -> PartMesh:
    """Return a straight line as a mesh, of one triangle without area.

    Args:
        component: that it is noted under.
        start: mm, (3,).
        end: mm, (3,).
    """
    return PartMesh(component, lambda: np.array([[start, end, end]], float))
