"""A joint beyond its working stroke."""

from typing import NamedTuple

from layflat.jit import law
from layflat.rig.safety.detectors import rail
from layflat.rig.safety.detectors.sample import MOTION, counted
from layflat.rig.safety.faults import Fault

FAULT = int(Fault.OUTSIDE_STROKE)


class Limits(NamedTuple):
    """Angle (rad) on either side beyond which a joint is outside; so many samples are enough."""

    stroke: float
    samples: float


class Memory(NamedTuple):
    """Samples outside."""

    run: float


FRESH = Memory(0.0)


@law
def find(limits, memory, rails, sample):
    """Count samples outside. Past the stroke comes the sensor's rail: a joint that gets there is still outside."""
    beyond = abs(sample.angle) > limits.stroke if rail.sound(rails, sample.angle) else memory.run > 0.0
    count = counted(memory.run, sample.level >= MOTION and beyond)
    return Memory(count), FAULT if count >= limits.samples else 0
