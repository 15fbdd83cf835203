"""The supply of the whole machine: too high, or lost."""

from typing import NamedTuple

from layflat.jit import law
from layflat.rig.safety.detectors.sample import AIR, counted, lasted
from layflat.rig.safety.faults import Fault

TOO_HIGH, LOST = int(Fault.OVER_PRESSURE), int(Fault.SUPPLY_LOST)


class Limits(NamedTuple):
    """What the supply is judged by."""

    low: float
    """Absolute, Pa, as the next."""
    high: float
    samples: float
    """At or above the upper limit that are enough."""
    dips: float
    """Samples below the lower one that are enough: while valves are open, hoses empty into the line."""
    patience: float
    """How long the ripple of several joints may be gone at once, s."""


class Memory(NamedTuple):
    """Samples above and below the limits, and for how long no joint has had a ripple (s)."""

    above: float
    below: float
    still: float


FRESH = Memory(0.0, 0.0, 0.0)


@law
def find(limits, memory, supply, all_still, elapsed, level):
    """Judge the supply (absolute, Pa); that all of several joints lack their ripple is no fault of theirs."""
    above = counted(memory.above, not supply < limits.high)
    if above >= limits.samples:
        return Memory(above, memory.below, memory.still), TOO_HIGH
    below = counted(memory.below, level >= AIR and supply < limits.low)
    still = lasted(memory.still, level >= AIR and all_still, elapsed)
    return Memory(above, below, still), LOST if still >= limits.patience or below >= limits.dips else 0
