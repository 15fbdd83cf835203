"""A 5/3 proportional spool valve and its driver: dither moves the spool, the spool opens one path and shuts the other.

| symbol | meaning | unit |
|---|---|---|
| x | spool opening, positive: hose A to supply, hose B to exhaust | 1 |
| o | overlap: the share of the stroke in which a land covers its port | 1 |
| C | sonic conductance of a fully open path | m3/(s Pa) |
| C_0 | leakage conductance of a closed path | m3/(s Pa) |
"""

from typing import NamedTuple

from layflat.jit import law
from layflat.physics.dither import half_change, start_dither
from layflat.physics.ramp import mean_above_zero
from layflat.physics.spool import Spool, advance_spool


class SpoolValve(NamedTuple):
    """Parameters of a spool valve with its driver."""

    spool: Spool
    conductance: float
    leakage: float
    critical_ratio: float
    laminar_slope: float
    overlap: float
    centre_voltage: float
    volts_to_full: float
    dither_amplitude: float
    dither_frequency: float
    delay: float
    """From the command to the spool, s."""


class SpoolState(NamedTuple):
    """Opening of the spool, and its rate (1/s)."""

    opening: float
    rate: float


@law
def path_conductance(valve, x):
    """Conductance of the path that a positive x opens, m3/(s Pa)."""
    share = max(x - valve.overlap, 0.0) * (1.0 / (1.0 - valve.overlap))
    return valve.leakage + (valve.conductance - valve.leakage) * share


@law
def mean_conductance(valve, x_0, x_1):
    """Mean conductance of the path that a positive x opens, while x moves evenly from x_0 to x_1, m3/(s Pa)."""
    share = mean_above_zero(x_0 - valve.overlap, x_1 - valve.overlap) * (1.0 / (1.0 - valve.overlap))
    return valve.leakage + (valve.conductance - valve.leakage) * share


@law
def centred(valve):  # noqa: ARG001  (as of all valves)
    """State of a spool at rest in the middle."""
    return SpoolState(0.0, 0.0)


@law
def start_spool_wave(valve, t, h):
    """Dither of the step of h seconds that begins at t."""
    return start_dither(valve.dither_frequency, t, h)


@law
def move_spool(valve, state, command, dither, h):
    """State after a step of h seconds, and the mean conductances of the paths that fill and that vent hose A."""
    u = command + valve.dither_amplitude * dither.sine
    swing = valve.dither_amplitude * half_change(dither)
    x, rate = advance_spool(valve.spool, u, swing, state.opening, state.rate, h)
    fills, vents = mean_conductance(valve, state.opening, x), mean_conductance(valve, -state.opening, -x)
    return SpoolState(x, rate), fills, vents


@law
def spool_opening(state):
    """Opening of the spool, -1..1."""
    return state.opening
