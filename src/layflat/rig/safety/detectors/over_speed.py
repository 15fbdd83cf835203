"""A joint that turns faster than it may."""

from typing import NamedTuple

from layflat.jit import law
from layflat.rig.safety.detectors import rail
from layflat.rig.safety.detectors.sample import MOTION, counted
from layflat.rig.safety.faults import Fault

FAULT = int(Fault.OVER_SPEED)


class Limits(NamedTuple):
    """Speed (rad/s) beyond which a joint is too fast; so many samples are enough."""

    speed: float
    samples: float


class Memory(NamedTuple):
    """Samples that were too fast."""

    run: float


FRESH = Memory(0.0)


@law
def find(limits, memory, rails, trace, sample):
    """Count samples that were too fast, of a sensor that is not at its rails; `trace` is that before the sample."""
    step = abs(sample.angle - trace.angle)
    # Of a joint that speeds up, the mean since the last sample tells half a cycle late.
    gained = 0.5 * (step - trace.step)
    speed = (step + (gained if gained > 0.0 else 0.0)) / sample.elapsed
    both_sound = rail.sound(rails, sample.angle) and rail.sound(rails, trace.angle)
    count = counted(memory.run, sample.level >= MOTION and both_sound and speed > limits.speed)
    return Memory(count), FAULT if count >= limits.samples else 0
