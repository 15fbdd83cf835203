"""A joint beyond its working stroke."""

from layflat.jit import law
from layflat.rig.safety.detectors import rail
from layflat.rig.safety.detectors.sample import MOTION, counted
from layflat.rig.safety.faults import Fault

FAULT, SAMPLES = int(Fault.OUTSIDE_STROKE), Fault.OUTSIDE_STROKE.cycles


@law
def find(limit, before, rails, sample):
    """Count samples beyond a limit (rad) on either side, on from those before.

    Past the stroke comes the sensor's rail: a joint that gets there is still outside.
    """
    beyond = abs(sample.angle) > limit if rail.sound(rails, sample.angle) else before > 0.0
    run = counted(before, sample.level >= MOTION and beyond)
    return run, FAULT if run >= SAMPLES else 0
