"""Curves of the tip in the plane or in space, parametrized by arc length; and paths of an arm that follows them."""

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from math import atan2, hypot, tau
from typing import Self

import numpy as np

from layflat.arrays import Array
from layflat.errors import InputError
from layflat.motion.kinematics import unit_vectors
from layflat.motion.path import SAME_POINT_DISTANCE, CurveDerivatives, JointPath, fit_spline

Point = tuple[float, ...]  # x and y, in space z too, m
MIN_SAGITTA_RATIO = 1e-6  # sagitta over chord; three points with less count as collinear


class Curve(ABC):
    """Curve parametrized by the distance s (m) from its beginning along it."""

    length: float  # m

    @abstractmethod
    def evaluate(self, s: Array) -> CurveDerivatives:
        """Return points (points, axes), m, and their first and second derivatives by s, at distances (points,), m."""


@dataclass(frozen=True)
class LineCurve(Curve):
    """Straight line, defined beyond both of its ends too."""

    start: Point
    direction: Point  # unit vector
    length: float

    @classmethod
    def from_points(cls, start: Point, end: Point, where: str) -> "LineCurve":
        """Return the line between two points.

        Args:
            start: first point, m.
            end: last point, m.
            where: source of the points, for messages.

        Raises:
            InputError: naming `where`: the points are the same.
        """
        offset = [b - a for a, b in zip(start, end, strict=True)]
        length = hypot(*offset)
        if length < SAME_POINT_DISTANCE:
            raise InputError("ends where it begins", where=where, right="give another point")
        return cls(start, tuple(component / length for component in offset), length)

    def evaluate(self, s: Array) -> CurveDerivatives:
        """Return points (points, axes), m, and their derivatives by s, at distances (points,), m."""
        first = np.tile(self.direction, (len(s), 1))
        return CurveDerivatives(np.array(self.start) + s[:, None] * first, first, np.zeros_like(first))


@dataclass(frozen=True)
class ArcCurve(Curve):
    """Arc of a circle in the plane: centre and radius (m), start angle and swept angle (rad)."""

    centre: Point
    radius: float
    begin: float
    sweep: float  # counter-clockwise; negative for clockwise

    @classmethod
    def from_points(cls, start: Point, middle: Point, end: Point, where: str) -> Self:
        """Return the arc through three points of the plane.

        Args:
            start: first point, m.
            middle: point between, m.
            end: last point, m.
            where: source of the points, for messages.

        Raises:
            InputError: naming `where`: the points are collinear.
        """
        (a, b), (c, d) = np.subtract(middle, start), np.subtract(end, start)
        cross = 2.0 * (a * d - b * c)
        if abs(cross) <= MIN_SAGITTA_RATIO * max(a * a + b * b, c * c + d * d):
            right = "move the middle one off it, or give a straight line instead of an arc"
            raise InputError("has its three points on a straight line", where=where, right=right)
        # The centre is as far from the start as from the other two.
        to = (d * (a * a + b * b) - b * (c * c + d * d)) / cross, (a * (c * c + d * d) - c * (a * a + b * b)) / cross
        centre = float(start[0] + to[0]), float(start[1] + to[1])
        first, last = (atan2(p[1] - centre[1], p[0] - centre[0]) for p in (start, end))
        sweep = (last - first) % tau if cross > 0.0 else -((first - last) % tau)
        return cls(centre, hypot(*to), first, sweep)

    @cached_property
    def length(self) -> float:  # type: ignore[override]
        """Length of the arc, m."""
        return self.radius * abs(self.sweep)

    def evaluate(self, s: Array) -> CurveDerivatives:
        """Return points (points, axes), m, and their derivatives by s, at distances (points,), m."""
        sign = np.sign(self.sweep)
        out, across = unit_vectors(self.begin + sign * s / self.radius)
        return CurveDerivatives(np.array(self.centre) + self.radius * out, sign * across, -out / self.radius)


@dataclass(frozen=True)
class TiltedCurve(Curve):
    """Planar curve in a plane anywhere in space."""

    curve: Curve
    origin: Array  # of the plane, (3,), m
    axes: Array  # of the plane, (2, 3): orthonormal

    @property
    def length(self) -> float:  # type: ignore[override]
        """Length of the curve, m."""
        return self.curve.length

    def evaluate(self, s: Array) -> CurveDerivatives:
        """Return points (points, axes), m, and their derivatives by s, at distances (points,), m."""
        value, first, second = self.curve.evaluate(s)
        return CurveDerivatives(self.origin + value @ self.axes, first @ self.axes, second @ self.axes)


def arc_through(start: Point, middle: Point, end: Point, where: str) -> Curve:
    """Return the arc through three points: an `ArcCurve` in the plane, a `TiltedCurve` in space.

    Args:
        start: first point, m.
        middle: point between, m.
        end: last point, m.
        where: source of the points, for messages.

    Raises:
        InputError: naming `where`: the points are collinear.
    """
    if len(start) == 2:
        return ArcCurve.from_points(start, middle, end, where)
    origin, (via, to) = np.array(start), np.subtract([middle, end], start)
    along = via / max(float(np.linalg.norm(via)), SAME_POINT_DISTANCE)
    across = to - (to @ along) * along
    axes = np.stack([along, across / max(float(np.linalg.norm(across)), SAME_POINT_DISTANCE)])
    flat = ArcCurve.from_points((0.0, 0.0), tuple(axes @ via), tuple(axes @ to), where)
    return TiltedCurve(flat, origin, axes)


class SplineCurve(Curve):
    """Natural cubic spline through points."""

    def __init__(self, points: Sequence[Point], where: str) -> None:
        """Fit a spline to points (m); raise InputError, naming `where`, if two in a row are the same."""
        self._spline = fit_spline(np.array(points), where)
        self.length = float(self._spline.x[-1])

    def evaluate(self, s: Array) -> CurveDerivatives:
        """Return points (points, axes), m, and their derivatives by s, at distances (points,), m."""
        return CurveDerivatives(self._spline(s), self._spline(s, 1), self._spline(s, 2))


class TipPath(JointPath):
    """Joint path on which the tip follows a curve; its distances are those along the curve."""

    curve: Curve

    @abstractmethod
    def reach_limit(self, end: float) -> float | None:
        """Return the distance (m) at which the arm's reach ends between 0 and `end`; None if it reaches `end`."""

    @abstractmethod
    def check_reachable(self) -> Self:
        """Return the path itself; raise InputError with place and reason if the arm can't follow all of it."""
