"""Closed outlines of flat parts, made of straight lines, arcs and smooth curves; all lengths in mm."""

from __future__ import annotations

from dataclasses import dataclass
from math import atan2, cos, hypot, pi, sin
from typing import TYPE_CHECKING, NamedTuple

from layflat.errors import DesignError
from layflat.lazy import numpy as np

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from layflat.arrays import Array

Point = tuple[float, float]

ARC_STEP = pi / 36  # angle between two points of a drawn arc, rad
HULL_POINTS = 720  # of a circle, by which the circles on a hull are found
SHORTEST_SIDE = 1e-6  # length of a side that is left out, mm


class StraightSide(NamedTuple):
    """Straight side."""

    end: Point


class ArcSide(NamedTuple):
    """Circular side through a point."""

    via: Point
    end: Point


class CurveSide(NamedTuple):
    """Smooth side through points."""

    through: tuple[Point, ...]

    @property
    def end(self) -> Point:
        """End of the side."""
        return self.through[-1]


Side = StraightSide | ArcSide | CurveSide


class HullCircle(NamedTuple):
    """HullCircle in a plane."""

    x: float
    y: float
    radius: float


@dataclass(frozen=True)
class Loop:
    """Closed outline; the last side ends at the start."""

    start: Point
    sides: tuple[Side, ...]

    def points(self, step: float = ARC_STEP) -> Array:
        """Return corners, and points of curves and of arcs at angles (rad), (n, 2); the first is not repeated."""
        found, before = [self.start], self.start
        for side in self.sides:
            match side:
                case StraightSide(to):
                    found.append(to)
                case ArcSide(via, to):
                    found.extend(_arc_points(before, via, to, step))
                case CurveSide(through):
                    found.extend(through)
            before = side.end
        return np.array(found[:-1])

    @property
    def area(self) -> float:
        """Enclosed area, mm2; arcs count by their points."""
        x, y = self.points().T
        return 0.5 * abs(float(x @ np.roll(y, -1) - y @ np.roll(x, -1)))

    @property
    def perimeter(self) -> float:
        """Length of all sides, mm; arcs count by their points."""
        points = self.points()
        return float(np.hypot(*(points - np.roll(points, 1, axis=0)).T).sum())

    def distance(self, point: Point) -> float:
        """Return the distance of a point from the outline, mm; curves count by their points."""
        found, before = [], self.start
        for side in self.sides:
            match side:
                case ArcSide(via, to):
                    found.append(_arc_distance(before, via, to, point))
                case StraightSide(to):
                    found.append(_path_distance((before, to), point))
                case CurveSide(through):
                    found.append(_path_distance((before, *through), point))
            before = side.end
        return min(found)

    def mirrored(self) -> Loop:
        """Return the mirror image about the y-axis."""
        sides = [_mirrored_side(side) for side in self.sides]
        return Loop(_mirror(self.start), tuple(sides))

    def turned(self, angle: float, about: Point = (0.0, 0.0)) -> Loop:
        """Return the outline rotated anticlockwise by an angle (rad) about a point."""

        def turn(point: Point) -> Point:
            x, y, c, s = point[0] - about[0], point[1] - about[1], cos(angle), sin(angle)
            return about[0] + c * x - s * y, about[1] + s * x + c * y

        return Loop(turn(self.start), tuple(_mapped(side, turn) for side in self.sides))


def circle(x: float, y: float, radius: float) -> Loop:
    """Return a circle as two arcs.

    Args:
        x: coordinate of its centre, mm.
        y: the same.
        radius: mm.
    """
    return Loop((x + radius, y), (ArcSide((x, y + radius), (x - radius, y)), ArcSide((x, y - radius), (x + radius, y))))


