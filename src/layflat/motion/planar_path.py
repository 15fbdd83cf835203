"""Curves in the plane, followed by an arm of two joints with its elbow on the side where it is.

| symbol | meaning | unit |
|---|---|---|
| b | angle between the links, q_2 + e | rad |

Others as in kinematics.py. The law of cosines gives b, with the sign of the elbow's side. From
x' = l_1 t_1' n_1 + l_2 t_2' n_2 follow t_1' = x' u_2 / (l_1 sin b) and t_2' = -x' u_1 / (l_2 sin b), and second
derivatives likewise, from x'' less what comes of the squares of the first. With a stretched or folded elbow, sin b = 0,
the tip can't move along the arm.
"""

from math import degrees, sin

import numpy as np
from numpy.typing import NDArray

from layflat.arrays import Array
from layflat.errors import InputError
from layflat.machine import Machine
from layflat.motion.curve import Curve, TipPath
from layflat.motion.kinematics import directions, links
from layflat.motion.path import CLOSE, LOOKS, Shape, half_strokes

STRAIGHT = 0.01  # sine of an elbow's angle below which it counts as stretched or folded
HALVINGS = 40  # of an interval, to find where the arm's reach ends


class PlanarPath(TipPath):
    """A curve of the tip as a path of the joints."""

    def __init__(self, machine: Machine, curve: Curve, start: Array, where: str) -> None:
        """Follow a curve from the posture `start` (joints,), rad, whose tip is where the curve begins.

        Raises:
            InputError: naming `where`: the arm has a single joint, or its elbow is stretched.
            MachineError: the arm is not a planar one.
        """
        lengths, bends = links(machine)
        if len(lengths) != 2:
            what, right = f"needs two joints, {machine.name} has one", "give angles, or another machine"
            raise InputError(what, where=where, right=right)
        bend = sin(float(start[1] + bends[1]))
        if abs(bend) < STRAIGHT:
            right = "move the joints first, or begin elsewhere"
            raise InputError("begins with a stretched or folded elbow", where=where, right=right)
        self.curve, self.length, self._where = curve, curve.length, where
        self._lengths, self._bends, self._side = lengths, bends, float(np.sign(bend))
        self._names, self._half = list(machine.joints), half_strokes(machine)

    def at(self, s: Array) -> Shape:
        """Return angles and their derivatives at distances (points,), m, at which the arm reaches the curve."""
        x, x_1, x_2 = self.curve.at(s)
        q = self._angles(x, self._side)
        along, _ = directions(np.cumsum(q + self._bends, axis=1))
        # What the tip's motion along link 2 asks of link 1, and that along link 1 of link 2.
        others = along[:, ::-1] / (self._lengths * np.sin(q[:, 1:] + self._bends[1]) * [1.0, -1.0])[..., None]
        t_1 = np.einsum("pix,px->pi", others, x_1)
        inwards = np.einsum("pi,pix->px", self._lengths * t_1**2, along)
        t_2 = np.einsum("pix,px->pi", others, x_2 + inwards)
        return Shape(q, np.diff(t_1, prepend=0.0), np.diff(t_2, prepend=0.0))

    def reaches(self, s: Array) -> NDArray[np.bool_]:
        """Return whether the arm reaches the curve at distances (points,), m, within its strokes."""
        x = self.curve.at(s).value
        within: NDArray[np.bool_] = np.all(np.abs(self._angles(x, self._side)) <= self._half + CLOSE, axis=1)
        return within & (self._cosine(x) ** 2 <= 1.0 - STRAIGHT**2)

    def border(self, end: float) -> float | None:
        """Return how far along the curve (m), on the way to `end`, the arm reaches; None if it is all of the way."""
        s = np.linspace(0.0, end, LOOKS)
        out = np.flatnonzero(~self.reaches(s))
        if len(out) == 0:
            return None
        inside, outside = float(s[max(out[0] - 1, 0)]), float(s[out[0]])
        for _ in range(HALVINGS):
            middle = (inside + outside) / 2
            inside, outside = (middle, outside) if self.reaches(np.array([middle]))[0] else (inside, middle)
        return inside

    def checked(self) -> "PlanarPath":
        """Return the path itself; raise InputError, saying where and why, if the arm can't follow all of it."""
        end = self.border(self.length)
        if end is not None:
            (x, y), place = self.curve.at(np.array([end])).value[0], f"{end:.3f} m along its {self.length:.3f} m"
            what = f"leaves the arm's reach {place}, at x = {1e3 * x:.0f} mm, y = {1e3 * y:.0f} mm"
            why, right = self._why(np.array([end + 2e-3 * self.length]))
            raise InputError(f"{what}, {why}", where=self._where, right=right)
        return self

    def _why(self, s: Array) -> tuple[str, str]:
        """Return why the arm does not reach the curve at a distance, and what would be right."""
        x = self.curve.at(s).value
        if self._cosine(x)[0] ** 2 > 1.0 - STRAIGHT**2:
            return "where the elbow is stretched or folded", "give a way that bends it, or angles"
        joint = int(np.argmax(np.abs(self._angles(x, self._side)[0]) - self._half))
        why = f"where joint {self._names[joint]!r} leaves its stroke of +-{degrees(self._half[joint]):.6g} deg"
        if np.all(np.abs(self._angles(x, -self._side)) <= self._half):
            return f"{why}: only the other elbow gets there", "give a way that this elbow can follow, or angles"
        return why, "give a way within it"

    def _cosine(self, x: Array) -> Array:
        """Return the cosine of the angle between the links that bring the tip to points (points, 2), m."""
        l_1, l_2 = self._lengths
        cosine: Array = ((x**2).sum(axis=1) - l_1**2 - l_2**2) / (2.0 * l_1 * l_2)
        return cosine

    def _angles(self, x: Array, side: float) -> Array:
        """Return angles (points, 2), rad, that bring the tip to points (m), or towards those out of reach."""
        l_1, l_2 = self._lengths
        bend = side * np.arccos(np.clip(self._cosine(x), -1.0, 1.0))
        first = np.arctan2(x[:, 1], x[:, 0]) - np.arctan2(l_2 * np.sin(bend), l_1 + l_2 * np.cos(bend))
        both = np.stack([first, bend - self._bends[1]], axis=1)
        return (both + np.pi) % (2.0 * np.pi) - np.pi
