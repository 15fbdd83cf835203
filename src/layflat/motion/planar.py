"""Planar arms of two joints: inverse kinematics in closed form, reach, and paths on which the tip follows curves.

| symbol | meaning | unit |
|---|---|---|
| q_1, q_2 | joint angles from the middle of each stroke | rad |
| e | angle of the elbow at q_2 = 0 | rad |
| l_1, l_2 | lengths of the links | m |
| D | distance of a point from the base | m |
| b | angle between the links, q_2 + e | rad |

Others as in kinematics.py. By the law of cosines cos b = (D^2 - l_1^2 - l_2^2) / (2 l_1 l_2): two elbows, mirrored at
the line from the base to the tip. On a curve the elbow stays on its side. From x' = l_1 t_1' n_1 + l_2 t_2' n_2 follow
t_1' = x' u_2 / (l_1 sin b) and t_2' = -x' u_1 / (l_2 sin b), and second derivatives likewise, from x'' less what comes
of the squares of the first. With a stretched or folded elbow, sin b = 0, the tip can't move along the arm.
"""

from collections.abc import Callable
from math import acos, atan2, cos, degrees, hypot, pi, radians, remainder, sin, tau
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from layflat.arrays import Array
from layflat.errors import InputError
from layflat.machine import Machine
from layflat.motion.curve import Curve, TipPath
from layflat.motion.kinematics import planar_links, tip_position, unit_vectors
from layflat.motion.path import PATH_SAMPLES, SAME_POINT_DISTANCE, CurveDerivatives, half_strokes

Angles = tuple[float, ...]  # one angle a joint, from base to tip, rad
END_MARGIN = radians(3.0)  # to the ends of a working stroke, rad: a joint may overshoot
AMPLE_MARGIN = radians(10.0)  # margin beyond which configurations count as equally safe, rad
COSINE_ROUNDING = 1e-12  # by which the cosine of a stretched elbow may be over 1, and an angle (rad) over its limit


class Configuration(NamedTuple):
    """Joint angles for a position of the tip, and their margin."""

    angles: Angles
    margin: float  # to the nearest end of any joint's working stroke, rad


class _Arc(NamedTuple):
    """Part of a circle: centre and radius (m), midpoint and half of the angle that it spans (rad)."""

    x: float
    y: float
    radius: float
    midpoint: float
    half: float

    def distance(self, x: float, y: float) -> float:
        """Return the distance of a point to the arc, m."""
        to_x, to_y = x - self.x, y - self.y
        if abs(remainder(atan2(to_y, to_x) - self.midpoint, tau)) <= self.half:
            return abs(hypot(to_x, to_y) - self.radius)
        ends = (self.midpoint - self.half, self.midpoint + self.half)
        return min(hypot(to_x - self.radius * cos(end), to_y - self.radius * sin(end)) for end in ends)