def polygon(points: Iterable[Sequence[float]]) -> Loop:
    """Return a polygon through corners, without sides of no length."""
    corners: list[Point] = []
    for x, y in points:
        if not corners or hypot(x - corners[-1][0], y - corners[-1][1]) > SHORTEST_SIDE:
            corners.append((float(x), float(y)))
    if hypot(corners[0][0] - corners[-1][0], corners[0][1] - corners[-1][1]) <= SHORTEST_SIDE:
        corners.pop()
    return Loop(corners[0], tuple(StraightSide(corner) for corner in (*corners[1:], corners[0])))


def rectangle(width: float, height: float, centre: Point = (0.0, 0.0)) -> Loop:
    """Return a rectangle.

    Args:
        width: along x, mm.
        height: along y, mm.
        centre: mm.
    """
    x, y = width / 2, height / 2
    return polygon([(centre[0] + a * x, centre[1] + b * y) for a, b in ((-1, -1), (1, -1), (1, 1), (-1, 1))])


def sector(inner: float, outer: float, first: float, last: float) -> Loop:
    """Return a sector of a ring.

    Args:
        inner: inner radius.
        outer: outer radius.
        first: angle at which it begins, rad.
        last: angle at which it ends, rad; above `first`, by less than a whole turn.
    """
    middle = (first + last) / 2

    def point_at(radius: float, angle: float) -> Point:
        return radius * cos(angle), radius * sin(angle)

    return Loop(
        point_at(inner, first),
        (
            StraightSide(point_at(outer, first)),
            ArcSide(point_at(outer, middle), point_at(outer, last)),
            StraightSide(point_at(inner, last)),
            ArcSide(point_at(inner, middle), point_at(inner, first)),
        ),
    )


def hull(circles: Sequence[HullCircle]) -> Loop:
    """Return the convex hull of circles: arcs, and the straight lines that touch two of them."""
    order = _circles_on_hull(circles)
    if len(order) == 1:
        return circle(*circles[order[0]])
    touches = [_tangent(circles[a], circles[b]) for a, b in zip(order, [*order[1:], order[0]], strict=True)]
    sides: list[Side] = []
    start = touches[-1][1]
    for index, (leaves, arrives) in zip(order, touches, strict=True):
        x, y, radius = circles[index]
        before = sides[-1].end if sides else start
        first, last = (atan2(p[1] - y, p[0] - x) for p in (before, leaves))
        middle = first + ((last - first) % (2 * pi)) / 2
        if hypot(before[0] - leaves[0], before[1] - leaves[1]) > SHORTEST_SIDE:
            sides.append(ArcSide((x + radius * cos(middle), y + radius * sin(middle)), leaves))
        sides.append(StraightSide(arrives))
    return Loop(start, tuple(sides))


def ribbon(path: Array, below: float, above: float) -> Loop:
    """Return the outline of a strip along a path (n, 2) that does not turn back on itself.

    Args:
        path: points, mm.
        below: distance of the strip's edge on the right of the path; below 0 it lies on the left.
        above: distance of the edge on the left.
    """
    steps = np.diff(path, axis=0)
    normals = np.stack((-steps[:, 1], steps[:, 0]), axis=-1) / np.hypot(*steps.T)[:, None]
    bisectors = np.vstack((normals[:1], normals[:-1] + normals[1:], normals[-1:]))
    lengths = np.hypot(*bisectors.T)
    # At a corner the strip keeps its thickness: its edges lie further from the path there.
    reach = np.r_[1.0, 2.0 / lengths[1:-1], 1.0]
    across = bisectors / lengths[:, None] * reach[:, None]
    return polygon(np.vstack((path - below * across, (path + above * across)[::-1])))


def _circles_on_hull(circles: Sequence[HullCircle]) -> list[int]:
    """Return the indices of the circles that a hull touches, anticlockwise; a circle may come twice."""
    directions = np.linspace(0.0, 2 * pi, HULL_POINTS, endpoint=False)
    support = np.array([c.x * np.cos(directions) + c.y * np.sin(directions) + c.radius for c in circles])
    best = support.argmax(axis=0)
    changes = np.flatnonzero(best != np.roll(best, 1))
    return [int(best[at]) for at in changes] or [int(best[0])]


