"""An angle that does not change although it should: its sensor is frozen, or the joint is blocked."""

from math import nan
from typing import NamedTuple

from layflat.jit import law
from layflat.rig.safety.detectors.doubt import MOVING
from layflat.rig.safety.detectors.sample import AIR, lasted, unchanged
from layflat.rig.safety.faults import Fault

FAULT = int(Fault.ANGLE_FROZEN)
BRISK = 5.5  # counts from one sample to the next after which no joint stands still at once: 40 deg/s as built in
# Of the differential pressure that friction can hide: so much, what others hold off left out, a joint never bears
# without a motion of one count. Sound ones at rest, shaken by another, bear 1.6 in an hour.
BEYOND = 1.9
DRIVEN = 0.09  # error of a joint that is driven, rad; by less friction may hold it
# A driven joint moves by a count within this time (s): sound ones, shaken by another, took 0.2 s, and with a small
# valve twice as long as this takes, fully open, to build up what friction holds. By more than noise, which may go to
# and fro by a count, it moves in twice the time.
ASLEEP, SHAKEN, BUILDS = 0.29, 0.2, 2.0
HELD = 0.6


class Limits(NamedTuple):
    """What an angle that stays is judged by."""

    lsb: float  # one count of the angle's converter, rad
    friction_band: float  # change of the differential pressure that friction of brake, hose and strap can hide, Pa
    sure: float  # time of the same sample after which a sensor that does not fit the valve is frozen, s
    patience: float  # the same of one that bears too much, s
    asleep: float  # time within which a driven joint moves by a count, s
    held: float  # the same by more than noise, s


def patient(friction_band: float, builds: float, lsb: float, sure: float, patience: float) -> Limits:
    """Limits of a joint whose valve, fully open, builds up the friction band within so many seconds."""
    asleep = max(ASLEEP, SHAKEN + BUILDS * builds)
    return Limits(lsb, friction_band, sure, patience, asleep, max(HELD, 2.0 * asleep))


class Memory(NamedTuple):
    """What the joint has borne since its angle last changed, and for how long it has not followed."""

    least: float = 0.0  # differential pressure since the angle last changed, Pa
    most: float = 0.0
    net_least: float = 0.0  # the same less what joints that turn would hold off, Pa
    net_most: float = 0.0
    asleep: float = 0.0
    anchor: float = nan  # where it was when it last moved by more than noise, rad
    held: float = 0.0


@law
def blocked(limits, memory, now):
    """Whether the angle stays while the joint bears more than friction hides."""
    return now.same_angle > limits.sure and memory.most - memory.least > limits.friction_band


@law
def find(limits, memory, doubts, before, now, sample):
    """Follow what the joint bears, and how long it stays where it is; traces are those before and after the sample."""
    same, p, net = unchanged(before, sample), sample.averaged_pressure, sample.averaged_pressure - sample.others
    least = min(memory.least, p) if same else p
    most = max(memory.most, p) if same else p
    # Shaken by the others, or not as much as is believed: it is blocked if it bears both.
    net_least = min(memory.net_least, net) if same else net
    net_most = max(memory.net_most, net) if same else net
    borne = min(most - least, net_most - net_least)
    driven = sample.level >= AIR and abs(sample.demand - sample.angle) > DRIVEN
    asleep = lasted(memory.asleep, same and driven, sample.elapsed)
    near = abs(sample.angle - memory.anchor) <= MOVING * limits.lsb
    anchor = memory.anchor if near else sample.angle
    held = lasted(memory.held, anchor == memory.anchor and driven, sample.elapsed)
    after = Memory(least, most, net_least, net_most, asleep, anchor, held)
    stays, brisk = now.same_angle > limits.sure, now.step > BRISK * limits.lsb
    frozen = (
        (doubts.wrong and not doubts.any and blocked(limits, after, now))
        or (stays and (brisk or (doubts.angle and doubts.suspect)))
        or asleep >= limits.asleep
        or held >= limits.held
        or (now.same_angle >= limits.patience and borne > BEYOND * limits.friction_band)
    )
    return after, FAULT if frozen else 0
