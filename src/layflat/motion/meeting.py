"""Meeting what moves past: the soonest time at which an arm can be where a point is, with its velocity.

| symbol | meaning | unit |
|---|---|---|
| s | how far the point is along its line | m |
| T | time until arm and point meet | s |

The quickest motion from the arm's state into that of the point at T takes a time of its own; they meet at the first T
that is not shorter. Motions between moving states: `travel.transfer`.
"""

from dataclasses import dataclass
from functools import cached_property
from math import cos, inf, sin

import numpy as np

from layflat.arrays import Array
from layflat.machine import Machine
from layflat.motion.curve import Line
from layflat.motion.limits import MotionLimits
from layflat.motion.planar_path import PlanarPath
from layflat.motion.reach import Reach
from layflat.motion.trajectory import States
from layflat.motion.travel import Travel, tip_peaks, transfer

GRID = 2e-3  # of the places that are tried along a line, m
STEP = 0.02  # of the times that are tried, s
LONGEST = 3.0  # until a meeting, s
BRAKING = 2.0  # deceleration with which an arm that stops at the end of its reach comes to rest, m/s2
ATTEMPTS = 4  # at a motion in which the tip keeps its speed


class Lane:
    """A straight line of the tip, and the part of it that an arm reaches with one elbow, from `low` to `high`, m."""

    def __init__(self, reach: Reach, start: tuple[float, float], direction: float, length: float) -> None:
        """Take a line from a point (m) in a direction (rad), with its length (m).

        Where the arm reaches nothing of it, `path` is None; where it does so with both elbows, the first that it finds
        is taken.
        """
        way = (cos(direction), sin(direction))
        s = np.arange(0.0, length, GRID)
        points = np.array(start) + s[:, None] * way
        found = next((found for x, y in points.tolist() if (found := reach.postures(x, y))), None)
        self.path: PlanarPath | None = None
        self.low = self.high = 0.0
        if found is not None:
            line = Line(start, way, length)
            self.path = PlanarPath(reach.machine, line, np.array(found[0].angles), "line")
            within = self.path.reaches(s)
            within[within] = (np.abs(self.path.at(s[within]).value) <= reach.limits).all(axis=1)
            first = int(np.argmax(within))
            last = first + int(np.argmin(np.append(within[first:], False)))
            self.low, self.high = float(s[first]), float(s[max(last - 1, first)])


@dataclass(frozen=True)
class Course:
    """A point that goes along a lane at a constant speed."""

    lane: Lane  # of which the arm reaches something
    along: float  # where it is at a time, m
    since: float  # that time, s
    speed: float  # m/s, negative for back

    def place(self, time: float) -> float:
        """Return how far along its lane the point is at a time (s), m."""
        return self.along + self.speed * (time - self.since)

    def states(self, times: Array) -> States:
        """Return what the joints do at times (instants,), s, at which the arm reaches the point."""
        assert self.lane.path is not None
        q, first, second = self.lane.path.at(self.along + self.speed * (times - self.since))
        return States(q, first * self.speed, second * self.speed**2)

    def state(self, time: float) -> States:
        """Return what the joints do at one time (s), (joints,) each."""
        return States(*(of[0] for of in self.states(np.array([time]))))

    @cached_property
    def enters(self) -> float:
        """When the point comes within reach, s."""
        return self._passes(self.lane.low if self.speed > 0.0 else self.lane.high, outwards=False)

    @cached_property
    def leaves(self) -> float:
        """When an arm that follows has to brake to stop at the end of its reach, s."""
        stopping = self.speed * abs(self.speed) / (2.0 * BRAKING)
        return self._passes(self.end - stopping, outwards=True)

    @property
    def end(self) -> float:
        """Where along the lane the reach ends for the point, m."""
        return self.lane.high if self.speed > 0.0 else self.lane.low

    @property
    def stop(self) -> Array:
        """Angles (joints,), rad, at the end of the reach."""
        assert self.lane.path is not None
        angles: Array = self.lane.path.at(np.array([self.end])).value[0]
        return angles

    def _passes(self, border: float, *, outwards: bool) -> float:
        """Return when the point passes a place on its lane (m); a point at rest has or will at no time."""
        if self.speed == 0.0:
            inside = self.lane.low <= self.along <= self.lane.high
            return inf if inside == outwards else -inf
        return self.since + (border - self.along) / self.speed


@dataclass(frozen=True)
class Meeting:
    """A motion into that of a point, and when it ends, s."""

    way: Travel
    time: float


def meet(
    machine: Machine, start: States, now: float, course: Course, limits: MotionLimits, tip_speed: float = inf
) -> Meeting | None:
    """Return the soonest meeting of an arm, whose state is `start` at the time `now` (s), with a point on its course.

    The motion keeps the limits of the joints and the speed of the tip (m/s). None where there is no such meeting within
    the reach and three seconds. Raise MachineError if the arm is not a planar one.
    """
    for _ in range(ATTEMPTS):
        found = _soonest(start, now, course, limits)
        if found is None:
            return None
        factor = tip_peaks(machine, found.way)[0] / tip_speed
        if factor <= 1.0:
            return found
        limits = limits.slower(1.05 * factor)
    return None


def _soonest(start: States, now: float, course: Course, limits: MotionLimits) -> Meeting | None:
    first, last = max(course.enters - now, STEP), min(course.leaves - now, LONGEST)
    times = np.arange(first, last, STEP) if first < last else np.zeros(0)
    if len(times) == 0:
        return None
    ends = course.states(now + times)
    able = (np.abs(ends.velocities) <= limits.speed).all(axis=1)
    able &= (np.abs(ends.accelerations) <= limits.acceleration).all(axis=1)
    for k in np.flatnonzero(able).tolist():
        way = transfer(start, States(*(of[k] for of in ends)), limits, duration=float(times[k]))
        if way.duration <= times[k] + 1e-6:
            return Meeting(way, now + float(times[k]))
    return None
