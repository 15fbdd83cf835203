"""The supply of the whole machine: too high, or lost."""

from typing import NamedTuple

from layflat.jit import law
from layflat.rig.safety.detectors.sample import AIR, counted, lasted
from layflat.rig.safety.faults import Fault

TOO_HIGH, LOST, SAMPLES = int(Fault.OVER_PRESSURE), int(Fault.SUPPLY_LOST), Fault.OVER_PRESSURE.cycles

DIPS = 3  # samples of low pressure after which a supply is lost: as long as valves are open, hoses empty into its line


class Limits(NamedTuple):
    """What the supply is judged by."""

    low: float  # absolute, Pa, as the next
    high: float
    patience: float  # how long the ripple of several joints may be gone at once, s


class Memory(NamedTuple):
    """Samples above and below the limits, and for how long no joint has had a ripple (s)."""

    above: float = 0.0
    below: float = 0.0
    still: float = 0.0


@law
def find(limits, memory, supply, all_still, elapsed, level):
    """Judge the supply (absolute, Pa); that all of several joints lack their ripple is not a fault of theirs."""
    above = counted(memory.above, not supply < limits.high)
    if above >= SAMPLES:
        return Memory(above, memory.below, memory.still), TOO_HIGH
    below = counted(memory.below, level >= AIR and supply < limits.low)
    still = lasted(memory.still, level >= AIR and all_still, elapsed)
    return Memory(above, below, still), LOST if still >= limits.patience or below >= DIPS else 0
