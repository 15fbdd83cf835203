"""Detector of an angle that does not change although it should: its sensor is frozen, or the joint is blocked."""

from math import inf, nan
from typing import NamedTuple

from layflat.jit import law
from layflat.rig.safety.detectors.air import MOTION_COUNTS
from layflat.rig.safety.detectors.sample import AIR_LEVEL, accumulate_time, is_angle_unchanged
from layflat.rig.safety.faults import Fault

ANGLE_FAULT = int(Fault.ANGLE_FROZEN)
BRISK_COUNTS = 5.5  # counts in a cycle from which no joint stops at once: 40 deg/s with the built-in arm
# Change of the differential pressure, over the friction band and without the load of other joints, that no joint bears
# without a motion of one count. Sound ones at rest, shaken by another, bear 1.6 in an hour.
FRICTION_BAND_RATIO = 1.9
# Errors from which a joint is driven, with its valve open and with it centred, rad (friction may hold it at less), and
# opening from which the valve is open: a centre may be off by 8 % of full opening.
DRIVEN_ERROR, CENTRED_ERROR, MIN_DRIVING_OPENING = 0.09, 0.2, 0.12
MAX_UNCHANGED_TIME = 0.29  # within which a driven joint moves by a count; ones disturbed by another took 0.2 s, s
MAX_HELD_TIME = 0.6  # within which it moves by more than noise, which may alternate by a count, s
MAX_UNSEEN_TRAVEL = 0.01  # computed motion, from the torque beyond friction, of a joint whose angle is constant, rad


class FrozenAngleLimits(NamedTuple):
    """Limits of the detector of a frozen angle."""

    grain: float  # one count of the angle's converter, or noise if that is more, rad
    friction_band: float  # change of the differential pressure that friction of brake, hose and strap can hide, Pa
    cycle: float  # time between two samples that are in time, s
    sure: float  # time of the same sample after which a sensor that does not fit the valve is frozen, s
    patience: float  # the same where the joint bears too much, or where noise never leaves a sensor at one count, s
    noisy: float = 0.0  # 1 if noise never leaves the sensor at one count, else 0
    lands: float = 0.0  # error up to which the control law may bring the joint to rest at once, rad
    fades: float = 0.0  # time at rest until the averaged pressure no longer contains that which braked the joint, s
    rests: float = 0.0  # motion in a cycle up to which the joint may be at rest in the next, rad
    hides: float = inf  # differential pressure that friction may hold at rest; infinite: no motion is computed, Pa


class BornePressure(NamedTuple):
    """Range of the differential pressure since the angle last changed, Pa."""

    lower: float = 0.0
    upper: float = 0.0


class FrozenAngleMemory(NamedTuple):
    """Memory of the detector: loads borne since the angle last changed, and times for which it has been constant."""

    whole: BornePressure = BornePressure()
    net: BornePressure = BornePressure()  # less the load of gravity and moving joints, for any payload
    rate: float = 0.0  # computed velocity, from the torque beyond friction, rad/s
    travel: float = 0.0  # computed motion, from that velocity, rad
    asleep: float = 0.0  # time without a change while driven, s
    anchor: float = nan  # angle after the last motion by more than noise, rad
    held: float = 0.0  # time at the anchor while driven, s


@law
def _widen_range(before, low, high, goes_on):
    """Return the range (low, high) of a pressure that is known within bounds; it starts anew unless it goes on."""
    return BornePressure(min(before.lower, high) if goes_on else high, max(before.upper, low) if goes_on else low)


@law
def _range_width(borne):
    return borne.upper - borne.lower


@law
def _excess_over_friction(low, high, hides):
    """Return the pressure beyond +-hides, where the whole range low..high is beyond (any payload), else 0, Pa."""
    return low - hides if low > hides else (high + hides if high < -hides else 0.0)


@law
def is_blocked(limits, memory, now):
    """Return whether the angle is constant while the joint bears more than friction can hide."""
    return now.same_angle > limits.sure and _range_width(memory.whole) > limits.friction_band


@law
def find_angle_frozen(limits, memory, doubts, before, now, sample):
    """Return memory and fault (ANGLE_FAULT or 0) after a sample, from the traces `before` it and `now`, after it.

    Any of the conditions in docs/rig-faults.md is a fault; most need an angle that is constant for a time.
    """
    same, p = is_angle_unchanged(before, sample), sample.averaged_pressure
    bears = same and before.same_angle >= limits.fades
    # The load of the other joints may be smaller than estimated: both ranges have to exceed the limit.
    light, heavy = p - sample.others_light, p - sample.others_heavy
    low, high = min(light, heavy), max(light, heavy)
    whole, net = _widen_range(memory.whole, p, p, bears), _widen_range(memory.net, low, high, bears)
    borne = min(_range_width(whole), _range_width(net))
    # In uneven cycles the instants of the pressures are too uncertain.
    pushed = _excess_over_friction(low, high, limits.hides) if bears and sample.alone > 0.0 else 0.0
    onward = memory.rate if pushed * memory.rate > 0.0 else 0.0
    rate = onward + sample.elapsed * pushed / sample.inertia
    travel = (memory.travel if pushed * memory.travel > 0.0 else 0.0) + sample.elapsed * rate
    driven = sample.level >= AIR_LEVEL and abs(sample.demand - sample.angle) > DRIVEN_ERROR
    drives = driven and (abs(sample.opening) > MIN_DRIVING_OPENING or abs(sample.demand - sample.angle) > CENTRED_ERROR)
    counts = sample.elapsed if drives else 0.0
    asleep = accumulate_time(memory.asleep, same and driven, counts)
    near = abs(sample.angle - memory.anchor) <= MOTION_COUNTS * limits.grain
    anchor = memory.anchor if near else sample.angle
    held = accumulate_time(memory.held, anchor == memory.anchor and driven, counts)
    after = FrozenAngleMemory(whole, net, rate, travel, asleep, anchor, held)
    stays = now.same_angle > limits.sure
    # Step and speed both: a sample after a late one is further from it, and a late one was sampled before it came.
    landed = abs(sample.demand - sample.angle) < limits.lands
    brisk = min(now.step, now.speed * limits.cycle) > max(BRISK_COUNTS * limits.grain, limits.rests) and not landed
    frozen = (
        (doubts.wrong and not doubts.any and is_blocked(limits, after, now))
        or (stays and (brisk or (doubts.angle and doubts.suspect)))
        or (stays and (doubts.moves or abs(travel) > MAX_UNSEEN_TRAVEL))
        or asleep >= MAX_UNCHANGED_TIME
        or held >= MAX_HELD_TIME
        or (
            now.same_angle >= limits.patience
            and (limits.noisy > 0.0 or borne > FRICTION_BAND_RATIO * limits.friction_band)
        )
    )
    return after, ANGLE_FAULT if frozen else 0
