"""Interception of a moving point: the earliest time at which an arm can have its position and velocity.

| symbol | meaning | unit |
|---|---|---|
| s | distance of the point along its line | m |
| T | time until arm and point meet | s |

They meet at the first T that is not shorter than the quickest motion from the arm's state to that of the point at T.
Motions between moving states: `travel.plan_transfer`.
"""

from dataclasses import dataclass
from functools import cached_property
from math import cos, inf, sin

import numpy as np

from layflat.arrays import Array
from layflat.machine import Machine
from layflat.motion.curve import LineCurve
from layflat.motion.limits import MotionLimits
from layflat.motion.planar import PlanarPath, PlanarReach
from layflat.motion.trajectory import States
from layflat.motion.travel import PlannedMove, plan_transfer, tip_peaks

LINE_GRID = 2e-3  # spacing of the points along a line at which reach is evaluated, m
TIME_STEP = 0.02  # between tried meeting times, s
MAX_MEETING_TIME = 3.0  # from now, s
BRAKING_DECELERATION = 2.0  # of an arm that stops at the end of its reach, m/s2
MAX_ATTEMPTS = 4  # with reduced limits, until the tip keeps its speed limit


class TargetLine:
    """Straight line of the tip, and its part from `low` to `high` (m) that an arm reaches with one elbow."""

    def __init__(self, reach: PlanarReach, start: tuple[float, float], direction: float, length: float) -> None:
        """Compute the first unbroken reachable part of a line; `path` is None if there is none.

        Where both elbows reach it, the one with the widest margin at the first reachable point is used.

        Args:
            reach: reach of the arm.
            start: start of the line, m.
            direction: direction of the line, from the x axis, rad.
            length: length of the line, m.
        """
        unit = (cos(direction), sin(direction))
        s = np.arange(0.0, length, LINE_GRID)
        points = np.array(start) + s[:, None] * unit
        first_reached = next((options for x, y in points.tolist() if (options := reach.configurations(x, y))), None)
        self.path: PlanarPath | None = None
        self.low = self.high = 0.0
        if first_reached is not None:
            line = LineCurve(start, unit, length)
            self.path = PlanarPath(reach.machine, line, np.array(first_reached[0].angles), "line")
            within = self.path.reaches(s)
            within[within] = (np.abs(self.path.evaluate(s[within]).value) <= reach.limits).all(axis=1)
            first = int(np.argmax(within))
            last = first + int(np.argmin(np.append(within[first:], False)))
            self.low, self.high = float(s[first]), float(s[max(last - 1, first)])


@dataclass(frozen=True)
class MovingTarget:
    """Point that moves along a target line at a constant speed."""

    line: TargetLine  # at least partly within reach
    distance: float  # along the line at the time of reference, m
    time: float  # of reference, s
    speed: float  # m/s, negative for backwards

    def distance_at(self, time: float) -> float:
        """Return the distance of the point along its line at a time (s), m."""
        return self.distance + self.speed * (time - self.time)

    def states(self, times: Array) -> States:
        """Return the states of joints whose tip is at the point, at times (instants,), s, within reach."""
        assert self.line.path is not None
        q, first, second = self.line.path.evaluate(self.distance + self.speed * (times - self.time))
        return States(q, first * self.speed, second * self.speed**2)

    def state(self, time: float) -> States:
        """Return the state of joints whose tip is at the point at one time (s), (joints,) each."""
        return States(*(rows[0] for rows in self.states(np.array([time]))))

    @cached_property
    def entry_time(self) -> float:
        """Time at which the point comes within reach, s."""
        return self._passing_time(self.line.low if self.speed > 0.0 else self.line.high, outwards=False)

    @cached_property
    def braking_time(self) -> float:
        """Last time at which an arm that follows can begin to stop within its reach, s."""
        stopping = self.speed * abs(self.speed) / (2.0 * BRAKING_DECELERATION)
        return self._passing_time(self.end - stopping, outwards=True)

    @property
    def end(self) -> float:
        """Distance along the line at which the point leaves the reach, m."""
        return self.line.high if self.speed > 0.0 else self.line.low

    @property
    def end_angles(self) -> Array:
        """Angles (joints,), rad, at the end of the reach."""
        assert self.line.path is not None
        angles: Array = self.line.path.evaluate(np.array([self.end])).value[0]
        return angles

    def _passing_time(self, border: float, *, outwards: bool) -> float:
        """Return the time (s) at which the point passes a distance (m) into or out of the reach.

        For a stationary point it is -inf if it is already there (inside, or `outwards`: outside), else inf.
        """
        if self.speed == 0.0:
            inside = self.line.low <= self.distance <= self.line.high
            return inf if inside == outwards else -inf
        return self.time + (border - self.distance) / self.speed


@dataclass(frozen=True)
class Meeting:
    """Motion of the joints into that of a point."""

    motion: PlannedMove
    time: float  # of its end, s


def plan_meeting(
    machine: Machine, start: States, now: float, target: MovingTarget, limits: MotionLimits, tip_speed: float = inf
) -> Meeting | None:
    """Plan the earliest meeting of an arm with a moving target.

    Args:
        machine: machine with a planar arm.
        start: state of the joints now, (joints,) each.
        now: time, s.
        target: target to be met with its velocity.
        limits: limits of the joints.
        tip_speed: greatest speed of the tip, m/s.

    Returns:
        The meeting; None if there is none within reach and three seconds, or none keeps the tip's speed limit.

    Raises:
        MachineError: the arm is not planar.
        InputError: ruckig is not installed.
        LayflatError: ruckig finds no motion to a state within the limits.
    """
    for _ in range(MAX_ATTEMPTS):
        meeting = _earliest_meeting(start, now, target, limits)
        if meeting is None:
            return None
        factor = tip_peaks(machine, meeting.motion)[0] / tip_speed
        if factor <= 1.0:
            return meeting
        limits = limits.slowed(1.05 * factor)
    return None


def _earliest_meeting(start: States, now: float, target: MovingTarget, limits: MotionLimits) -> Meeting | None:
    """Return the earliest meeting on a grid of `TIME_STEP` within the limits, None if there is none.

    `now` is the time of the start on the target's clock, s.
    """
    first, last = max(target.entry_time - now, TIME_STEP), min(target.braking_time - now, MAX_MEETING_TIME)
    times = np.arange(first, last, TIME_STEP) if first < last else np.zeros(0)
    if len(times) == 0:
        return None
    ends = target.states(now + times)
    feasible = (np.abs(ends.velocities) <= limits.speed).all(axis=1)
    feasible &= (np.abs(ends.accelerations) <= limits.acceleration).all(axis=1)
    for k in np.flatnonzero(feasible).tolist():
        motion = plan_transfer(start, States(*(rows[k] for rows in ends)), limits, duration=float(times[k]))
        if motion.duration <= times[k] + 1e-6:
            return Meeting(motion, now + float(times[k]))
    return None
