"""A differential pressure that hoses are not made for, or one that is not a number."""

from typing import NamedTuple

from layflat.jit import law
from layflat.rig.safety.detectors.sample import counted
from layflat.rig.safety.faults import Fault

FAULT = int(Fault.OVER_PRESSURE)


class Limits(NamedTuple):
    """Of the differential pressure on either side, Pa; so many samples are enough."""

    pressure: float
    samples: float


class Memory(NamedTuple):
    """Samples beyond the limit."""

    run: float


FRESH = Memory(0.0)


@law
def find(limits, memory, sample):
    """Count samples beyond the limit, with or without air."""
    count = counted(memory.run, not (-limits.pressure < sample.pressure < limits.pressure))
    return Memory(count), FAULT if count >= limits.samples else 0