def _tangent(first: HullCircle, second: HullCircle) -> tuple[Point, Point]:
    """Return the points at which the line touches two circles that has both on its left."""
    dx, dy = second.x - first.x, second.y - first.y
    distance = hypot(dx, dy)
    if distance <= abs(first.radius - second.radius):
        raise DesignError("one circle lies inside the other", where="outline", right="leave the inner one out")
    along = atan2(dy, dx)
    # The normal of the line, pointing out of the hull, is the same at both circles.
    normal = along - pi / 2 + np.arcsin((first.radius - second.radius) / distance)
    n = cos(normal), sin(normal)
    start = first.x + first.radius * n[0], first.y + first.radius * n[1]
    return start, (second.x + second.radius * n[0], second.y + second.radius * n[1])


def _arc_points(start: Point, via: Point, to: Point, step: float) -> list[Point]:
    """Return points of an arc from after its start to its end."""
    x, y = arc_centre(start, via, to)
    radius = hypot(start[0] - x, start[1] - y)
    first, turn = _arc_angles((x, y), start, via, to)
    count = max(2, int(abs(turn) / step) + 1)
    inner = [first + turn * k / count for k in range(1, count)]
    return [*((x + radius * cos(a), y + radius * sin(a)) for a in inner), to]


def _arc_angles(centre: Point, start: Point, via: Point, to: Point) -> tuple[float, float]:
    """Return the angle at which an arc starts, and by which it turns, anticlockwise, rad."""
    first, middle, last = (atan2(p[1] - centre[1], p[0] - centre[0]) for p in (start, via, to))
    turn = (last - first) % (2 * pi)
    return first, turn - 2 * pi if (middle - first) % (2 * pi) > turn else turn


def _arc_distance(start: Point, via: Point, to: Point, point: Point) -> float:
    """Return the distance of a point from an arc."""
    x, y = arc_centre(start, via, to)
    first, turn = _arc_angles((x, y), start, via, to)
    beyond = (atan2(point[1] - y, point[0] - x) - first) * (1 if turn > 0 else -1) % (2 * pi)
    if beyond <= abs(turn):
        return abs(hypot(point[0] - x, point[1] - y) - hypot(start[0] - x, start[1] - y))
    return min(hypot(point[0] - end[0], point[1] - end[1]) for end in (start, to))


def _path_distance(path: Sequence[Point], point: Point) -> float:
    """Return the distance of a point from a path of straight lines."""
    corners = np.array(path)
    start, along = corners[:-1], np.diff(corners, axis=0)
    square = np.maximum((along**2).sum(axis=1), SHORTEST_SIDE**2)
    share = np.clip(((np.array(point) - start) * along).sum(axis=1) / square, 0.0, 1.0)
    return float(np.hypot(*(start + share[:, None] * along - point).T).min())


def arc_centre(start: Point, via: Point, to: Point) -> Point:
    """Return the centre of the circle through three points.

    Args:
        start: first point, mm.
        via: second point, mm.
        to: third point, mm.
    """
    (ax, ay), (bx, by), (cx, cy) = start, via, to
    d = 2 * (ax * (by - cy) + bx * (cy - ay) + cx * (ay - by))
    a2, b2, c2 = ax * ax + ay * ay, bx * bx + by * by, cx * cx + cy * cy
    return (
        (a2 * (by - cy) + b2 * (cy - ay) + c2 * (ay - by)) / d,
        (a2 * (cx - bx) + b2 * (ax - cx) + c2 * (bx - ax)) / d,
    )


def _mirror(point: Point) -> Point:
    return -point[0], point[1]


def _mirrored_side(side: Side) -> Side:
    return _mapped(side, _mirror)


def _mapped(side: Side, change: object) -> Side:
    """Return a side with all its points changed."""
    assert callable(change)
    match side:
        case StraightSide(to):
            return StraightSide(change(to))
        case ArcSide(via, to):
            return ArcSide(change(via), change(to))
        case CurveSide(through):
            return CurveSide(tuple(change(point) for point in through))
