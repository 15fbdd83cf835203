"""A differential pressure that hoses are not made for, or one that is not a number."""

from layflat.jit import law
from layflat.rig.safety.detectors.sample import counted
from layflat.rig.safety.faults import Fault

FAULT, SAMPLES = int(Fault.OVER_PRESSURE), Fault.OVER_PRESSURE.cycles


@law
def find(limit, before, sample):
    """Count samples beyond a limit (Pa) on either side, with or without air, on from those before."""
    run = counted(before, not (-limit < sample.pressure < limit))
    return run, FAULT if run >= SAMPLES else 0
