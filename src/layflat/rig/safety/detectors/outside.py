"""A joint beyond its working stroke."""

from typing import NamedTuple

from layflat.jit import law
from layflat.rig.safety.detectors import rail
from layflat.rig.safety.detectors.sample import MOTION, counted
from layflat.rig.safety.faults import Fault

FAULT, SAMPLES = int(Fault.OUTSIDE_STROKE), Fault.OUTSIDE_STROKE.cycles
AWAY = -1.0  # of a joint that has not been inside since the air was brought


class Limits(NamedTuple):
    """Angles from mid-stroke, rad."""

    stroke: float  # beyond which a joint is outside
    rests: float = 0.0  # up to which it may lie without air; from there it is led inside
    inside: float = 0.0  # from which on it has been led inside


@law
def find(limits, before, rails, sample):
    """Count samples beyond a limit on either side, on from those before.

    Past the stroke comes the sensor's rail: a joint that gets there is still outside. Without air gravity, a fault or a
    hand takes joints to their stops, from where they are led inside.
    """
    turned, sound = abs(sample.angle), rail.sound(rails, sample.angle)
    beyond = turned > limits.stroke if sound else before > 0.0
    rests = before < 0.0 and limits.inside < turned <= limits.rests
    run = AWAY if rests else counted(max(before, 0.0), sample.level >= MOTION and beyond)
    return run, FAULT if run >= SAMPLES else 0