class PlanarReach:
    """Inverse kinematics of a planar arm of two joints, which keep a margin (rad) to the ends of their strokes."""

    def __init__(self, machine: Machine, margin: float = END_MARGIN) -> None:
        """Compute the border of the reach of a machine's arm."""
        self.machine = machine
        self.lengths = tuple(joint.planar_link.length for joint in machine.joints.values())
        self.limits = tuple(joint.stops.working_stroke / 2 - margin for joint in machine.joints.values())
        self._kept = margin
        self._arcs = self._boundary()

    def tip(self, angles: Angles) -> tuple[float, float]:
        """Return the tip's position, m, at angles, rad."""
        x, y = tip_position(self.machine, np.array(angles))
        return float(x), float(y)

    def axes(self, angles: Angles) -> list[tuple[float, float]]:
        """Return the positions (x, y) of both joints, the first at the origin, and of the tip, m, at angles, rad."""
        return [(0.0, 0.0), (self.lengths[0] * cos(angles[0]), self.lengths[0] * sin(angles[0])), self.tip(angles)]

    def configurations(self, x: float, y: float) -> tuple[Configuration, ...]:
        """Return the configurations with the tip at a point (m), widest margin first; none if it is out of reach.

        The reach is that of the strokes less the margin kept to their ends.
        """
        l_1, l_2 = self.lengths
        distance, towards = hypot(x, y), atan2(y, x)
        bend = (distance * distance - l_1 * l_1 - l_2 * l_2) / (2.0 * l_1 * l_2)
        if abs(bend) > 1.0 + COSINE_ROUNDING:
            return ()
        elbow = acos(min(max(bend, -1.0), 1.0))
        configurations = []
        for bent in {elbow, -elbow}:
            first = remainder(towards - atan2(l_2 * sin(bent), l_1 + l_2 * cos(bent)), tau)
            angles = (first, remainder(bent - self.machine.arm.elbow, tau))
            if all(abs(q) <= limit + COSINE_ROUNDING for q, limit in zip(angles, self.limits, strict=True)):
                margin = min(limit - abs(q) for q, limit in zip(angles, self.limits, strict=True)) + self._kept
                configurations.append(Configuration(angles, margin))
        return tuple(sorted(configurations, key=lambda configuration: -configuration.margin))

    def choose_configuration(self, x: float, y: float, travel_time: Callable[[Angles], float]) -> Configuration | None:
        """Return the best configuration with the tip at a point: by margin up to 10 deg, then by travel time.

        Args:
            x: coordinate x of the point, m.
            y: coordinate y of the point, m.
            travel_time: time of a motion to angles, s.

        Returns:
            None if the point is out of reach.
        """

        def rank(configuration: Configuration) -> tuple[float, float]:
            return -min(configuration.margin, AMPLE_MARGIN), travel_time(configuration.angles)

        return min(self.configurations(x, y), key=rank, default=None)

    def distance_outside(self, x: float, y: float) -> float:
        """Return the distance of a point from the reach, m; 0 within."""
        return 0.0 if self.configurations(x, y) else min(arc.distance(x, y) for arc in self._arcs)

    def _boundary(self) -> list[_Arc]:
        """Return arcs that contain the border of the reach: one joint at an end of its stroke, the other moving."""
        (l_1, l_2), (limit_1, limit_2), elbow = self.lengths, self.limits, self.machine.arm.elbow
        arcs = [_Arc(l_1 * cos(q), l_1 * sin(q), l_2, q + elbow, limit_2) for q in (-limit_1, limit_1)]
        # Stretched and folded elbows end the reach, too, where the stroke holds them.
        singular = [remainder(bent - elbow, tau) for bent in (0.0, pi)]
        for q in (-limit_2, limit_2, *(s for s in singular if abs(s) <= limit_2)):
            x, y = l_1 + l_2 * cos(q + elbow), l_2 * sin(q + elbow)
            arcs.append(_Arc(0.0, 0.0, hypot(x, y), atan2(y, x), limit_1))
        return arcs


MIN_ELBOW_SINE = 0.01  # sine of an elbow's angle below which it counts as stretched or folded
BORDER_BISECTIONS = 40  # of the interval in which the arm's reach ends


