"""What is watched of one joint in every cycle. Each detector is a few comparisons of plain numbers."""

from __future__ import annotations

from math import inf, sqrt
from typing import NamedTuple

from layflat.rig.safety.faults import TABLE, Fault
from layflat.rig.safety.lasting import Lasting, Samples
from layflat.rig.safety.limits import Limits

MOTION = 2.5
"""Counts from one sample to the next that are motion, not noise."""

DOUBTFUL = 2.5
"""Cycles of the same sample after which a sensor may be frozen: what is computed from it says nothing of the valve."""

SURE = 7.5
"""The same, when a sensor that repeats itself does not fit what the valve was told: it is frozen."""

BEYOND = 2.4
"""Of the differential pressure that friction can hide: so much a joint never bears without a motion of one count. Sound
ones at rest, shaken by another, bear 1.6 in an hour."""

RIPPLE_AFTER = 4.0
"""Cycles that the ripple takes to show that there is none any more."""

BRISK = 5.5
"""Counts from one sample to the next after which no joint stands still at once, 40 deg/s with the built-in sensor."""

DRIVEN = 0.09
"""Error of a joint that is driven, rad; by less friction may hold it."""

ASLEEP = 0.3
"""A driven joint moves by a count within this time; sound ones, shaken by another, took 0.2 s, s."""


class Signals(NamedTuple):
    """What a joint's detectors see in a cycle."""

    angle: float
    """As sampled, rad."""
    pressure: float
    """Differential, as sampled, Pa."""
    averaged_pressure: float
    speed: float
    """From the averaged angle, rad/s."""
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
        self._quiet = Lasting(TABLE[Fault.NO_ANSWER].seconds - RIPPLE_AFTER * cycle, cycle)
        self._doubtful, self._sure = DOUBTFUL * cycle, SURE * cycle
        self._angle = self._pressure = float("nan")
        self._least = self._most = 0.0
        self._moved = self._brisk = self._suspect = False
        self._asleep = Lasting(ASLEEP, cycle)
        self._reach: float | None = None
        self.ripple = inf
        """Amplitude of the pressure at a quarter of the loop's rate, whatever its slope; infinite at first, Pa."""
        self._p1 = self._p2 = self._p3 = self._swing = float("nan")

    def sensors(self, seen: Signals) -> Fault:
        """What can be wrong with or without air."""
        limits = self.limits
        # Written so that what is not a number is at fault.
        sound = limits.angle_low < seen.angle < limits.angle_high
        if self._pressed(not -limits.pressure < seen.pressure < limits.pressure):
            return Fault.OVER_PRESSURE
        return Fault.ANGLE_AT_RAIL if self._rail(not sound) else Fault.NONE

    def listen(self, pressure: float) -> None:
        """Follow the ripple: a slope cancels in a swing, and two swings are a quarter of a period apart."""
        swing = (pressure - self._p2) - (self._p1 - self._p3)
        before = self._swing
        self._p1, self._p2, self._p3, self._swing = pressure, self._p1, self._p2, swing
        size = swing * swing + before * before
        self.ripple = sqrt(0.125 * size) if size == size else inf  # noqa: PLR0124  # not a number: no four samples yet

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
            alone: false where the supply is in doubt: what the air does is then no fault of this joint.
        """
        limits, p = self.limits, self._same_pressure
        frozen = p(seen.pressure == self._pressure and limits.lively, elapsed)
        self._pressure = seen.pressure
        angle_repeats = self._angle_repeats(seen, elapsed)
        crossed = self._most - self._least
        held = crossed > limits.friction_band
        wrong = alone and abs(seen.surplus) > limits.surplus
        quiet = self._quiet(alone and self.ripple < limits.ripple, elapsed)
        if p.time > self._doubtful or angle_repeats:
            self._suspect = self._suspect or wrong
        else:
            self._suspect = False
            if wrong:
                return Fault.ANGLE_FROZEN if self._same_angle.time > self._sure and held else Fault.NO_ANSWER
        if angle_repeats and self._suspect and self._same_angle.time > self._sure:
            return Fault.ANGLE_FROZEN
        if (self._brisk and self._same_angle.time > self._sure) or self._asleep(self._driven(seen), elapsed):
            return Fault.ANGLE_FROZEN
        if crossed > BEYOND * limits.friction_band and self._same_angle.time >= self._same_angle.enough:
            return Fault.ANGLE_FROZEN
        if frozen or (self._suspect and p.time > self._sure):
            return Fault.PRESSURE_FROZEN
        return Fault.NO_ANSWER if quiet else Fault.NONE

    def _angle_repeats(self, seen: Signals, elapsed: float) -> bool:
        """Whether the angle of a joint that moved stays at one count; notes what the pressure does meanwhile."""
        angle, p = seen.angle, seen.averaged_pressure
        same = angle == self._angle
        if not same:
            step = abs(angle - self._angle)
            self._moved, self._brisk = step > MOTION * self.limits.lsb, step > BRISK * self.limits.lsb
            self._angle, self._least, self._most = angle, p, p
        self._least, self._most = min(self._least, p), max(self._most, p)
        self._same_angle(same, elapsed)
        return self._moved and self._same_angle.time > self._doubtful

    def _driven(self, seen: Signals) -> bool:
        """Whether the joint stays at one count of its sensor, far from where it is asked to be."""
        return self._same_angle.time > 0.0 and abs(seen.demand - seen.angle) > DRIVEN

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
