"""A joint that is left behind by its demand."""

from math import nan
from typing import NamedTuple

from layflat.jit import law
from layflat.rig.safety.detectors.sample import AIR, lasted
from layflat.rig.safety.faults import Fault

FAULT = int(Fault.FOLLOWING_ERROR)


class Limits(NamedTuple):
    """How far a joint may be from where it should be."""

    error: float  # of a joint that does not move, rad
    time: float  # what the error may grow by with speed, s
    demand_speed: float  # at which demands may go on for long, rad/s
    patience: float  # s


class Memory(NamedTuple):
    """Where the joint should be by now (rad; not a number at first), and for how long it has been too far from it."""

    reach: float = nan
    off: float = 0.0


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
    return Memory(reach, off), FAULT if off >= limits.patience else 0
