"""Where the tip of an arm of two joints can go, and with which angles.

| symbol | meaning | unit |
|---|---|---|
| q_1, q_2 | joint angles from the middle of each stroke | rad |
| e | angle of the elbow at q_2 = 0 | rad |
| l_1, l_2 | lengths of the links | m |
| D | distance of a point from the base | m |

By the law of cosines cos(q_2 + e) = (D^2 - l_1^2 - l_2^2) / (2 l_1 l_2): two elbows, mirrored at the line from the base
to the tip.
"""

from collections.abc import Callable
from math import acos, atan2, cos, hypot, pi, radians, remainder, sin, tau
from typing import NamedTuple

import numpy as np

from layflat.machine import Machine
from layflat.motion.kinematics import tip_position

Angles = tuple[float, ...]  # one angle a joint, from base to tip, rad
END_MARGIN = radians(3.0)  # that is kept to the ends of a working stroke, rad: a joint may overshoot
AMPLE_MARGIN = radians(10.0)  # a posture that keeps so much from the ends is as good as any other, rad
ROUNDING = 1e-12  # by which the cosine of a stretched elbow may be over 1, and an angle (rad) over its limit


class Posture(NamedTuple):
    """Angles that bring the tip to a point."""

    angles: Angles
    margin: float  # from the nearest end of any joint's working stroke, rad


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


class Reach:
    """Inverse kinematics of a planar arm of two joints, which keep a margin (rad) to the ends of their strokes."""

    def __init__(self, machine: Machine, margin: float = END_MARGIN) -> None:
        self.machine = machine
        self.lengths = tuple(joint.planar_link.length for joint in machine.joints.values())
        self.limits = tuple(joint.stops.working_stroke / 2 - margin for joint in machine.joints.values())
        self._kept = margin
        self._arcs = self._boundary()

    def tip(self, angles: Angles) -> tuple[float, float]:
        """Return where the tip is, m."""
        x, y = tip_position(self.machine, np.array(angles))
        return float(x), float(y)

    def axes(self, angles: Angles) -> list[tuple[float, float]]:
        """Return where the joints' axes and the tip are, m, from the base on."""
        return [(0.0, 0.0), (self.lengths[0] * cos(angles[0]), self.lengths[0] * sin(angles[0])), self.tip(angles)]

    def postures(self, x: float, y: float) -> tuple[Posture, ...]:
        """Return the postures that bring the tip to a point (m), widest margin first; none if out of reach."""
        l_1, l_2 = self.lengths
        distance, towards = hypot(x, y), atan2(y, x)
        bend = (distance * distance - l_1 * l_1 - l_2 * l_2) / (2.0 * l_1 * l_2)
        if abs(bend) > 1.0 + ROUNDING:
            return ()
        elbow = acos(min(max(bend, -1.0), 1.0))
        found = []
        for bent in {elbow, -elbow}:
            first = remainder(towards - atan2(l_2 * sin(bent), l_1 + l_2 * cos(bent)), tau)
            angles = (first, remainder(bent - self.machine.arm.elbow, tau))
            if all(abs(q) <= limit + ROUNDING for q, limit in zip(angles, self.limits, strict=True)):
                margin = min(limit - abs(q) for q, limit in zip(angles, self.limits, strict=True)) + self._kept
                found.append(Posture(angles, margin))
        return tuple(sorted(found, key=lambda posture: -posture.margin))

    def choose(self, x: float, y: float, travel_time: Callable[[Angles], float]) -> Posture | None:
        """Return the posture to take over a point (m), if any: with ample margin if there is one, then the soonest."""

        def worth(posture: Posture) -> tuple[float, float]:
            return -min(posture.margin, AMPLE_MARGIN), travel_time(posture.angles)

        return min(self.postures(x, y), key=worth, default=None)

    def missing(self, x: float, y: float) -> float:
        """Return how far a point lies out of reach, m; 0 within."""
        return 0.0 if self.postures(x, y) else min(arc.distance(x, y) for arc in self._arcs)

    def _boundary(self) -> list[_Arc]:
        """Return arcs that hold every point of the edge of the reach: one joint at an end, the other sweeps."""
        (l_1, l_2), (limit_1, limit_2), elbow = self.lengths, self.limits, self.machine.arm.elbow
        arcs = [_Arc(l_1 * cos(q), l_1 * sin(q), l_2, q + elbow, limit_2) for q in (-limit_1, limit_1)]
        # Stretched and folded elbows end the reach, too, where the stroke holds them.
        singular = [remainder(bent - elbow, tau) for bent in (0.0, pi)]
        for q in (-limit_2, limit_2, *(s for s in singular if abs(s) <= limit_2)):
            x, y = l_1 + l_2 * cos(q + elbow), l_2 * sin(q + elbow)
            arcs.append(_Arc(0.0, 0.0, hypot(x, y), atan2(y, x), limit_1))
        return arcs
