"""An angle sensor that is open or shorted: its converter is at an end of its range."""

from typing import NamedTuple

from layflat.jit import law
from layflat.rig.safety.detectors.sample import counted
from layflat.rig.safety.faults import Fault

FAULT, SAMPLES = int(Fault.ANGLE_AT_RAIL), Fault.ANGLE_AT_RAIL.cycles


class Limits(NamedTuple):
    """Angles at or beyond which the sensor is at its rail, rad."""

    low: float
    high: float


@law
def sound(limits, angle):
    """Whether an angle (rad) lies between the rails."""
    return limits.low < angle < limits.high


@law
def find(limits, before, sample):
    """Count samples at the rail, with or without air, on from those before."""
    run = counted(before, not sound(limits, sample.angle))
    return run, FAULT if run >= SAMPLES else 0
