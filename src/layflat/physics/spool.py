"""The spool of a proportional valve: a damped oscillator with Coulomb friction between hard stops.

| symbol | meaning | unit |
|---|---|---|
| x, v | opening (-1..1) and its rate | 1, 1/s |
| u | opening that the solenoid asks for: command + dither | 1 |
| wn | natural frequency | rad/s |
| zeta | damping ratio | 1 |
| f | Coulomb friction, as the change of u that it can hide | 1 |

x'' = wn^2 (u - x) - 2 zeta wn x' - wn^2 f sign(x').
"""

from typing import NamedTuple

from layflat.jit import law
from layflat.lanes import select


class Spool(NamedTuple):
    """Parameters of the spool's motion (units as in the module's table)."""

    natural_frequency: float
    damping_ratio: float
    friction: float


@law
def _slide(spool, u, x, v, h):
    """Advance a moving spool by h, or up to the instant at which it comes to rest; returns the time that is left."""
    wn = spool.natural_frequency
    pull = wn * wn * (u - x)
    grip = wn * wn * spool.friction
    a = h * wn * (spool.damping_ratio + 0.25 * h * wn)
    after = ((1.0 - a) * v + h * (pull - select(v > 0.0, grip, -grip))) * (1.0 / (1.0 + a))
    reverses = v * after <= 0.0
    used = select(reverses, h * v / select(v == after, 1.0, v - after), h)
    after = select(reverses, 0.0, after)
    return x + 0.5 * used * (v + after), after, h - used


@law
def _release(spool, u, x, h):
    """Advance a spool from rest by h: it stays unless the pull exceeds the friction."""
    wn = spool.natural_frequency
    pull = wn * wn * (u - x)
    grip = wn * wn * spool.friction
    excess = max(pull - grip, 0.0) + min(pull + grip, 0.0)
    after = h * excess / (1.0 + h * wn * (spool.damping_ratio + 0.25 * h * wn))
    return x + 0.5 * h * after, after


@law
def advance_spool(spool, u, x, v, h):
    """Position and rate after a step of h seconds with u held.

    Implicit midpoint, split where the spool comes to rest, so that it is of second order through reversals and
    sticks exactly. A spool that reaches a stop stays there until it is pulled away.
    """
    x, v, left = _slide(spool, u, x, v, h)
    moved, rate = _release(spool, u, x, left)
    x, v = select(left > 0.0, moved, x), select(left > 0.0, rate, v)
    stopped = ((x >= 1.0) & (v > 0.0)) | ((x <= -1.0) & (v < 0.0))
    return min(max(x, -1.0), 1.0), select(stopped, 0.0, v)
