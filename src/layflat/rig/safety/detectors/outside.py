"""A joint beyond its working stroke."""

from typing import NamedTuple

from layflat.jit import law
from layflat.rig.safety.detectors import rail
from layflat.rig.safety.detectors.sample import MOTION, counted
from layflat.rig.safety.faults import Fault

FAULT, SAMPLES = int(Fault.OUTSIDE_STROKE), Fault.OUTSIDE_STROKE.cycles
AWAY = -1.0  # of a joint that has not been inside since the air was brought; less by each sample past its stop


class Limits(NamedTuple):
    """Angles from mid-stroke, rad."""

    stroke: float  # beyond which a joint is outside
    rests: float  # up to which it may lie without air; from there it is led inside
    inside: float  # from which on it has been led inside
    thrown: float  # more samples for which it may be past where it may lie: others may throw it to its stop


@law
def find(limits, before, rails, sample):
    """Count samples beyond a limit on either side, on from those before.

    Past the stroke comes the sensor's rail: a joint that gets there is still outside. Without air gravity, a fault or a
    hand takes joints to their stops, from where they are led inside.
    """
    turned, sound = abs(sample.angle), rail.sound(rails, sample.angle)
    led = before < 0.0 and turned > limits.inside
    known = AWAY - before if led else max(before, 0.0)
    beyond = turned > (limits.rests if led else limits.stroke) if sound else known > 0.0
    run = counted(known, sample.level >= MOTION and beyond)
    found = run >= SAMPLES + (limits.thrown if led else 0.0)
    return AWAY - run if led else run, FAULT if found else 0
