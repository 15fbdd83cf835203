"""Curves of the tip, in the plane or in space, by the distance along them; and paths on which an arm follows them."""

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from math import atan2, hypot, tau
from typing import Self

import numpy as np

from layflat.arrays import Array
from layflat.errors import InputError
from layflat.motion.kinematics import directions
from layflat.motion.path import CLOSE, Path, Shape, smooth

Point = tuple[float, ...]  # x and y, in space z too, m
FLATTEST = 1e-6  # sagitta over chord below which three points do not make a circle


class Curve(ABC):
    """A curve, by the distance s (m) from its beginning along it."""

    length: float  # m

    @abstractmethod
    def at(self, s: Array) -> Shape:
        """Return points (points, axes), m, and their derivatives at distances (points,), m."""


@dataclass(frozen=True)
class Line(Curve):
    """A straight line, which goes on beyond both of its ends."""

    start: Point
    way: Point  # its direction, of length 1
    length: float

    @classmethod
    def to(cls, start: Point, end: Point, where: str) -> "Line":
        """Return the line between two points; raise InputError, naming `where`, if they are the same."""
        way = [b - a for a, b in zip(start, end, strict=True)]
        length = hypot(*way)
        if length < CLOSE:
            raise InputError("ends where it begins", where=where, right="give another point")
        return cls(start, tuple(of / length for of in way), length)

    def at(self, s: Array) -> Shape:
        """Return points and their derivatives."""
        first = np.tile(self.way, (len(s), 1))
        return Shape(np.array(self.start) + s[:, None] * first, first, np.zeros_like(first))


@dataclass(frozen=True)
class Arc(Curve):
    """Part of a circle in the plane: centre and radius (m), where it begins (rad), and how far it goes (rad)."""

    centre: Point
    radius: float
    begin: float
    sweep: float  # counter-clockwise; negative for clockwise

    @classmethod
    def through(cls, start: Point, middle: Point, end: Point, where: str) -> Self:
        """Return the arc through three points of the plane; raise InputError, naming `where`, if they lie on a line."""
        (a, b), (c, d) = np.subtract(middle, start), np.subtract(end, start)
        cross = 2.0 * (a * d - b * c)
        if abs(cross) <= FLATTEST * max(a * a + b * b, c * c + d * d):
            raise InputError("has three points on a line", where=where, right="give a point beside it, or a line")
        # The centre is as far from the start as from the other two.
        to = (d * (a * a + b * b) - b * (c * c + d * d)) / cross, (a * (c * c + d * d) - c * (a * a + b * b)) / cross
        centre = float(start[0] + to[0]), float(start[1] + to[1])
        first, last = (atan2(p[1] - centre[1], p[0] - centre[0]) for p in (start, end))
        sweep = (last - first) % tau if cross > 0.0 else -((first - last) % tau)
        return cls(centre, hypot(*to), first, sweep)

    @cached_property
    def length(self) -> float:  # type: ignore[override]
        """Of the arc, m."""
        return self.radius * abs(self.sweep)

    def at(self, s: Array) -> Shape:
        """Return points and their derivatives."""
        way = np.sign(self.sweep)
        out, across = directions(self.begin + way * s / self.radius)
        return Shape(np.array(self.centre) + self.radius * out, way * across, -out / self.radius)


@dataclass(frozen=True)
class Tilted(Curve):
    """A curve of a plane that lies anywhere in space."""

    curve: Curve
    origin: Array  # of the plane, (3,), m
    axes: Array  # of the plane, (2, 3): at right angles to each other, of length 1

    @property
    def length(self) -> float:  # type: ignore[override]
        """Of the curve, m."""
        return self.curve.length

    def at(self, s: Array) -> Shape:
        """Return points and their derivatives."""
        value, first, second = self.curve.at(s)
        return Shape(self.origin + value @ self.axes, first @ self.axes, second @ self.axes)


def arc(start: Point, middle: Point, end: Point, where: str) -> Curve:
    """Return the arc through three points of the plane or of space; raise as `Arc.through`."""
    if len(start) == 2:
        return Arc.through(start, middle, end, where)
    origin, (via, to) = np.array(start), np.subtract([middle, end], start)
    along = via / max(float(np.linalg.norm(via)), CLOSE)
    aside = to - (to @ along) * along
    axes = np.stack([along, aside / max(float(np.linalg.norm(aside)), CLOSE)])
    flat = Arc.through((0.0, 0.0), tuple(axes @ via), tuple(axes @ to), where)
    return Tilted(flat, origin, axes)


class Spline(Curve):
    """A smooth curve through points."""

    def __init__(self, points: Sequence[Point], where: str) -> None:
        """Lay a spline through points; raise InputError, naming `where`, if two in a row are the same."""
        self._spline = smooth(np.array(points), where)
        self.length = float(self._spline.x[-1])

    def at(self, s: Array) -> Shape:
        """Return points and their derivatives."""
        return Shape(self._spline(s), self._spline(s, 1), self._spline(s, 2))


class TipPath(Path):
    """A way of the joints on which the tip follows a curve; its distances are those along the curve."""

    curve: Curve

    @abstractmethod
    def border(self, end: float) -> float | None:
        """Return how far along the curve (m), on the way to `end`, the arm reaches; None if it is all of the way."""

    @abstractmethod
    def checked(self) -> Self:
        """Return the path itself; raise InputError, saying where and why, if the arm can't follow all of it."""
