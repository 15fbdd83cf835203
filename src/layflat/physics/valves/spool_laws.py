"""The spool of a proportional valve: an oscillator with dry friction between hard stops, and flow through its ports.

| symbol | meaning | unit |
|---|---|---|
| x, v | opening or mean opening (-1..1; positive: hose A to supply, hose B to exhaust), and its rate | 1, 1/s |
| u, du | opening that the solenoid commands (with dither) in the middle of a step, half its change | 1 |
| wn | natural frequency | rad/s |
| zeta | damping ratio | 1 |
| f | kinetic friction, as the change of u that it balances | 1 |
| F | friction at a speed, likewise; f throughout, or f (1 + s/(1 + (v/v_s)^2)) as in physics/friction/stribeck.py | 1 |
| o | overlap: the fraction of the stroke in which a land covers its port | 1 |
| C, C_0 | sonic conductance of a fully open path, leakage conductance of a closed one | m3/(s Pa) |
| U | half the range of the spool at full dither | 1 |

x'' = wn^2 (u - x) - 2 zeta wn x' - wn^2 F sign(x').

A path has C_0 + (C - C_0) (x - o) / (1 - o) where x is over o, else C_0. A model that steps in milliseconds needs the
average over the dither. A sine of amplitude A opens each path by A / pi on average over a period, while the spool's
mean position is in the middle. A uniform distribution between -U and U has the same average if U is 4 A / pi, and the
mean in closed form. Dither overcomes the spool's friction: the averaged valve has none.
"""

from math import pi
from typing import Any, NamedTuple

from layflat.jit import by_kind, law
from layflat.lanes import select
from layflat.physics.friction.stribeck import falling_share
from layflat.physics.ramp import QUOTIENT_FLOOR, mean_above_zero, mean_below_zero
from layflat.physics.valves.kind import MeanValve


class Spool(NamedTuple):
    """Parameters of the spool's motion (units as in the module's table)."""

    natural_frequency: float  # wn, rad/s
    damping_ratio: float  # zeta
    friction: float  # f, as a change of the command


class SpoolState(NamedTuple):
    """State of a spool: opening (-1..1), and its rate (1/s)."""

    opening: float  # x, -1..1
    rate: float  # v, 1/s


class StictionSpool(NamedTuple):
    """Parameters of a spool with static above kinetic friction: f, s and 1/v_s^2 of the module's table."""

    natural_frequency: float
    damping_ratio: float
    friction: float
    excess: float
    per_velocity_squared: float


@law
def _rate_after(spool, u, x, v, grip, h):
    """Return the rate of a moving spool after h, against a friction `grip` with a sign; reversal is not considered."""
    wn = spool.natural_frequency
    a = h * wn * (spool.damping_ratio + 0.25 * h * wn)
    return ((1.0 - a) * v + h * wn * wn * (u - x - grip)) * (1.0 / (1.0 + a))


@law
def _same_friction(spool, u, x, v, h):  # noqa: ARG001  (signature of all spools)
    return spool.friction


@law
def _friction_at(spool, speed):
    return spool.friction * falling_share(spool.excess, spool.per_velocity_squared, speed)


@law
def _mean_friction(spool, u, x, v, h):
    """Return the friction at the mean speed of a step, up to rest; the speed is computed with the initial friction."""
    sign = select(v > 0.0, 1.0, -1.0)
    after = _rate_after(spool, u, x, v, sign * _friction_at(spool, abs(v)), h)
    return _friction_at(spool, 0.5 * (abs(v) + max(sign * after, 0.0)))


@law
def _same_hold(spool):
    return spool.friction


@law
def _static_hold(spool):
    return spool.friction * (1.0 + spool.excess)


sliding_friction = by_kind({Spool: _same_friction, StictionSpool: _mean_friction})
holding_friction = by_kind({Spool: _same_hold, StictionSpool: _static_hold})


@law
def _slide(spool, u, x, v, h):
    """Return opening and rate of a moving spool after h, or at the instant of rest, and the remaining time."""
    f = sliding_friction(spool, u, x, v, h)
    after = _rate_after(spool, u, x, v, select(v > 0.0, f, -f), h)
    reverses = v * after <= 0.0
    used = select(reverses, h * abs(v) / (abs(v) + abs(after) + QUOTIENT_FLOOR), h)
    after = select(reverses, 0.0, after)
    return x + 0.5 * used * (v + after), after, h - used


