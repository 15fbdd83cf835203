"""Moving targets: the tip follows a point that a belt carries along a straight line.

The belt's speed goes from one value to the next as a cubic polynomial in time that is level at both ends, so that its
acceleration is continuous. Where the point leaves the arm's reach, the tip stops at the border, by such a polynomial
too, which begins with the belt's own speed and acceleration.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import cos, sin

import numpy as np
from scipy.interpolate import CubicHermiteSpline
from scipy.optimize import brentq

from layflat.arrays import Array
from layflat.errors import InputError
from layflat.machine import Machine
from layflat.motion.curve import LineCurve, Point, TipPath
from layflat.motion.kinematics import tip_position
from layflat.motion.path import SAME_POINT_DISTANCE
from layflat.motion.tip_path import tip_path
from layflat.motion.trajectory import PathMotion

PEAK_TO_MEAN_ACCELERATION = 1.5  # ratio for a change of speed by a cubic polynomial
STOP_STRETCH = 0.6  # added to that ratio for a stop that begins while the belt has its full acceleration
BELT_SAMPLES = 2001  # instants at which the point's position is computed
KNOT_ROUNDING = 1e-9  # times that differ by less are the same knot, s


@dataclass(frozen=True)
class ReachExit:
    """First instant (s) at which the point on the belt leaves the arm's reach, and its position then (m)."""

    time: float
    position: Point


@dataclass(frozen=True)
class BeltMotion(PathMotion):
    """Motion that follows a point on a belt as far as the arm reaches."""

    reach_exit: ReachExit | None  # None if the arm reaches the whole path


def follow_belt(
    machine: Machine, start: Array, direction: float, speeds: Sequence[tuple[float, float]], acceleration: float,
    where: str = "belt",
) -> BeltMotion:  # fmt: skip
    """Return the motion of an arm whose tip follows a point on a belt, from rest to rest.

    Args:
        machine: machine whose arm follows; in space the belt is level, at the height of the tip.
        start: configuration in which the tip is at the point, (joints,), rad.
        direction: direction of the belt, from the x axis about z, rad.
        speeds: when the belt's speed begins to change (s), and what to (m/s; negative: back); the last is zero.
        acceleration: maximum of the belt, m/s2.
        where: source of these values, for messages.

    Returns:
        Motion of the joints; it stops at the border of the reach if the point leaves it.

    Raises:
        InputError: naming `where`: the speeds contradict each other, the belt does not stop, or the arm is stretched.
    """
    speed = _belt_speed(speeds, acceleration, where)
    tip = tuple(tip_position(machine, start).tolist())
    unit = (cos(direction), sin(direction), 0.0)[: len(tip)]
    distances = speed.antiderivative()(np.linspace(0.0, speed.x[-1], BELT_SAMPLES))
    span = float(distances.min()), float(distances.max())
    path = tip_path(machine, LineCurve(tip, unit, 1.0), start, where, span=span)
    crossing, reach_exit = _first_reach_exit(path, speed), None
    if crossing is not None:
        time, border = crossing
        reach_exit = ReachExit(time, tuple(path.curve.evaluate(np.array([border])).value[0].tolist()))
        speed = _stopping_speed(speed, time, border, acceleration)
    distance, change = speed.antiderivative(), speed.derivative()
    return BeltMotion(
        float(speed.x[-1]), path, lambda times: (distance(times), speed(times), change(times)), reach_exit
    )


def _belt_speed(speeds: Sequence[tuple[float, float]], acceleration: float, where: str) -> CubicHermiteSpline:
    """Return the belt's speed (m/s) over time (s): from rest at 0 s, it changes from each time on to its speed.

    Each change is smooth; its greatest acceleration is `acceleration`, m/s2.

    Raises:
        InputError: naming `where`: changes overlap, or the belt does not move or does not end at rest.
    """
    knots, values = [0.0], [0.0]
    for time, value in speeds:
        duration = PEAK_TO_MEAN_ACCELERATION * abs(value - values[-1]) / acceleration
        if time < knots[-1] - KNOT_ROUNDING:
            what = f"begins to change its speed at {time:g} s, while it changes until {knots[-1]:g} s"
            raise InputError(what, where=where, right="give a later time, or a greater acceleration")
        if time > knots[-1] + KNOT_ROUNDING:
            knots, values = [*knots, time], [*values, values[-1]]
        if duration > 0.0:
            knots, values = [*knots, knots[-1] + duration], [*values, value]
    if values[-1] != 0.0 or not any(values):
        what = "does not move" if not any(values) else f"ends with {values[-1]:g} m/s, not at rest"
        raise InputError(what, where=where, right='give speeds such as [["0 s", "0.3 m/s"], ["1 s", "0 m/s"]]')
    return CubicHermiteSpline(knots, values, np.zeros(len(knots)))


def _first_reach_exit(path: TipPath, speed: CubicHermiteSpline) -> tuple[float, float] | None:
    """Return time (s) and signed distance (m) at which the belt's point first leaves the arm's reach; None if never."""
    distance, times = speed.antiderivative(), np.linspace(0.0, speed.x[-1], BELT_SAMPLES)
    distances, crossings = distance(times), []
    for furthest in (float(distances.max()), float(distances.min())):
        border = path.reach_limit(furthest)
        if border is not None:
            k = int(np.argmax(distances > border if furthest > 0.0 else distances < border))
            time = float(brentq(lambda t, border=border: distance(t) - border, times[k - 1], times[k]))
            crossings.append((time, border))
    return min(crossings, default=None)


def _stopping_speed(
    speed: CubicHermiteSpline, crossing_time: float, border: float, acceleration: float
) -> CubicHermiteSpline:
    """Return the speed over time of a tip that leaves the belt's point at the last instant to stop at the border.

    `border` is its signed distance along the belt, m, which the point reaches at `crossing_time`, s; `acceleration` is
    the belt's maximum, m/s2. A tip that begins at the border stays at rest.
    """
    distance, change, end = speed.antiderivative(), speed.derivative(), float(speed.x[-1])
    if abs(border) < SAME_POINT_DISTANCE:  # the tip stays where it begins
        return CubicHermiteSpline([0.0, end], [0.0, 0.0], [0.0, 0.0])
    sign = np.sign(border)

    def stop_duration(t: float) -> float:
        fraction = max(sign * change(t) / acceleration, 0.0)
        return float((PEAK_TO_MEAN_ACCELERATION + STOP_STRETCH * fraction) * abs(speed(t)) / acceleration)

    def remaining_distance(t: float) -> float:
        duration = stop_duration(t)
        return float(sign * (border - distance(t) - duration * (speed(t) / 2 + change(t) * duration / 12)))

    times = np.linspace(0.0, crossing_time, BELT_SAMPLES)
    last = int(np.flatnonzero([remaining_distance(t) >= 0.0 for t in times])[-1])
    begins = float(brentq(remaining_distance, times[last], times[last + 1]))
    ends = begins + stop_duration(begins)
    before = np.append(speed.x[speed.x < begins - KNOT_ROUNDING], begins)
    after = np.array([ends, end] if end > ends + KNOT_ROUNDING else [ends])
    knots, still = np.concatenate([before, after]), np.zeros(len(after))
    return CubicHermiteSpline(knots, np.concatenate([speed(before), still]), np.concatenate([change(before), still]))
