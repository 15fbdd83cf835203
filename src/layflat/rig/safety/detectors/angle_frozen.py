"""An angle that does not change although it should: its sensor is frozen, or the joint is blocked."""

from math import inf, nan
from typing import NamedTuple

from layflat.jit import law
from layflat.rig.safety.detectors.doubt import MOVING
from layflat.rig.safety.detectors.sample import AIR, lasted, unchanged
from layflat.rig.safety.faults import Fault

FAULT = int(Fault.ANGLE_FROZEN)
BRISK = 5.5  # counts in a cycle after which no joint stands still at once: 40 deg/s as built in
# Of the differential pressure that friction can hide: so much, what others hold off left out, a joint never bears
# without a motion of one count. Sound ones at rest, shaken by another, bear 1.6 in an hour.
BEYOND = 1.9
# Errors of a joint that is driven, while its valve is open (so far at least) and while it is centred, rad: by less
# friction may hold it. A centre may be off by 8 % of full opening.
DRIVEN, PARKED, OPEN = 0.09, 0.2, 0.12
ASLEEP = 0.29  # a driven joint moves by a count within this time; sound ones, shaken by another, took 0.2 s, s
HELD = 0.6  # the same by more than noise, which may go to and fro by a count, s
TRAVELS = 0.01  # way that a joint would have gone by what friction can't hold, although its angle stays, rad


class Limits(NamedTuple):
    """What an angle that stays is judged by."""

    grain: float  # one count of the angle's converter, or noise if that is more, rad
    friction_band: float  # change of the differential pressure that friction of brake, hose and strap can hide, Pa
    cycle: float  # time between two samples that are in time, s
    sure: float  # time of the same sample after which a sensor that does not fit the valve is frozen, s
    patience: float  # the same of one that bears too much, or whose noise never leaves it at one sample, s
    noisy: float = 0.0  # 1 if noise never does
    lands: float = 0.0  # error up to which the control law may bring the joint to rest at once, rad
    fades: float = 0.0  # time at rest until the averaged pressure has none of what braked the joint, s
    rests: float = 0.0  # way in a cycle from which the joint may be at rest in the next, rad
    hides: float = inf  # differential pressure that friction may hold at rest; infinite: no torque follows from it, Pa


class Borne(NamedTuple):
    """Differential pressure since the angle last changed, Pa."""

    least: float = 0.0
    most: float = 0.0


class Memory(NamedTuple):
    """What the joint has borne since its angle last changed, and for how long it has not followed."""

    whole: Borne = Borne()
    net: Borne = Borne()  # less what gravity and joints that turn would hold off, whatever the payload
    rate: float = 0.0  # that it would have got by what friction can't hold, rad/s
    travel: float = 0.0  # how far it would have gone so, rad
    asleep: float = 0.0
    anchor: float = nan  # where it was when it last moved by more than noise, rad
    held: float = 0.0


@law
def _borne(before, low, high, goes_on):
    # The least that a pressure which is known to lie between two has swung.
    return Borne(min(before.least, high) if goes_on else high, max(before.most, low) if goes_on else low)


@law
def _swing(borne):
    return borne.most - borne.least


@law
def _pushed(low, high, hides):
    # What friction can't hold, whatever is carried.
    return low - hides if low > hides else (high + hides if high < -hides else 0.0)


@law
def blocked(limits, memory, now):
    """Whether the angle stays while the joint bears more than friction hides."""
    return now.same_angle > limits.sure and _swing(memory.whole) > limits.friction_band


@law
def find(limits, memory, doubts, before, now, sample):
    """Follow what the joint bears, and how long it stays where it is; traces are those before and after the sample."""
    same, p = unchanged(before, sample), sample.averaged_pressure
    bears = same and before.same_angle >= limits.fades
    # Shaken by the others, or not as much as is believed: it is blocked if it bears all of them.
    light, heavy = p - sample.others_light, p - sample.others_heavy
    low, high = min(light, heavy), max(light, heavy)
    whole, net = _borne(memory.whole, p, p, bears), _borne(memory.net, low, high, bears)
    borne = min(_swing(whole), _swing(net))
    # In uneven cycles it is not known well enough when the pressure was what it was.
    pushed = _pushed(low, high, limits.hides) if bears and sample.alone > 0.0 else 0.0
    onward = memory.rate if pushed * memory.rate > 0.0 else 0.0
    rate = onward + sample.elapsed * pushed / sample.inertia
    travel = (memory.travel if pushed * memory.travel > 0.0 else 0.0) + sample.elapsed * rate
    driven = sample.level >= AIR and abs(sample.demand - sample.angle) > DRIVEN
    drives = driven and (abs(sample.opening) > OPEN or abs(sample.demand - sample.angle) > PARKED)
    counts = sample.elapsed if drives else 0.0
    asleep = lasted(memory.asleep, same and driven, counts)
    near = abs(sample.angle - memory.anchor) <= MOVING * limits.grain
    anchor = memory.anchor if near else sample.angle
    held = lasted(memory.held, anchor == memory.anchor and driven, counts)
    after = Memory(whole, net, rate, travel, asleep, anchor, held)
    stays = now.same_angle > limits.sure
    # By both: a sample after a late one is further from it, and what came late was sampled some time before.
    landed = abs(sample.demand - sample.angle) < limits.lands
    brisk = min(now.step, now.speed * limits.cycle) > max(BRISK * limits.grain, limits.rests) and not landed
    frozen = (
        (doubts.wrong and not doubts.any and blocked(limits, after, now))
        or (stays and (brisk or (doubts.angle and doubts.suspect)))
        or (stays and (doubts.moves or abs(travel) > TRAVELS))
        or asleep >= ASLEEP
        or held >= HELD
        or (now.same_angle >= limits.patience and (limits.noisy > 0.0 or borne > BEYOND * limits.friction_band))
    )
    return after, FAULT if frozen else 0
