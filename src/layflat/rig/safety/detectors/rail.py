"""An angle sensor that is open or shorted: its converter is at an end of its range."""

from typing import NamedTuple

from layflat.jit import law
from layflat.rig.safety.detectors.sample import counted
from layflat.rig.safety.faults import Fault

FAULT = int(Fault.ANGLE_AT_RAIL)


class Limits(NamedTuple):
    """At or beyond these angles (rad) the sensor is at its rail; so many samples are enough."""

    low: float
    high: float
    samples: float


class Memory(NamedTuple):
    """Samples at the rail."""

    run: float


FRESH = Memory(0.0)


@law
def sound(limits, angle):
    """Whether an angle (rad) lies between the rails."""
    return limits.low < angle < limits.high


@law
def find(limits, memory, sample):
    """Count samples at the rail, with or without air."""
    count = counted(memory.run, not sound(limits, sample.angle))
    return Memory(count), FAULT if count >= limits.samples else 0
