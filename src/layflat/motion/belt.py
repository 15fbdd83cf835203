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
from layflat.motion.curve import Line, Point, TipPath
from layflat.motion.kinematics import tip_position
from layflat.motion.path import CLOSE
from layflat.motion.tip_path import tip_path
from layflat.motion.trajectory import Along

PEAK = 1.5  # of a change of speed: its greatest acceleration over its mean one
MORE = 0.6  # by which a stop takes longer, in the same unit, where the belt has its full acceleration
LOOKS = 2001  # instants at which it is looked where the point is
ROUNDING = 1e-9  # s


@dataclass(frozen=True)
class Left:
    """When (s) and where (m) the point on the belt leaves the arm's reach for the first time."""

    time: float
    place: Point


@dataclass(frozen=True)
class Followed(Along):
    """A motion that follows a point on a belt as far as the arm reaches."""

    left: Left | None  # None if the arm reaches all of its way


def follow_belt(
    machine: Machine, start: Array, direction: float, speeds: Sequence[tuple[float, float]], acceleration: float,
    where: str = "belt",
) -> Followed:  # fmt: skip
    """Return the motion of an arm whose tip follows a point on a belt, from rest to rest.

    Args:
        machine: whose arm follows; in space the belt is level, at the height of the tip.
        start: posture in which the tip is at the point, (joints,), rad.
        direction: of the belt, from the x axis about z, rad.
        speeds: when the belt's speed begins to change (s), and what to (m/s; negative: back); the last is zero.
        acceleration: of the belt at most, m/s2.
        where: it was given, for messages.

    Raises:
        InputError: naming `where`: the speeds contradict each other, the belt does not stop, or the arm is stretched.
    """
    speed = _profile(speeds, acceleration, where)
    tip = tuple(tip_position(machine, start).tolist())
    way = (cos(direction), sin(direction), 0.0)[: len(tip)]
    furthest = speed.antiderivative()(np.linspace(0.0, speed.x[-1], LOOKS))
    span = float(furthest.min()), float(furthest.max())
    path = tip_path(machine, Line(tip, way, 1.0), start, where, span=span)
    crossed, left = _crossing(path, speed), None
    if crossed is not None:
        time, border = crossed
        left = Left(time, tuple(path.curve.at(np.array([border])).value[0].tolist()))
        speed = _stopping(speed, time, border, acceleration)
    along, change = speed.antiderivative(), speed.derivative()
    return Followed(float(speed.x[-1]), path, lambda times: (along(times), speed(times), change(times)), left)


def _profile(speeds: Sequence[tuple[float, float]], acceleration: float, where: str) -> CubicHermiteSpline:
    """Return the belt's speed over time."""
    knots, values = [0.0], [0.0]
    for time, value in speeds:
        lasts = PEAK * abs(value - values[-1]) / acceleration
        if time < knots[-1] - ROUNDING:
            what = f"begins to change its speed at {time:g} s, while it changes until {knots[-1]:g} s"
            raise InputError(what, where=where, right="give a later time, or a greater acceleration")
        if time > knots[-1] + ROUNDING:
            knots, values = [*knots, time], [*values, values[-1]]
        if lasts > 0.0:
            knots, values = [*knots, knots[-1] + lasts], [*values, value]
    if values[-1] != 0.0 or not any(values):
        what = "does not move" if not any(values) else f"goes on with {values[-1]:g} m/s"
        raise InputError(what, where=where, right='give speeds such as [["0 s", "0.3 m/s"], ["1 s", "0 m/s"]]')
    return CubicHermiteSpline(knots, values, np.zeros(len(knots)))


def _crossing(path: TipPath, speed: CubicHermiteSpline) -> tuple[float, float] | None:
    """Return when the point on the belt first leaves the arm's reach (s), and at which distance (m), if it does."""
    way, times = speed.antiderivative(), np.linspace(0.0, speed.x[-1], LOOKS)
    at, found = way(times), []
    for furthest in (float(at.max()), float(at.min())):
        border = path.border(furthest)
        if border is not None:
            k = int(np.argmax(at > border if furthest > 0.0 else at < border))
            found.append((float(brentq(lambda t, border=border: way(t) - border, times[k - 1], times[k])), border))
    return min(found, default=None)


def _stopping(speed: CubicHermiteSpline, crossed: float, border: float, acceleration: float) -> CubicHermiteSpline:
    """Return the speed of a tip that leaves the belt as late as it still stops at the border."""
    way, change, end = speed.antiderivative(), speed.derivative(), float(speed.x[-1])
    if abs(border) < CLOSE:  # where it begins: it stays there
        return CubicHermiteSpline([0.0, end], [0.0, 0.0], [0.0, 0.0])
    sign = np.sign(border)

    def lasts(t: float) -> float:
        share = max(sign * change(t) / acceleration, 0.0)
        return float((PEAK + MORE * share) * abs(speed(t)) / acceleration)

    def left_over(t: float) -> float:
        return float(sign * (border - way(t) - lasts(t) * (speed(t) / 2 + change(t) * lasts(t) / 12)))

    times = np.linspace(0.0, crossed, LOOKS)
    last = int(np.flatnonzero([left_over(t) >= 0.0 for t in times])[-1])
    begins = float(brentq(left_over, times[last], times[last + 1]))
    ends = begins + lasts(begins)
    before = np.append(speed.x[speed.x < begins - ROUNDING], begins)
    after = np.array([ends, end] if end > ends + ROUNDING else [ends])
    knots, still = np.concatenate([before, after]), np.zeros(len(after))
    return CubicHermiteSpline(knots, np.concatenate([speed(before), still]), np.concatenate([change(before), still]))
