"""Brake, dither and supply of a joint as fractions of their full values, which a controller commands beside its valve.

A pneumatic calliper and a pressure regulator are filled through a throat, so that their fraction moves towards the
demanded one at a constant rate, within limits; so does the dither of a driver, only faster.

| symbol | meaning | unit |
|---|---|---|
| s | present fraction, 0 to 1 | 1 |
| T | time for which a demand holds | s |
"""

from typing import NamedTuple

from layflat.jit import law


class FractionLimits(NamedTuple):
    """Lower limit and rate limit of a fraction."""

    least: float  # lower limit; 1: not adjustable
    rate: float  # rate of change, 1/s


class JointFractionLimits(NamedTuple):
    """Limits of the three fractions of a joint."""

    brake: FractionLimits
    dither: FractionLimits
    supply: FractionLimits


class DriveFractions(NamedTuple):
    """Fractions of a joint's maximum brake torque, of its valve's dither and of its supply's gauge pressure, 0 to 1."""

    brake: float  # of the brake's maximum torque, 0..1
    dither: float  # of the valve's dither, 0..1
    supply: float  # of the supply's gauge pressure, 0..1


NOT_ADJUSTABLE = FractionLimits(1.0, 1.0)
"""Limits of a brake on a spring, of a driver that always dithers, of a supply without a regulator."""

NONE_ADJUSTABLE = JointFractionLimits(NOT_ADJUSTABLE, NOT_ADJUSTABLE, NOT_ADJUSTABLE)

FULL_FRACTIONS = DriveFractions(1.0, 1.0, 1.0)
"""Fractions of a joint that no controller adjusts, and of any joint at the start."""


@law
def _adjust_fraction(limits, s, demand, T):
    """Return the mean fraction in the next T seconds, and the fraction after them, towards a demanded one."""
    max_change = limits.rate * T
    change = min(max(min(max(demand, limits.least), 1.0) - s, -max_change), max_change)
    after = s + change
    return after - 0.5 * change * abs(change) / max_change, after


@law
def adjust_fractions(adjustables, fractions, demand, T):
    """Return the mean `DriveFractions` of a joint in the T seconds for which a demand holds, and those after them."""
    brake, brake_after = _adjust_fraction(adjustables.brake, fractions.brake, demand.brake, T)
    dither, dither_after = _adjust_fraction(adjustables.dither, fractions.dither, demand.dither, T)
    supply, supply_after = _adjust_fraction(adjustables.supply, fractions.supply, demand.supply, T)
    return DriveFractions(brake, dither, supply), DriveFractions(brake_after, dither_after, supply_after)


@law
def regulated_pressure(fraction, p_s, p_a):
    """Return the absolute pressure (Pa) behind a regulator at a fraction of the gauge pressure of its supply p_s."""
    return p_s - (1.0 - fraction) * (p_s - p_a)
