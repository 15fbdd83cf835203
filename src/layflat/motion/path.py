"""Paths of an arm through joint space, without time.

| symbol | meaning | unit |
|---|---|---|
| s | distance along a path, 0 to its length | m of the tip, or rad in joint space |
| q(s) | angles | rad |

A straight path in joint space has the Euclidean length of its angles. The length of a spline, in joint space or of the
tip, is the sum of the distances between its points, which is close to its arc length.
"""

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from math import degrees
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from layflat.arrays import Array
from layflat.errors import InputError
from layflat.machine import Machine

if TYPE_CHECKING:
    from scipy.interpolate import CubicSpline

__all__ = ["JointLine", "half_strokes"]

PATH_SAMPLES = 401  # points at which a path is checked
SAME_POINT_DISTANCE = 1e-9  # points that are closer count as one, m or rad; tolerance of strokes too, rad


class CurveDerivatives(NamedTuple):
    """Values along a curve and their first and second derivatives by s, (points, values) each."""

    value: Array
    first: Array
    second: Array


class JointPath(ABC):
    """Path through joint space, twice continuously differentiable."""

    length: float  # m or rad

    @abstractmethod
    def evaluate(self, s: Array) -> CurveDerivatives:
        """Return angles (points, joints), rad, and their derivatives at distances (points,) from the beginning."""

    @cached_property
    def end(self) -> Array:
        """Angles at the end, (joints,), rad."""
        angles: Array = self.evaluate(np.array([self.length])).value[0]
        return angles


@dataclass(frozen=True)
class JointLine(JointPath):
    """Straight path between two configurations (joints,), rad."""

    start: Array
    goal: Array

    @cached_property
    def length(self) -> float:  # type: ignore[override]
        """Length in joint space, rad."""
        return float(np.linalg.norm(self.goal - self.start))

    def evaluate(self, s: Array) -> CurveDerivatives:
        """Return angles (points, joints), rad, and their derivatives by s, at distances (points,), rad."""
        direction = (self.goal - self.start) / max(self.length, SAME_POINT_DISTANCE)
        first = np.tile(direction, (len(s), 1))
        return CurveDerivatives(self.start + s[:, None] * direction, first, np.zeros_like(first))


class JointSpline(JointPath):
    """Natural cubic spline through configurations."""

    def __init__(self, machine: Machine, configurations: Sequence[Array], where: str = "via") -> None:
        """Fit a spline to configurations.

        Args:
            machine: machine whose strokes are checked.
            configurations: angles (joints,), rad, each.
            where: source of the configurations, for messages.

        Raises:
            InputError: naming `where`: two in a row are the same, or the path between them leaves a working stroke.
        """
        self._spline = fit_spline(np.array(configurations), where)
        self.length = float(self._spline.x[-1])
        s = np.linspace(0.0, self.length, PATH_SAMPLES)
        angles, half = self._spline(s), half_strokes(machine)
        outside = np.argwhere(np.abs(angles) > half + SAME_POINT_DISTANCE)
        if len(outside):
            point, joint = outside[0]
            raise InputError(
                f"leaves the working stroke {degrees(s[point]):.1f} deg along its {degrees(self.length):.1f} deg, "
                f"with joint {list(machine.joints)[joint]!r} at {degrees(angles[point, joint]):.1f} deg",
                where=where,
                right=f"stay within +-{degrees(half[joint]):.6g} deg: give points with less of a turn between them",
            )

    def evaluate(self, s: Array) -> CurveDerivatives:
        """Return angles (points, joints), rad, and their derivatives by s, at distances (points,), rad."""
        return CurveDerivatives(self._spline(s), self._spline(s, 1), self._spline(s, 2))


def half_strokes(machine: Machine) -> Array:
    """Return the greatest angle of each joint, half its working stroke, (joints,), rad."""
    return np.array([joint.stops.working_stroke / 2 for joint in machine.joints.values()])


def fit_spline(points: Array, where: str) -> "CubicSpline":
    """Return a natural cubic spline through points (points, values), over the cumulated distances between them.

    Raises:
        InputError: naming `where`: two points that follow each other are the same.
    """
    from scipy.interpolate import CubicSpline  # noqa: PLC0415  # takes long to import

    # Not over its arc length: a spline that reverses would have a corner there.
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    if steps.min() < SAME_POINT_DISTANCE:
        raise InputError("gives the same point twice in a row", where=where, right="give points that differ")
    return CubicSpline(np.append(0.0, np.cumsum(steps)), points, bc_type="natural")
