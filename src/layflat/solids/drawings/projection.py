"""Projections of parts in an assembly, without a CAD kernel: outlines, what hides what, and sections; mm.

Nearly all parts lie along or across the direction of view. Their outlines are exact then; those of others are hulls.
Nearer parts are drawn above further ones, by the point of each that is nearest to the viewer.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, NamedTuple

from layflat.lazy import numpy as np
from layflat.solids.drawings.turned import Face, faces
from layflat.solids.loops import circle
from layflat.solids.shapes import Joined, Lofted, Prism, Turned

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from layflat.arrays import Array
    from layflat.solids.component import Component
    from layflat.solids.shapes import PartPlace

    Piece = Prism | Turned | Lofted

MIN_ALONG, MAX_ACROSS = (
    0.999,
    0.02,
)  # cosine between an axis and the direction of view, from which and up to which it lies so
FRONT_VIEW = np.eye(3)  # rows: right, up and towards the viewer
LEFT_VIEW = np.array([[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]])
TOP_VIEW = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
RASTER_POINTS = 260  # points across a view by which visible parts are found
LEAST_SEEN = 4  # points of the raster of a part that counts as visible


class Shadow(NamedTuple):
    """Outline of a part in a view, and the lines of holes in it."""

    item: str
    lines: tuple[Array, ...]  # (n, 2) each
    depth: float  # of its point that is nearest to the viewer
    white: tuple[Array, ...] = ()  # areas that are cut out again


@dataclass(frozen=True)
class Projection:
    """View of an assembly: shadows, further ones first."""

    title: str
    shadows: tuple[Shadow, ...]
    section: bool = False

    @cached_property
    def box(self) -> Array:
        """Least and greatest coordinates, (2, 2)."""
        points = np.vstack([shadow.lines[0] for shadow in self.shadows])
        return np.array([points.min(axis=0), points.max(axis=0)])

    def visible(self) -> dict[str, tuple[int, Array]]:
        """Return for each item how many points of a raster show it, and a point well inside of what is seen, (2,)."""
        from scipy.ndimage import distance_transform_edt  # noqa: PLC0415

        low, high = self.box
        step = float((high - low).max()) / RASTER_POINTS
        x, y = (np.arange(a, b + step, step) for a, b in zip(low, high, strict=True))
        names = list(dict.fromkeys(shadow.item for shadow in self.shadows))
        seen = np.full((len(y), len(x)), -1)
        for shadow in self.shadows:
            _mark(seen, shadow, x, y, names.index(shadow.item))
        found = {}
        for k, name in enumerate(names):
            mask = seen == k
            if mask.sum() >= LEAST_SEEN:
                rows, columns = (np.flatnonzero(mask.any(axis=axis)) for axis in (1, 0))
                part = mask[rows[0] : rows[-1] + 1, columns[0] : columns[-1] + 1]
                inside = distance_transform_edt(np.pad(part, 1))[1:-1, 1:-1]
                row, column = np.unravel_index(int(inside.argmax()), inside.shape)
                found[name] = int(mask.sum()), np.array([x[columns[0] + column], y[rows[0] + row]])
        return found


def project(
    title: str, components: Sequence[Component], items: Sequence[str], view: Array, frame: PartPlace
) -> Projection:
    """Return a view of components.

    Args:
        title: of the view.
        components: with their places.
        items: number or name of each component.
        view: directions to the right, up and towards the viewer, as rows, (3, 3), in a frame.
        frame: place of that frame.
    """
    found = [
        Shadow(item, *_outline(shape, _view_pose(place, frame, view)))
        for component, item in zip(components, items, strict=True)
        for shape, place in _pieces(component)
    ]
    return Projection(title, tuple(sorted(found, key=lambda shadow: shadow.depth)))


def cut(title: str, components: Sequence[Component], items: Sequence[str], frame: PartPlace) -> Projection:
    """Return the section of components in the xy-plane of a frame, seen along -z.

    Args:
        title: of the view.
        components: with their places.
        items: number or name of each component.
        frame: place of the frame.
    """
    found = []
    for component, item in zip(components, items, strict=True):
        for shape, place in _pieces(component):
            shadow = _section(shape, _view_pose(place, frame, FRONT_VIEW))
            if shadow is not None:
                lines, white, order = shadow
                found.append(Shadow(item, lines, order, white))
    return Projection(title, tuple(sorted(found, key=lambda shadow: shadow.depth)), section=True)


def _pieces(component: Component) -> Iterator[tuple[Piece, PartPlace]]:
    """Yield the shapes that a component consists of, with their places."""
    for at in component.places:
        if isinstance(component.shape, Joined):
            yield from ((piece, own.then(at)) for piece, own in component.shape.placed())
        else:
            yield component.shape, at


def _view_pose(place: PartPlace, frame: PartPlace, view: Array) -> tuple[Array, Array]:
    """Return axes and origin of a place in the directions of a view of a frame."""
    turn = view @ frame.axes.T
    return turn @ place.axes, turn @ (place.origin - frame.origin)


def _outline(shape: Piece, seen: tuple[Array, Array]) -> tuple[tuple[Array, ...], float]:
    """Return the outline of a shape with its holes, and the depth of its nearest point."""
    axes, origin = seen
    along = abs(axes[2, 2])
    points = _points(shape) @ axes.T + origin
    depth = float(points[:, 2].max())
    if along > MIN_ALONG:
        flat = _lines_along_axis(shape)
        return tuple(line @ axes[:2, :2].T + origin[:2] for line in flat), depth
    if isinstance(shape, Turned) and along < MAX_ACROSS:
        profile = _stepped(faces(shape))
        side = np.array([-axes[1, 2], axes[0, 2]])
        return (origin[:2] + profile[:, :1] * axes[:2, 2] + profile[:, 1:] * side,), depth
    return (_hull(points[:, :2]),), depth


def _points(shape: Piece) -> Array:
    """Return points that span a shape, (n, 3)."""
    match shape:
        case Prism():
            flat = shape.outline.points()
            return np.vstack([np.column_stack((flat, np.full(len(flat), z))) for z in (0.0, shape.height)])
        case Turned():
            rings = [(face.radius, z) for face in faces(shape) if not face.bore for z in (face.low, face.high)]
            return np.vstack([np.column_stack((_ring(radius), np.full(48, z))) for radius, z in rings])
        case Lofted():
            return np.array(shape.sections).reshape(-1, 3)


def _ring(radius: float) -> Array:
    angles = np.linspace(0.0, 2 * np.pi, 48, endpoint=False)
    return radius * np.stack((np.cos(angles), np.sin(angles)), axis=-1)


def _lines_along_axis(shape: Piece) -> list[Array]:
    """Return the outline of a shape seen along its z-axis, then its holes, (n, 2) each."""
    match shape:
        case Prism():
            holes = [circle(*hole.centre, hole.diameter / 2) for hole in shape.holes]
            return [loop.points() for loop in (shape.outline, *shape.openings, *holes)]
        case Turned():
            found = faces(shape)
            bores = [face.radius for face in found if face.bore]
            return [_ring(max(face.radius for face in found)), *(_ring(min(bores)) for _ in bores[:1])]
        case Lofted():
            return [_band(np.array(shape.sections)[:, :, :2])]


def _band(sections: Array) -> Array:
    """Return the outline of a band from its sections, (n, k, 2), each of which is seen as a line."""
    first = sections[0] - sections[0].mean(axis=0)
    reach = first @ first[int(np.argmax(np.hypot(*first.T)))]
    one, other = sections[:, int(reach.argmax())], sections[:, int(reach.argmin())]
    return np.vstack((one, other[::-1]))


def _stepped(all_faces: Sequence[Face]) -> Array:
    """Return the outline of a turned part from its side, along its axis and across, (n, 2)."""
    outer = [(z, face.radius) for face in all_faces if not face.bore for z in (face.low, face.high)]
    upper = np.array(outer)
    return np.vstack((upper, upper[::-1] * np.array([1.0, -1.0])))


def _hull(points: Array) -> Array:
    from scipy.spatial import ConvexHull  # noqa: PLC0415

    hull: Array = points[ConvexHull(points).vertices]
    return hull


def _section(shape: Piece, seen: tuple[Array, Array]) -> tuple[tuple[Array, ...], tuple[Array, ...], float] | None:
    """Return the section of a shape by z = 0: lines, areas that pockets take, and an order of drawing; or None."""
    axes, origin = seen
    depths = _points(shape) @ axes[2] + origin[2]
    if depths.min() > -1e-6 or depths.max() < 1e-6:
        return None
    lines, _ = _outline(shape, seen)
    white: tuple[Array, ...] = ()
    if isinstance(shape, Prism) and shape.pockets and abs(axes[2, 2]) > MIN_ALONG:
        middle = -origin[2] * axes[2, 2]
        white = tuple(
            loop.points() @ axes[:2, :2].T + origin[:2] for loop, low, high in shape.pockets if low < middle < high
        )
    # Parts with pockets first: others lie in them.
    return lines, white, 0.0 if white else 1.0


def _mark(seen: Array, shadow: Shadow, x: Array, y: Array, number: int) -> None:
    """Write a number into the points of a raster that a shadow covers, in place."""
    from matplotlib.path import Path  # noqa: PLC0415

    low, high = shadow.lines[0].min(axis=0), shadow.lines[0].max(axis=0)
    columns, rows = (slice(*np.searchsorted(values, (a, b))) for values, a, b in zip((x, y), low, high, strict=True))
    grid = np.stack(np.meshgrid(x[columns], y[rows]), axis=-1)
    if not grid.size:
        return
    flat = grid.reshape(-1, 2)
    inside = Path(shadow.lines[0]).contains_points(flat)
    for hole in (*shadow.lines[1:], *shadow.white):
        inside &= ~Path(hole).contains_points(flat)
    seen[rows, columns][inside.reshape(grid.shape[:2])] = number
