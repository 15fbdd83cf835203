"""A valve that regulates the pressure of one chamber to a set-point, seen from outside.

| symbol | meaning | unit |
|---|---|---|
| s | set-point that the valve works towards, absolute | Pa |
| p | pressure of the chamber | Pa |
| x | opening, 1 fully towards the supply, -1 fully towards the exhaust | 1 |
| B | band: the error s - p at which a side is fully open | Pa |
| C | sonic conductance of a side that is fully open | m3/(s Pa) |

What is inside (a pilot stage, two switching valves, an amplifier) shows as a lag of first order from the command to the
set-point that the valve works towards, and as an opening in proportion to the error, up to where it is fully open.
"""

from math import exp
from typing import NamedTuple

from layflat.jit import law
from layflat.lanes import select


class Regulator(NamedTuple):
    """Parameters; the set-point is gain (command - ambient pressure) + offset above the ambient pressure."""

    gain: float
    offset: float
    lag: float
    conductance_in: float
    conductance_out: float
    band_in: float
    band_out: float
    critical_ratio: float
    laminar_slope: float


@law
def share_in(h, lag):
    """Share of the way that a lag of first order goes in a step of h seconds, exactly."""
    return 1.0 - exp(-h / lag)


@law
def asked_set_point(regulator, command, p_ambient):
    """Set-point that a command (absolute, Pa) asks for in the end, Pa."""
    return p_ambient + regulator.gain * (command - p_ambient) + regulator.offset


@law
def regulator_opening(regulator, s, p):
    """Opening at set-point s and pressure p."""
    error = s - p
    return min(max(error / select(error > 0.0, regulator.band_in, regulator.band_out), -1.0), 1.0)


@law
def regulator_conductances(regulator, s, p):
    """Conductances towards supply and exhaust at set-point s and pressure p, m3/(s Pa)."""
    x = regulator_opening(regulator, s, p)
    return regulator.conductance_in * max(x, 0.0), regulator.conductance_out * max(-x, 0.0)
