"""Whether a sensor may be frozen: until that is known, what is computed from it says nothing of the valve."""

from math import inf, isfinite
from typing import NamedTuple

from layflat.jit import law
from layflat.physics.air_balance import SMOOTHING
from layflat.rig.safety.detectors.sample import AIR, lasted

STIRS = 0.02  # for which air moves around a joint that stands still; that of a burst hose is wrong by then, s
MOVING = 2.5  # counts from one sample to the next that are motion, not noise


class Limits(NamedTuple):
    """What doubts arise from."""

    grain: float  # one count of the angle's converter, or noise if that is more, rad
    lively: float  # 1 if a sound pressure sensor changes all the time, else 0
    residual: float  # of air, as an opening of the valve; infinite where air can't be watched: a joint of one hose
    doubtful: float  # of the same sample, after which a sensor may be frozen, s
    warmth: float = 0.0  # residual per speed of air that keeps the warmth of its compression; 0: joints are slow, s/rad
    filling: float = 0.0  # the same per opening of the valve, of air that keeps the warmth with which it flows in, 1
    still: float = inf  # residual of a joint that stands still, besides that


class Memory(NamedTuple):
    """For how long the pressure has been the same (s), and 1 where a sensor is suspect."""

    same_pressure: float = 0.0
    suspect: float = 0.0
    speed: float = 0.0  # of the joint over the time in which the residual is averaged, rad/s
    opening: float = 0.0  # of its valve, likewise
    stirs: float = 0.0  # for how long its air has moved although it stands still, s


class Doubt(NamedTuple):
    """What is not certain in a cycle."""

    angle: bool  # the angle stands still although the joint moved
    any: bool  # the angle or the pressure may be frozen
    wrong: bool  # the air does what the valve was not asked for, or a sensor is wrong
    suspect: bool  # a sensor may be frozen, and the air has been wrong since
    moves: bool  # by its air the joint moves, while its angle stays


@law
def averaged(before, value, elapsed):
    """A number averaged as the residual of the air is; what is not a number changes nothing."""
    after = before + min(elapsed / SMOOTHING, 1.0) * (value - before)
    return after if isfinite(after) else before


@law
def doubt(limits, memory, before, now, sample):
    """Memory and doubts after a sample, with the traces before and after it."""
    airy = sample.level >= AIR
    repeated = airy and limits.lively > 0.0 and sample.pressure == before.pressure_1
    same_pressure = lasted(memory.same_pressure, repeated, sample.elapsed)
    angle = now.same_angle > limits.doubtful and now.step > MOVING * limits.grain
    either = same_pressure > limits.doubtful or angle
    speed = averaged(memory.speed, sample.velocity, sample.elapsed)
    opening = averaged(memory.opening, sample.opening, sample.elapsed)
    # With one temperature a hose that a joint compresses, or that is filled, gains less pressure than in truth.
    warm, filled = -limits.warmth * speed, limits.filling * opening
    most, least = max(warm, 0.0) + max(filled, 0.0), min(warm, 0.0) + min(filled, 0.0)
    beyond = sample.residual > limits.residual + most or sample.residual < least - limits.residual
    wrong = airy and sample.alone > 0.0 and beyond
    suspect = either and (wrong or memory.suspect > 0.0)
    stirred = abs(sample.residual) > limits.still + limits.filling * abs(opening)
    stands = airy and sample.alone > 0.0 and now.same_angle > limits.doubtful
    stirs = lasted(memory.stirs, stands and stirred, sample.elapsed)
    after = Memory(same_pressure, 1.0 if suspect else 0.0, speed, opening, stirs)
    return after, Doubt(angle, either, wrong, suspect, stirs > STIRS)
