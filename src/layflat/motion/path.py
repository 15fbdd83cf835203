"""Ways of an arm through its joints' angles, without time.

| symbol | meaning | unit |
|---|---|---|
| s | how far along a path, 0 to its length | m of the tip, or rad in joint space |
| q(s) | angles | rad |

A straight path in joint space has the Euclidean length of its angles. That of a spline, here and of the tip, is the sum
of the distances between its points, which is nearly its own.
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

LOOKS = 401  # points at which a path is checked
CLOSE = 1e-9  # points that are closer, m or rad, are the same; an angle (rad) may be so much beyond its stroke


class Shape(NamedTuple):
    """Values along a curve and their first and second derivatives by s, (points, values) each."""

    value: Array
    first: Array
    second: Array


class Path(ABC):
    """A way through joint space, twice continuously differentiable."""

    length: float  # m or rad

    @abstractmethod
    def at(self, s: Array) -> Shape:
        """Return angles (points, joints), rad, and their derivatives at distances (points,) from the beginning."""

    @cached_property
    def end(self) -> Array:
        """Angles at the end, (joints,), rad."""
        angles: Array = self.at(np.array([self.length])).value[0]
        return angles


@dataclass(frozen=True)
class JointLine(Path):
    """The straight way between two postures (joints,), rad."""

    start: Array
    goal: Array

    @cached_property
    def length(self) -> float:  # type: ignore[override]
        """Of the way in joint space, rad."""
        return float(np.linalg.norm(self.goal - self.start))

    def at(self, s: Array) -> Shape:
        """Return angles and their derivatives."""
        way = (self.goal - self.start) / max(self.length, CLOSE)
        first = np.tile(way, (len(s), 1))
        return Shape(self.start + s[:, None] * way, first, np.zeros_like(first))


class JointSpline(Path):
    """A smooth way through postures."""

    def __init__(self, machine: Machine, postures: Sequence[Array], where: str = "via") -> None:
        """Lay a spline through postures (joints,), rad.

        Raises:
            InputError: naming `where`: two of them are the same, or the way between them leaves a working stroke.
        """
        self._spline = smooth(np.array(postures), where)
        self.length = float(self._spline.x[-1])
        s = np.linspace(0.0, self.length, LOOKS)
        angles, half = self._spline(s), half_strokes(machine)
        outside = np.argwhere(np.abs(angles) > half + CLOSE)
        if len(outside):
            point, joint = outside[0]
            raise InputError(
                f"leaves the working stroke {degrees(s[point]):.1f} deg along its {degrees(self.length):.1f} deg, "
                f"with joint {list(machine.joints)[joint]!r} at {degrees(angles[point, joint]):.1f} deg",
                where=where,
                right=f"stay within +-{degrees(half[joint]):.6g} deg: give points with less of a turn between them",
            )

    def at(self, s: Array) -> Shape:
        """Return angles and their derivatives."""
        return Shape(self._spline(s), self._spline(s, 1), self._spline(s, 2))


def half_strokes(machine: Machine) -> Array:
    """Return the greatest angle of each joint, (joints,), rad."""
    return np.array([joint.stops.working_stroke / 2 for joint in machine.joints.values()])


def smooth(points: Array, where: str) -> "CubicSpline":
    """Lay a natural cubic spline through points (points, values), over the distances between them added up.

    Raises:
        InputError: naming `where`: two points that follow each other are the same.
    """
    from scipy.interpolate import CubicSpline  # noqa: PLC0415  # takes long to import

    # Not over its own length: where it turns back on itself, it would have a corner there.
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    if steps.min() < CLOSE:
        raise InputError("gives the same point twice in a row", where=where, right="give points that differ")
    return CubicSpline(np.append(0.0, np.cumsum(steps)), points, bc_type="natural")
