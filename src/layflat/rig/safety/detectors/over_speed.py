"""A joint that turns faster than it may."""

from layflat.jit import law
from layflat.rig.safety.detectors import rail
from layflat.rig.safety.detectors.sample import MOTION, counted
from layflat.rig.safety.faults import Fault

FAULT, SAMPLES = int(Fault.OVER_SPEED), Fault.OVER_SPEED.cycles


@law
def find(limit, before, rails, trace, sample):
    """Count samples faster than a limit (rad/s), of a sensor that is not at its rails, on from those before.

    `trace` is that before the sample.
    """
    step = abs(sample.angle - trace.angle)
    # Of a joint that speeds up, the mean since the last sample tells half a cycle late.
    gained = 0.5 * (step - trace.step)
    speed = (step + (gained if gained > 0.0 else 0.0)) / sample.elapsed
    both_sound = rail.sound(rails, sample.angle) and rail.sound(rails, trace.angle)
    run = counted(before, sample.level >= MOTION and both_sound and speed > limit)
    return run, FAULT if run >= SAMPLES else 0
