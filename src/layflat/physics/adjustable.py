"""What a controller can adjust of a joint besides its valve's opening: brake, dither and supply, as shares of all.

A pneumatic calliper and a pressure regulator are filled through a throat, so that what they give moves towards what is
asked at a steady rate, within limits; so does the dither of a driver, only faster.

| symbol | meaning | unit |
|---|---|---|
| s | share that is given, 0 to 1 | 1 |
| T | time for which a share is asked | s |
"""

from typing import NamedTuple

from layflat.jit import law


class Adjustable(NamedTuple):
    """Limits of a share."""

    least: float  # below which it does not go; 1: nothing to adjust
    rate: float  # at which it changes, 1/s


class Adjustables(NamedTuple):
    """What of a joint can be adjusted."""

    brake: Adjustable
    dither: Adjustable
    supply: Adjustable


class Shares(NamedTuple):
    """Shares of the greatest torque of a joint's brake, of its valve's dither, of its supply's gauge pressure."""

    brake: float
    dither: float
    supply: float


FIXED = Adjustable(1.0, 1.0)
"""A brake on a spring, a driver that always dithers, a supply without a regulator."""

ALL_FIXED = Adjustables(FIXED, FIXED, FIXED)

FULL = Shares(1.0, 1.0, 1.0)
"""Of a joint that nobody adjusts, and of any joint at first."""


@law
def _adjusted(limits, s, asked, T):
    # Mean share in the next T seconds, and the share after them.
    most = limits.rate * T
    change = min(max(min(max(asked, limits.least), 1.0) - s, -most), most)
    after = s + change
    return after - 0.5 * change * abs(change) / most, after


@law
def adjusted(adjustables, shares, asked, T):
    """Return the mean `Shares` of a joint in the T seconds for which shares are asked, and those after them."""
    brake, brake_after = _adjusted(adjustables.brake, shares.brake, asked.brake, T)
    dither, dither_after = _adjusted(adjustables.dither, shares.dither, asked.dither, T)
    supply, supply_after = _adjusted(adjustables.supply, shares.supply, asked.supply, T)
    return Shares(brake, dither, supply), Shares(brake_after, dither_after, supply_after)


@law
def regulated(share, p_s, p_a):
    """Return the absolute pressure behind a regulator that gives a share of its supply's gauge pressure, Pa."""
    return p_s - (1.0 - share) * (p_s - p_a)
