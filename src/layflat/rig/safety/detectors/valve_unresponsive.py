"""Air that does not do what the valve was told: a stuck spool, a burst or a kinked hose."""

from typing import NamedTuple

from layflat.jit import law
from layflat.rig.safety.detectors.sample import AIR, lasted
from layflat.rig.safety.faults import Fault

FAULT = int(Fault.VALVE_UNRESPONSIVE)


class Limits(NamedTuple):
    """What the air is judged by."""

    ripple: float
    """Amplitude below which there is no air (rule 1 of the controller), Pa; zero where the dither can't be seen."""
    patience: float
    """How long the ripple may be gone, s."""


class Memory(NamedTuple):
    """For how long the ripple has been gone, s."""

    quiet: float


FRESH = Memory(0.0)


@law
def find(limits, memory, doubts, blocked, now, sample):
    """Whether the air is wrong beyond doubt and the joint not blocked, or the dither's ripple is gone."""
    gone = sample.level >= AIR and sample.alone > 0.0 and now.ripple < limits.ripple
    quiet = lasted(memory.quiet, gone, sample.elapsed)
    wrong = doubts.wrong and not doubts.any and not blocked
    return Memory(quiet), FAULT if wrong or quiet >= limits.patience else 0
