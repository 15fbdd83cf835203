"""Flow through the ports of a spool valve by the place of the spool, and on average over its dither.

A path has C_0 + (C - C_0) (x - o) / (1 - o) where x is over o, else C_0. The average is what a model needs that steps
in milliseconds.

A sine of amplitude A opens each path by A / pi on average over a period, while the spool's mean position is in the
middle. A spool that is anywhere between -U and U alike does so if U is 4 A / pi, and gives the mean in closed form.
Dither carries the spool over its friction: there is none here.

| symbol | meaning | unit |
|---|---|---|
| x | opening, or mean opening, positive: hose A to supply, hose B to exhaust | 1 |
| o | overlap: the share of the stroke in which a land covers its port | 1 |
| C, C_0 | sonic conductance of a fully open path, leakage conductance of a closed one | m3/(s Pa) |
| U | half of the range in which the spool is, with all of the dither | 1 |
"""

from math import pi
from typing import Any, NamedTuple

from layflat.jit import law
from layflat.physics.ramp import mean_above_zero, mean_below_zero
from layflat.physics.valves.kind import MeanValve
from layflat.physics.valves.spool_motion import Spool, SpoolState, advance_spool, centred, spool_opening


@law
def path_conductance(valve, x):
    """Conductance of the path that a positive x opens, m3/(s Pa)."""
    share = max(x - valve.overlap, 0.0) * (1.0 / (1.0 - valve.overlap))
    return valve.leakage + (valve.conductance - valve.leakage) * share


@law
def mean_conductances(valve, x_0, x_1):
    """Mean conductances of the paths that a positive and that a negative x opens, m3/(s Pa).

    x moves evenly from x_0 to x_1.
    """
    o = valve.overlap
    per_opening = (valve.conductance - valve.leakage) * (1.0 / (1.0 - o))
    fills, vents = mean_above_zero(x_0 - o, x_1 - o), mean_below_zero(x_0 + o, x_1 + o)
    return valve.leakage + per_opening * fills, valve.leakage + per_opening * vents


class MeanSpool(NamedTuple):
    """Parameters of a spool valve with its driver, on average."""

    spool: Spool
    conductance: float
    leakage: float
    critical_ratio: float
    laminar_slope: float
    overlap: float
    centre_voltage: float
    volts_to_full: float
    dither_range: float
    dither_frequency: float
    delay: float


class Share(NamedTuple):
    """Share of the dither that there is, 0 to 1."""

    dither: float


def averaged(valve: Any) -> MeanSpool:
    """Parameters of a spool valve on average over its dither."""
    return MeanSpool(
        Spool(valve.spool.natural_frequency, valve.spool.damping_ratio, 0.0),
        valve.conductance,
        valve.leakage,
        valve.critical_ratio,
        valve.laminar_slope,
        valve.overlap,
        valve.centre_voltage,
        valve.volts_to_full,
        valve.dither_amplitude * (4.0 / pi),
        valve.dither_frequency,
        valve.delay,
    )


@law
def move_mean(valve, state, command, wave, h):
    """State after a step of h seconds, and the mean conductances of the paths that fill and that vent hose A."""
    x, rate = advance_spool(valve.spool, command, 0.0, state.opening, state.rate, h)
    middle, U = 0.5 * (x + state.opening), wave.dither * valve.dither_range
    fills, vents = mean_conductances(valve, middle - U, middle + U)
    # A model's spool may swing out further than a real one.
    return SpoolState(x, rate), min(fills, valve.conductance), min(vents, valve.conductance)


@law
def all_of_it(valve, t, h):  # noqa: ARG001  (as of all valves)
    """All of the dither."""
    return Share(1.0)


@law
def weaken_share(valve, wave, share):  # noqa: ARG001
    """A share of it."""
    return Share(share * wave.dither)


MEAN = MeanValve(
    averaged=averaged,
    parameter_type=MeanSpool,
    at_rest=centred,
    move=move_mean,
    opening=spool_opening,
    start_wave=all_of_it,
    weaken_wave=weaken_share,
)