@law
def _release(spool, u_0, u_1, x, remaining_time, h):
    """Return opening and rate of a spool that starts from rest, after the remaining time of a step h.

    u goes linearly from u_0 to u_1. It moves as far as the pull exceeds friction. The effect of damping grows with the
    remaining time: exact for a whole step, linear in between, to second order. Friction falls with the square of a
    speed that is itself of second order here: static friction is used throughout.
    """
    wn, f = spool.natural_frequency, holding_friction(spool)
    sign = select(u_0 + u_1 > 2.0 * x, 1.0, -1.0)
    excess = sign * mean_above_zero(sign * (u_0 - x) - f, sign * (u_1 - x) - f)
    a = h * wn * (spool.damping_ratio + 0.25 * h * wn)
    after = remaining_time * (wn * wn) * excess * (1.0 - remaining_time * (a / (h * (1.0 + a))))
    return x + 0.5 * remaining_time * after, after


@law
def advance_spool(spool, u, du, x, v, h):
    """Return opening and rate after a step of h seconds in which the command goes linearly from u - du to u + du.

    Implicit midpoint, split where the spool comes to rest, so that it is of second order through reversals and
    sticks exactly. A spool that reaches a stop stays there until it is pulled away.
    """
    x, v, left = _slide(spool, u, x, v, h)
    moved, rate = _release(spool, u + du - du * left * (2.0 / h), u + du, x, left, h)
    x, v = select(left > 0.0, moved, x), select(left > 0.0, rate, v)
    v = select(x >= 1.0, min(v, 0.0), v)
    v = select(x <= -1.0, max(v, 0.0), v)
    return min(max(x, -1.0), 1.0), v


@law
def centred(valve):  # noqa: ARG001  (signature of all valves)
    """Return the state of a spool at rest in the middle."""
    return SpoolState(0.0, 0.0)


@law
def spool_opening(valve, state):  # noqa: ARG001
    """Return the opening of the spool, -1..1."""
    return state.opening


@law
def path_conductance(valve, x):
    """Return the conductance of the path that a positive x opens, m3/(s Pa)."""
    opening = max(x - valve.overlap, 0.0) * (1.0 / (1.0 - valve.overlap))
    return valve.leakage + (valve.conductance - valve.leakage) * opening


@law
def mean_conductances(valve, x_0, x_1):
    """Return the mean conductances of the paths that a positive and that a negative x opens, m3/(s Pa).

    x moves linearly from x_0 to x_1.
    """
    o = valve.overlap
    per_opening = (valve.conductance - valve.leakage) * (1.0 / (1.0 - o))
    fills, vents = mean_above_zero(x_0 - o, x_1 - o), mean_below_zero(x_0 + o, x_1 + o)
    return valve.leakage + per_opening * fills, valve.leakage + per_opening * vents


class MeanSpool(NamedTuple):
    """Parameters of a spool valve with its driver, averaged over the dither."""

    spool: Spool
    conductance: float  # C, m3/(s Pa)
    leakage: float  # C_0, m3/(s Pa)
    critical_ratio: float  # critical pressure ratio
    laminar_slope: float  # slope of the flow near the pressure ratio 1
    overlap: float  # o, fraction of the stroke
    centre_voltage: float  # V
    volts_to_full: float  # V
    dither_range: float  # U at full dither
    dither_frequency: float  # Hz
    delay: float  # from the command to the spool, s


class DitherFraction(NamedTuple):
    """Fraction of the dither that is present, 0 to 1."""

    dither: float


def average_over_dither(valve: Any) -> MeanSpool:
    """Return the parameters of a spool valve averaged over its dither."""
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
    """Return the state after a step of h seconds, and the mean conductances of the paths that fill and vent hose A."""
    x, rate = advance_spool(valve.spool, command, 0.0, state.opening, state.rate, h)
    middle, U = 0.5 * (x + state.opening), wave.dither * valve.dither_range
    fills, vents = mean_conductances(valve, middle - U, middle + U)
    # The averaged spool may exceed full opening, unlike a real one.
    return SpoolState(x, rate), min(fills, valve.conductance), min(vents, valve.conductance)


@law
def full_dither(valve, t, h):  # noqa: ARG001  (signature of all valves)
    """Return the full dither."""
    return DitherFraction(1.0)


@law
def weaken_mean_dither(valve, wave, share):  # noqa: ARG001
    """Return a fraction `share` of the averaged dither."""
    return DitherFraction(share * wave.dither)


MEAN_LAWS = MeanValve(
    averaged=average_over_dither,
    parameter_type=MeanSpool,
    at_rest=centred,
    move=move_mean,
    opening=spool_opening,
    start_wave=full_dither,
    weaken_wave=weaken_mean_dither,
)
