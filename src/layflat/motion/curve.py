"""Curves of the tip in the plane, by the distance along them."""

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from math import atan2, hypot, tau

import numpy as np

from layflat.arrays import Array
from layflat.errors import InputError
from layflat.motion.kinematics import directions
from layflat.motion.path import CLOSE, Shape, smooth

Point = tuple[float, float]  # m
FLATTEST = 1e-6  # sagitta over chord below which three points do not make a circle


class Curve(ABC):
    """A curve in the plane, by the distance s (m) from its beginning along it."""

    length: float  # m

    @abstractmethod
    def at(self, s: Array) -> Shape:
        """Return points (points, 2), m, and their derivatives at distances (points,), m."""


@dataclass(frozen=True)
class Line(Curve):
    """A straight line, which goes on beyond both of its ends."""

    start: Point
    way: Point  # its direction, of length 1
    length: float

    @classmethod
    def to(cls, start: Point, end: Point, where: str) -> "Line":
        """Return the line between two points; raise InputError, naming `where`, if they are the same."""
        x, y = end[0] - start[0], end[1] - start[1]
        length = hypot(x, y)
        if length < CLOSE:
            raise InputError("ends where it begins", where=where, right="give another point")
        return cls(start, (x / length, y / length), length)

    def at(self, s: Array) -> Shape:
        """Return points and their derivatives."""
        first = np.tile(self.way, (len(s), 1))
        return Shape(np.array(self.start) + s[:, None] * first, first, np.zeros_like(first))


@dataclass(frozen=True)
class Arc(Curve):
    """Part of a circle: centre and radius (m), where it begins (rad), and how far it goes (rad)."""

    centre: Point
    radius: float
    begin: float
    sweep: float  # counter-clockwise; negative for clockwise

    @classmethod
    def through(cls, start: Point, middle: Point, end: Point, where: str) -> "Arc":
        """Return the arc through three points; raise InputError, naming `where`, if they lie on a line."""
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


class Spline(Curve):
    """A smooth curve through points."""

    def __init__(self, points: Sequence[Point], where: str) -> None:
        """Lay a spline through points; raise InputError, naming `where`, if two in a row are the same."""
        self._spline = smooth(np.array(points), where)
        self.length = float(self._spline.x[-1])

    def at(self, s: Array) -> Shape:
        """Return points and their derivatives."""
        return Shape(self._spline(s), self._spline(s, 1), self._spline(s, 2))
