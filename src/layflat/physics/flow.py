"""Flow of air through an orifice, in either direction, by ISO 6358-1:2013.

| symbol | meaning | unit |
|---|---|---|
| C | sonic conductance | m3/(s Pa) |
| b | critical pressure ratio | 1 |
| p_1, p_2 | absolute pressure upstream and downstream | Pa |
| T_1 | temperature upstream | K |
| r | pressure ratio p_2/p_1 | 1 |
| phi | flow relative to choked flow | 1 |
| D | pressure drop over 1 - b, p_1 at most | Pa |
| s | slope of phi near r = 1 | 1 |
| T0 | reference temperature | K |
| C_d | discharge coefficient: choked flow over that of a frictionless nozzle of the same area | 1 |
"""

from math import sqrt
from typing import NamedTuple

from layflat.jit import law
from layflat.lanes import select
from layflat.physics.air import CP, GAMMA, GAS_CONSTANT, REFERENCE_DENSITY, REFERENCE_TEMPERATURE

__all__ = [
    "effective_area", "effective_pressure", "laminar_slope", "root_temperature", "sonic_conductance",
    "upstream_pressure",
]  # fmt: skip


class RootTemperature(NamedTuple):
    """Root of a temperature ratio, sqrt(T/T0), and its inverse."""

    root: float
    per_root: float


ENTHALPY = CP * REFERENCE_TEMPERATURE
"""Specific enthalpy of air at the reference temperature, J/kg."""

LAMINAR_RATIO = 0.999
"""Pressure ratio above which the flow is linear in the pressure difference, so that its slope stays finite."""


CONDUCTANCE_PER_AREA = (
    sqrt(GAMMA / (GAS_CONSTANT * REFERENCE_TEMPERATURE))
    / REFERENCE_DENSITY
    * (2.0 / (GAMMA + 1.0)) ** ((GAMMA + 1.0) / (2.0 * (GAMMA - 1.0)))
)
"""C of a frictionless nozzle over its area, m/(s Pa): choked ideal gas (ISO 6358-1). Derived in docs/derivations.md."""


@law
def sonic_conductance(area, C_d):
    """Return C of a hole of an area (m2), m3/(s Pa)."""
    return C_d * area * CONDUCTANCE_PER_AREA


@law
def effective_area(C):
    """Return the area of the frictionless nozzle that has this C, m2: C_d times the area of a hole."""
    return C / CONDUCTANCE_PER_AREA


@law
def laminar_slope(b):
    """Return the slope of phi between `LAMINAR_RATIO` and 1, from the critical pressure ratio b."""
    z = (LAMINAR_RATIO - b) / (1.0 - b)
    return sqrt(1.0 - z * z) / (1.0 - LAMINAR_RATIO)


@law
def _driving_pressure(p_1, drop, b, s):
    """Return `effective_pressure` (p_1 phi, Pa) from p_1 and the pressure drop p_1 - p_2.

    Where it is choked D is p_1. The ellipse is p_1^2 - (p_1 - D)^2; as a product it loses no digits next to r = 1.
    """
    D = min(drop * (1.0 / (1.0 - b)), p_1)
    return min(sqrt(D * (2.0 * p_1 - D)), s * drop)


@law
def effective_pressure(p_1, p_2, b, s):
    """Return p_1 phi(p_2/p_1), Pa, without a division; 0 where p_2 is higher.

    phi is 1 when choked, an ellipse for smaller differences (ISO 6358-1), and a straight line next to r = 1. The
    ellipse is concave: its chord next to r = 1 lies below it there and above it everywhere else.
    """
    return _driving_pressure(p_1, max(p_1 - p_2, 0.0), b, s)


@law
def upstream_pressure(effective, p_2, b):
    """Return the upstream pressure at which `effective_pressure` has a value, Pa; the line near r = 1 is neglected."""
    # The ellipse is a quadratic in p_1, and choked flow is p_1 itself.
    square, half = 1.0 - 2.0 * b, b * p_2
    rest = p_2 * p_2 + (1.0 - b) * (1.0 - b) * effective * effective
    subsonic = rest / (half + sqrt(half * half + square * rest))
    return select(p_2 <= b * effective, effective, subsonic)


@law
def root_temperature(T):
    """Return the `RootTemperature` of a temperature T (K)."""
    root = sqrt(T * (1.0 / REFERENCE_TEMPERATURE))
    return RootTemperature(root, 1.0 / root)


@law
def flow_between(C, b, s, p_a, roots_a, p_b, roots_b):
    """Return the mass flow from a to b (negative: from b to a), kg/s, and its enthalpy flow over `ENTHALPY`, kg/s."""
    forward = p_a >= p_b
    full = C * REFERENCE_DENSITY * _driving_pressure(max(p_a, p_b), abs(p_a - p_b), b, s)
    flow = full * select(forward, roots_a.per_root, -roots_b.per_root)
    return flow, full * select(forward, roots_a.root, -roots_b.root)


@law
def orifice(C, b, s, p_a, T_a, p_b, T_b):
    """Return the mass flow from a to b (negative: from b to a), kg/s, and its enthalpy flow, W."""
    flow, warm = flow_between(C, b, s, p_a, root_temperature(T_a), p_b, root_temperature(T_b))
    return flow, ENTHALPY * warm
