"""What is watched of one joint in every cycle. Each detector is a few comparisons of plain numbers."""

from __future__ import annotations

from typing import NamedTuple

from layflat.rig.safety.faults import TABLE, Fault
from layflat.rig.safety.lasting import Lasting, Samples
from layflat.rig.safety.limits import Limits

MOTION = 2.5
"""Counts from one sample to the next that are motion, not noise."""

DOUBTFUL = 2.5
"""Cycles of the same sample after which a sensor may be frozen: what is computed from it says nothing of the valve."""


class Signals(NamedTuple):
    """What a joint's detectors see in a cycle."""

    angle: float
    """As sampled, rad."""
    pressure: float
    """Differential, as sampled, Pa."""
    averaged_pressure: float
    speed: float
    """From the averaged angle, rad/s."""
    ripple: float
    """Pa"""
    surplus: float
    """Of air, as an opening of the valve."""
    demand: float
    """As given to the controller, rad."""
    lead: float
    """Greatest lead of any joint's demand over what it could reach, rad."""


class JointWatch:
    """Detectors of a joint.

    Args:
        limits: what it is judged by.
        cycle: of the loop, s.
    """

    def __init__(self, limits: Limits, cycle: float) -> None:
        self.limits = limits
        self._nominal = cycle
        self.reset()

    def reset(self) -> None:
        """Forget what was seen."""
        cycle = self._nominal
        self._before: float | None = None
        self._rail = Samples(TABLE[Fault.ANGLE_AT_RAIL].cycles)
        self._fast = Samples(TABLE[Fault.OVER_SPEED].cycles)
        self._outside = Samples(TABLE[Fault.OUTSIDE_STROKE].cycles)
        self._pressed = Samples(TABLE[Fault.OVER_PRESSURE].cycles)
        self._same_pressure = Lasting(TABLE[Fault.PRESSURE_FROZEN].seconds, cycle)
        self._same_angle = Lasting(TABLE[Fault.ANGLE_FROZEN].seconds, cycle)
        self._off = Lasting(TABLE[Fault.FOLLOWING_ERROR].seconds, cycle)
        self._quiet = Lasting(TABLE[Fault.NO_ANSWER].seconds, cycle)
        self._doubtful = DOUBTFUL * cycle
        self._angle = self._pressure_before = float("nan")
        self._least = self._most = 0.0
        self._moved = self._suspect = False
        self._reach: float | None = None

    def sensors(self, seen: Signals) -> Fault:
        """What can be wrong with or without air."""
        limits = self.limits
        # Written so that what is not a number is at fault.
        sound = limits.angle_low < seen.angle < limits.angle_high
        if self._pressed(not -limits.pressure < seen.pressure < limits.pressure):
            return Fault.OVER_PRESSURE
        return Fault.ANGLE_AT_RAIL if self._rail(not sound) else Fault.NONE

    def motion(self, seen: Signals, elapsed: float) -> Fault:
        """What can be wrong of a joint that may move."""
        limits, before = self.limits, self._before
        sound = limits.angle_low < seen.angle < limits.angle_high
        self._before = seen.angle if sound else None
        step = 0.0 if before is None or not sound else abs(seen.angle - before)
        if self._fast(step > limits.speed * elapsed):
            return Fault.OVER_SPEED
        return Fault.OUTSIDE_STROKE if self._outside(sound and abs(seen.angle) > limits.stroke) else Fault.NONE

    def air(self, seen: Signals, elapsed: float, *, alone: bool) -> Fault:
        """What can be wrong of a joint that has air and whose valve obeys.

        Args:
            seen: signals.
            elapsed: s.
            alone: whether other joints have ripple, or there are none: a lack of it is then this joint's own.
        """
        limits = self.limits
        same = seen.pressure == self._pressure_before
        self._pressure_before = seen.pressure
        frozen = self._same_pressure(same and limits.lively, elapsed)
        repeats = self._same_pressure.time > self._doubtful or self._angle_repeats(seen, elapsed)
        quiet = self._quiet(alone and limits.ripple > 0.0 and seen.ripple < limits.ripple and not same, elapsed)
        wrong = abs(seen.surplus) > limits.surplus
        self._suspect = repeats and (wrong or self._suspect)
        if (wrong and not repeats) or quiet:
            return Fault.NO_ANSWER
        if self._same_angle.time >= self._same_angle.enough and (
            self._suspect or self._most - self._least > limits.friction_band
        ):
            return Fault.ANGLE_FROZEN
        return Fault.PRESSURE_FROZEN if frozen else Fault.NONE

    def _angle_repeats(self, seen: Signals, elapsed: float) -> bool:
        """Whether the angle of a joint that moved stays at one count; notes what the pressure does meanwhile."""
        angle, p = seen.angle, seen.averaged_pressure
        same = angle == self._angle
        if not same:
            self._moved = abs(angle - self._angle) > MOTION * self.limits.count
            self._angle, self._least, self._most = angle, p, p
        self._least, self._most = min(self._least, p), max(self._most, p)
        self._same_angle(same, elapsed)
        return self._moved and self._same_angle.time > self._doubtful

    def following(self, seen: Signals, elapsed: float) -> bool:
        """Whether the joint is not where its demand has led it.

        The reach goes to the demand as fast as demands may go for long, or as fast as the joint, if that is faster.
        So a step is no error, and a joint that is ahead of its time is none either. What any joint's demand has jumped
        lately is allowed for, since joints shake each other.
        """
        limits, demand, angle = self.limits, seen.demand, seen.angle
        reach = angle if self._reach is None else self._reach
        way = limits.demand_speed * elapsed
        reach = min(max(reach + way, angle), demand) if demand >= reach else max(min(reach - way, angle), demand)
        self._reach = reach
        allowed = limits.following + limits.following_time * abs(seen.speed) + seen.lead
        return self._off(abs(angle - reach) > allowed, elapsed)