class PlanarPath(TipPath):
    """Joint path of a planar arm whose tip follows a curve."""

    def __init__(self, machine: Machine, curve: Curve, start: Array, where: str) -> None:
        """Follow a curve with the arm.

        Args:
            machine: machine with the arm.
            curve: curve of the tip.
            start: configuration (joints,), rad, with the tip at the beginning of the curve.
            where: source of the curve, for messages.

        Raises:
            InputError: naming `where`: the arm has a single joint, or its elbow is stretched.
            MachineError: the arm is not a planar one.
        """
        lengths, bends = planar_links(machine)
        if len(lengths) != 2:
            what, right = f"needs two joints, {machine.name} has one", "give angles, or another machine"
            raise InputError(what, where=where, right=right)
        bend = sin(float(start[1] + bends[1]))
        if abs(bend) < MIN_ELBOW_SINE:
            right = "move the joints first, or begin elsewhere"
            raise InputError("begins with a stretched or folded elbow", where=where, right=right)
        self.curve, self.length, self._where = curve, curve.length, where
        self._lengths, self._bends, self._side = lengths, bends, float(np.sign(bend))
        self._names, self._half = list(machine.joints), half_strokes(machine)

    def evaluate(self, s: Array) -> CurveDerivatives:
        """Return angles and their derivatives at distances (points,), m, at which the arm reaches the curve."""
        x, x_1, x_2 = self.curve.evaluate(s)
        q = self._angles(x, self._side)
        along, _ = unit_vectors(np.cumsum(q + self._bends, axis=1))
        # Rotation of link 1 per motion of the tip along link 2, and of link 2 per motion along link 1.
        others = along[:, ::-1] / (self._lengths * np.sin(q[:, 1:] + self._bends[1]) * [1.0, -1.0])[..., None]
        t_1 = np.einsum("pix,px->pi", others, x_1)
        inwards = np.einsum("pi,pix->px", self._lengths * t_1**2, along)
        t_2 = np.einsum("pix,px->pi", others, x_2 + inwards)
        return CurveDerivatives(q, np.diff(t_1, prepend=0.0), np.diff(t_2, prepend=0.0))

    def reaches(self, s: Array) -> NDArray[np.bool_]:
        """Return a mask, (points,), True where the arm reaches the curve at distances (points,), m.

        There it is within its strokes, with its elbow bent to the side of the start, neither stretched nor folded.
        """
        x = self.curve.evaluate(s).value
        within: NDArray[np.bool_] = np.all(
            np.abs(self._angles(x, self._side)) <= self._half + SAME_POINT_DISTANCE, axis=1
        )
        return within & (self._cosine(x) ** 2 <= 1.0 - MIN_ELBOW_SINE**2)

    def reach_limit(self, end: float) -> float | None:
        """Return the distance (m) at which the arm's reach ends between 0 and `end`; None if it reaches `end`."""
        s = np.linspace(0.0, end, PATH_SAMPLES)
        out = np.flatnonzero(~self.reaches(s))
        if len(out) == 0:
            return None
        inside, outside = float(s[max(out[0] - 1, 0)]), float(s[out[0]])
        for _ in range(BORDER_BISECTIONS):
            middle = (inside + outside) / 2
            inside, outside = (middle, outside) if self.reaches(np.array([middle]))[0] else (inside, middle)
        return inside

    def check_reachable(self) -> "PlanarPath":
        """Return the path itself; raise InputError with place and reason if the arm can't follow all of it."""
        end = self.reach_limit(self.length)
        if end is not None:
            (x, y), place = self.curve.evaluate(np.array([end])).value[0], f"{end:.3f} m along its {self.length:.3f} m"
            what = f"leaves the arm's reach {place}, at x = {1e3 * x:.0f} mm, y = {1e3 * y:.0f} mm"
            why, right = self._why(np.array([end + 2e-3 * self.length]))
            raise InputError(f"{what}, {why}", where=self._where, right=right)
        return self

    def _why(self, s: Array) -> tuple[str, str]:
        """Return the reason why the arm does not reach the curve at a distance, and the advice."""
        x = self.curve.evaluate(s).value
        if self._cosine(x)[0] ** 2 > 1.0 - MIN_ELBOW_SINE**2:
            return "where the elbow is stretched or folded", "give a path that bends it, or angles"
        joint = int(np.argmax(np.abs(self._angles(x, self._side)[0]) - self._half))
        why = f"where joint {self._names[joint]!r} leaves its stroke of +-{degrees(self._half[joint]):.6g} deg"
        if np.all(np.abs(self._angles(x, -self._side)) <= self._half):
            return f"{why}: only the other elbow gets there", "give a path that this elbow can follow, or angles"
        return why, "give a path within it"

    def _cosine(self, x: Array) -> Array:
        """Return the cosine of the angle between the links with the tip at points (points, 2), m."""
        l_1, l_2 = self._lengths
        cosine: Array = ((x**2).sum(axis=1) - l_1**2 - l_2**2) / (2.0 * l_1 * l_2)
        return cosine

    def _angles(self, x: Array, side: float) -> Array:
        """Return angles (points, 2), rad, with the tip at points (m), or as near as possible if out of reach."""
        l_1, l_2 = self._lengths
        bend = side * np.arccos(np.clip(self._cosine(x), -1.0, 1.0))
        first = np.arctan2(x[:, 1], x[:, 0]) - np.arctan2(l_2 * np.sin(bend), l_1 + l_2 * np.cos(bend))
        both = np.stack([first, bend - self._bends[1]], axis=1)
        return (both + np.pi) % (2.0 * np.pi) - np.pi
