"""A pressure sensor that repeats itself."""

from typing import NamedTuple

from layflat.jit import law
from layflat.rig.safety.faults import Fault

FAULT = int(Fault.PRESSURE_FROZEN)


class Limits(NamedTuple):
    """How long a sensor may report the same, s."""

    patience: float  # at most
    sure: float  # where it does not fit what the valve was told


@law
def find(limits, same_pressure, suspect):
    """Whether a pressure that has been the same for some time (s) is frozen; it needs no memory of its own."""
    return FAULT if same_pressure >= limits.patience or (suspect and same_pressure > limits.sure) else 0
