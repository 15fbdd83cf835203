"""The spool of a proportional valve: a damped oscillator with dry friction between hard stops.

| symbol | meaning | unit |
|---|---|---|
| x, v | opening (-1..1) and its rate | 1, 1/s |
| u, du | opening that the solenoid asks for (command + dither) in the middle of a step, half its change | 1 |
| wn | natural frequency | rad/s |
| zeta | damping ratio | 1 |
| f | kinetic friction, as the change of u that it can hide | 1 |
| F | friction at a speed, likewise; f throughout, or f (1 + s/(1 + (v/v_s)^2)) as in physics/friction/stribeck.py | 1 |

x'' = wn^2 (u - x) - 2 zeta wn x' - wn^2 F sign(x').
"""

from typing import NamedTuple

from layflat.jit import by_kind, law
from layflat.lanes import select
from layflat.physics.friction.stribeck import falling_share
from layflat.physics.ramp import TINY, mean_above_zero


class Spool(NamedTuple):
    """Parameters of the spool's motion (units as in the module's table)."""

    natural_frequency: float
    damping_ratio: float
    friction: float


class SpoolState(NamedTuple):
    """Opening of the spool, and its rate (1/s)."""

    opening: float
    rate: float


class StictionSpool(NamedTuple):
    """The same of a spool that holds more at rest than it slides at: f, s and 1/v_s^2 of the module's table."""

    natural_frequency: float
    damping_ratio: float
    friction: float
    excess: float
    per_velocity_squared: float


@law
def _after(spool, u, x, v, grip, h):
    # Rate of a moving spool after h, against a friction that has a sign; reversal is not looked at.
    wn = spool.natural_frequency
    a = h * wn * (spool.damping_ratio + 0.25 * h * wn)
    return ((1.0 - a) * v + h * wn * wn * (u - x - grip)) * (1.0 / (1.0 + a))


@law
def _same_friction(spool, u, x, v, h):  # noqa: ARG001  (as of all spools)
    return spool.friction


@law
def _friction_at(spool, speed):
    return spool.friction * falling_share(spool.excess, spool.per_velocity_squared, speed)


@law
def _mean_friction(spool, u, x, v, h):
    # That at the mean speed of the step, up to rest where it gets there; found with the friction at its beginning.
    way = select(v > 0.0, 1.0, -1.0)
    after = _after(spool, u, x, v, way * _friction_at(spool, abs(v)), h)
    return _friction_at(spool, 0.5 * (abs(v) + max(way * after, 0.0)))


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
    """Advance a moving spool by h, or up to the instant at which it comes to rest; returns the time that is left."""
    f = sliding_friction(spool, u, x, v, h)
    after = _after(spool, u, x, v, select(v > 0.0, f, -f), h)
    reverses = v * after <= 0.0
    used = select(reverses, h * abs(v) / (abs(v) + abs(after) + TINY), h)
    after = select(reverses, 0.0, after)
    return x + 0.5 * used * (v + after), after, h - used


@law
def _release(spool, u_0, u_1, x, left, h):
    """Advance a spool from rest by what is left of a step of h, while u goes from u_0 to u_1.

    It moves as far as the pull exceeds friction. What its damping takes off grows with the time that is left: exactly
    for a whole step, evenly in between, to second order. Friction falls with the square of a speed that is itself of
    second order here: that of rest counts throughout.
    """
    wn, f = spool.natural_frequency, holding_friction(spool)
    way = select(u_0 + u_1 > 2.0 * x, 1.0, -1.0)
    excess = way * mean_above_zero(way * (u_0 - x) - f, way * (u_1 - x) - f)
    a = h * wn * (spool.damping_ratio + 0.25 * h * wn)
    after = left * (wn * wn) * excess * (1.0 - left * (a / (h * (1.0 + a))))
    return x + 0.5 * left * after, after


@law
def advance_spool(spool, u, du, x, v, h):
    """Position and rate after a step of h seconds in which the opening asked for goes evenly from u - du to u + du.

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
def centred(valve):  # noqa: ARG001  (as of all valves)
    """State of a spool at rest in the middle."""
    return SpoolState(0.0, 0.0)


@law
def spool_opening(valve, state):  # noqa: ARG001
    """Opening of the spool, -1..1."""
    return state.opening
