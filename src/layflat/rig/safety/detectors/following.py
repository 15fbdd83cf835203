"""A joint that is left behind by its demand, or that hardly moves although it has most of the pressure there is."""

from math import nan
from typing import NamedTuple

from layflat.jit import law
from layflat.rig.safety.detectors.sample import AIR, lasted
from layflat.rig.safety.faults import Fault

FAULT = int(Fault.FOLLOWING_ERROR)
# Beside its goal by so much (rad), with so much of the supply's gauge pressure and slower than this (rad/s) for so long
# (s), something holds a joint back: alone it would have left all of that within hundredths of a second.
BESIDE, STRAINS, SLOW, LONG = 0.09, 0.6, 0.35, 0.3
EXPLAINED = 0.25  # of the time counts where another joint that brakes would explain it: it may do so for 0.15 s


class Limits(NamedTuple):
    """How far a joint may be from where it should be."""

    error: float  # of a joint that does not move, rad
    time: float  # what the error may grow by with speed, s
    demand_speed: float  # at which demands may go on for long, rad/s
    patience: float  # s
    strained: float  # differential pressure with which no joint is slow, Pa
    long: float = LONG  # for which one is slow in spite of it that is held back, s


class Memory(NamedTuple):
    """Where the joint should be by now, and for how long it has not been there."""

    reach: float = nan  # rad; not a number at first
    off: float = 0.0  # time for which it has been too far from there, s
    strained: float = 0.0  # time for which it has been slow in spite of its pressure, s


@law
def reached(limits, reach, angle, demand, elapsed):
    """Where a joint should be: that goes to the demand as fast as demands may for long, or as the joint, if faster.

    So a step is not an error, and a joint that is ahead of its time is none either.
    """
    way = limits.demand_speed * elapsed
    start = reach if reach == reach else angle  # noqa: PLR0124  # not a number: none yet
    return min(max(start + way, angle), demand) if demand >= start else max(min(start - way, angle), demand)


@law
def allowed(limits, velocity, lead):
    """Error that a joint may have, rad."""
    return limits.error + limits.time * abs(velocity) + lead


@law
def find(limits, memory, sample):
    """Follow where the joint should be, and for how long it has been too far from there."""
    airy = sample.level >= AIR
    reach = reached(limits, memory.reach, sample.angle, sample.demand, sample.elapsed) if airy else nan
    error = abs(sample.angle - reach)
    off = lasted(memory.off, airy and error > allowed(limits, sample.velocity, sample.lead), sample.elapsed)
    beside = airy and abs(sample.angle - sample.demand) > BESIDE
    p = sample.averaged_pressure
    strains = beside and abs(p) > limits.strained and abs(sample.velocity) < SLOW
    # Another joint that brakes may hold this one for a while.
    alone = min(abs(p - sample.others_light), abs(p - sample.others_heavy)) > limits.strained
    strained = lasted(memory.strained, strains, sample.elapsed if alone else EXPLAINED * sample.elapsed)
    return Memory(reach, off, strained), FAULT if off >= limits.patience or strained >= limits.long else 0
