"""Air that does not do what the valve was told: a stuck spool, a burst or a kinked hose."""

from typing import NamedTuple

from layflat.jit import law
from layflat.rig.safety.detectors.sample import AIR, lasted
from layflat.rig.safety.faults import Fault

FAULT = int(Fault.VALVE_UNRESPONSIVE)
SHOWS = 0.6  # of the supply, gauge: differential pressure up to which air still flows enough for dither to show


class Limits(NamedTuple):
    """What the air is judged by."""

    ripple: float  # amplitude below which there is no air (controller's rule 1), Pa; zero where no dither is seen
    patience: float  # how long the ripple may be gone, s
    shows: float  # differential pressure up to which there is a ripple, Pa
    uncut: float  # opening up to which the spool has room for its dither


@law
def find(limits, before, doubts, blocked, now, sample):
    """Time for which the ripple has been gone (s), on from that before; air that is wrong beyond doubt is at fault.

    Not where the joint is blocked: then it is that which the air does not fit.
    """
    shows = abs(sample.averaged_pressure) < limits.shows and abs(sample.opening) < limits.uncut
    gone = sample.level >= AIR and sample.alone > 0.0 and now.ripple < limits.ripple
    quiet = lasted(before, gone, sample.elapsed if shows else 0.0)
    wrong = doubts.wrong and not doubts.any and not blocked
    return quiet, FAULT if wrong or quiet >= limits.patience else 0
