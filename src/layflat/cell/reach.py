"""Where the arm's tip can go, and with which angles of its joints.

| symbol | meaning | unit |
|---|---|---|
| q_1, q_2 | joint angles from the middle of each stroke | rad |
| e | angle of the elbow at q_2 = 0 | rad |
| l_1, l_2 | lengths of the links | m |
| D | distance of a point from the base | m |

By the law of cosines cos(q_2 + e) = (D^2 - l_1^2 - l_2^2) / (2 l_1 l_2): two elbows, mirrored at the line from the base
to the tip.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import acos, atan2, cos, hypot, pi, radians, remainder, sin, tau

import numpy as np

from layflat.machine import Machine
from layflat.sim.kinematics import tip_position

Angles = tuple[float, ...]
"""One angle a joint, from base to tip, rad."""

SMALL_ERROR = radians(0.1)
"""For which a posture's sensitivity is given, rad: how exactly the paper's joints come back to a place."""

END_MARGIN = radians(3.0)
"""That is kept to the ends of a working stroke, rad: a joint may overshoot."""

AMPLE_MARGIN = radians(10.0)
"""A posture that keeps so much from the ends is as good as any other, rad."""

ROUNDING = 1e-12
"""By which the cosine of a stretched elbow may be over 1."""

ON_ARC = 1e-3
"""How far from its circle a point may be that an arm with one joint is sent to, m."""


@dataclass(frozen=True)
class Posture:
    """Angles that bring the tip to a point.

    Args:
        angles: rad, from base to tip.
        margin: from the nearest end of any joint's working stroke, rad.
        sensitivity: greatest way of the tip if every joint is off by `SMALL_ERROR`, m. Both elbows have the same: it
            distinguishes places, not elbows.
    """

    angles: Angles
    margin: float
    sensitivity: float


@dataclass(frozen=True)
class _Arc:
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
    """Inverse kinematics of a machine's planar arm.

    Args:
        machine: with one joint or two.
        margin: kept to the ends of the working strokes, rad.
    """

    def __init__(self, machine: Machine, margin: float = END_MARGIN) -> None:
        self.machine = machine
        self.lengths = tuple(joint.link.length for joint in machine.joints.values())
        self.limits = tuple(joint.stops.working_stroke / 2 - margin for joint in machine.joints.values())
        self._kept = margin
        self._arcs = self._boundary()

    def tip(self, angles: Angles) -> tuple[float, float]:
        """Return where the tip is, m."""
        x, y = tip_position(self.machine, np.array(angles))
        return float(x), float(y)

    def axes(self, angles: Angles) -> list[tuple[float, float]]:
        """Return where the joints' axes and the tip are, m, from the base on."""
        first = (self.lengths[0] * cos(angles[0]), self.lengths[0] * sin(angles[0]))
        return [*[(0.0, 0.0), first][: len(angles)], self.tip(angles)]

    def postures(self, x: float, y: float) -> tuple[Posture, ...]:
        """Return the postures that bring the tip to a point (m), widest margin first; none if out of reach."""
        found = [self._posture(angles) for angles in self._solutions(x, y) if self._inside(angles)]
        return tuple(sorted(found, key=lambda posture: -posture.margin))

    def choose(self, x: float, y: float, travel_time: Callable[[Angles], float]) -> Posture | None:
        """Return the posture to take: with ample margin if there is one, then the one that is reached soonest.

        Args:
            x: of the point, m.
            y: as x.
            travel_time: from where the arm is to a posture's angles, s.
        """

        def worth(posture: Posture) -> tuple[float, float]:
            return -min(posture.margin, AMPLE_MARGIN), travel_time(posture.angles)

        return min(self.postures(x, y), key=worth, default=None)

    def missing(self, x: float, y: float) -> float:
        """Return how far a point lies out of reach, m; 0 within."""
        return 0.0 if self.postures(x, y) else min(arc.distance(x, y) for arc in self._arcs)

    def _inside(self, angles: Angles) -> bool:
        return all(abs(q) <= limit + 1e-12 for q, limit in zip(angles, self.limits, strict=True))

    def _solutions(self, x: float, y: float) -> list[Angles]:
        distance, towards = hypot(x, y), atan2(y, x)
        if len(self.lengths) == 1:
            return [(towards,)] if abs(distance - self.lengths[0]) <= ON_ARC else []
        l_1, l_2 = self.lengths
        bend = (distance * distance - l_1 * l_1 - l_2 * l_2) / (2.0 * l_1 * l_2)
        if abs(bend) > 1.0 + ROUNDING:
            return []
        bend = min(max(bend, -1.0), 1.0)
        elbows = {acos(bend), -acos(bend)}
        first = [remainder(towards - atan2(l_2 * sin(bent), l_1 + l_2 * cos(bent)), tau) for bent in elbows]
        return [(q, remainder(bent - self.machine.arm.elbow, tau)) for q, bent in zip(first, elbows, strict=True)]

    def _posture(self, angles: Angles) -> Posture:
        margin = min(limit - abs(q) for q, limit in zip(angles, self.limits, strict=True)) + self._kept
        x, y = self.tip(angles)
        # A joint that turns moves the tip about its own axis.
        levers = [(-y, x)]
        if len(angles) == 2:
            levers.append((self.lengths[0] * sin(angles[0]) - y, x - self.lengths[0] * cos(angles[0])))
        ways = [hypot(sum(s * dx for s, (dx, _) in zip(signs, levers, strict=False)),
                      sum(s * dy for s, (_, dy) in zip(signs, levers, strict=False)))
                for signs in ((1.0, 1.0), (1.0, -1.0))]  # fmt: skip
        return Posture(angles, margin, SMALL_ERROR * max(ways))

    def _boundary(self) -> list[_Arc]:
        """Return arcs that hold every point of the edge of the reach: one joint at an end, the other sweeps."""
        if len(self.lengths) == 1:
            return [_Arc(0.0, 0.0, self.lengths[0], 0.0, self.limits[0])]
        (l_1, l_2), (limit_1, limit_2), elbow = self.lengths, self.limits, self.machine.arm.elbow
        arcs = [
            _Arc(l_1 * cos(q), l_1 * sin(q), l_2, q + elbow, limit_2) for q in (-limit_1, limit_1)
        ]  # fmt: skip
        # Stretched and folded elbows end the reach, too, where the stroke holds them.
        singular = [remainder(bent - elbow, tau) for bent in (0.0, pi)]
        for q in (-limit_2, limit_2, *(s for s in singular if abs(s) <= limit_2)):
            x, y = l_1 + l_2 * cos(q + elbow), l_2 * sin(q + elbow)
            arcs.append(_Arc(0.0, 0.0, hypot(x, y), atan2(y, x), limit_1))
        return arcs
