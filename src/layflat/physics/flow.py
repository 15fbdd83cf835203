"""Air through an orifice: ISO 6358-1:2013, both ways.

| symbol | meaning | unit |
|---|---|---|
| C | sonic conductance | m3/(s Pa) |
| b | critical pressure ratio | 1 |
| p_1, p_2 | absolute pressure upstream and downstream | Pa |
| T_1 | temperature upstream | K |
| r | pressure ratio p_2/p_1 | 1 |
| phi | flow relative to choked flow | 1 |
| D | drop of pressure over 1 - b, p_1 at most | Pa |
| s | slope of phi next to r = 1 | 1 |
| T0 | reference temperature | K |
| C_d | discharge coefficient: choked flow over that of a frictionless nozzle as large | 1 |
"""

from math import sqrt
from typing import NamedTuple

from layflat.jit import law
from layflat.lanes import select
from layflat.physics.air import CP, GAMMA, GAS_CONSTANT, REFERENCE_DENSITY, REFERENCE_TEMPERATURE


class RootTemperature(NamedTuple):
    """sqrt(T/T0) and its inverse."""

    root: float
    per_root: float


ENTHALPY = CP * REFERENCE_TEMPERATURE
"""Of air at the reference temperature, J/kg."""

LAMINAR_RATIO = 0.999
"""Above this pressure ratio the flow is linear in the pressure difference, so that its slope stays finite."""


CONDUCTANCE_PER_AREA = (
    sqrt(GAMMA / (GAS_CONSTANT * REFERENCE_TEMPERATURE))
    / REFERENCE_DENSITY
    * (2.0 / (GAMMA + 1.0)) ** ((GAMMA + 1.0) / (2.0 * (GAMMA - 1.0)))
)
"""C of a frictionless nozzle over its area, m/(s Pa): choked ideal gas (ISO 6358-1). Derived in docs/derivations.md."""


@law
def sonic_conductance(area, C_d):
    """C of a hole (m2), m3/(s Pa)."""
    return C_d * area * CONDUCTANCE_PER_AREA


@law
def effective_area(C):
    """Area of the frictionless nozzle that has this C, m2; over that of a hole it is C_d."""
    return C / CONDUCTANCE_PER_AREA


@law
def laminar_slope(b):
    """Slope of phi between `LAMINAR_RATIO` and 1, from the critical pressure ratio b."""
    z = (LAMINAR_RATIO - b) / (1.0 - b)
    return sqrt(1.0 - z * z) / (1.0 - LAMINAR_RATIO)


@law
def _driving(p_1, drop, b, s):
    # `effective_pressure`, from p_1 and the drop of pressure. Where it is choked D is p_1. The ellipse is
    # p_1^2 - (p_1 - D)^2; as a product it loses no digits next to r = 1.
    D = min(drop * (1.0 / (1.0 - b)), p_1)
    return min(sqrt(D * (2.0 * p_1 - D)), s * drop)


@law
def effective_pressure(p_1, p_2, b, s):
    """p_1 phi(p_2/p_1) without a division, Pa; nothing where p_2 is higher.

    phi is 1 when choked, an ellipse for smaller differences (ISO 6358-1), and a straight line next to r = 1. The
    ellipse is concave: its chord next to r = 1 lies below it there and above it everywhere else.
    """
    return _driving(p_1, max(p_1 - p_2, 0.0), b, s)


@law
def upstream_pressure(effective, p_2, b):
    """Upstream pressure at which `effective_pressure` is a given one, Pa, but for the straight line next to r = 1."""
    # The ellipse is a quadratic in p_1, and choked flow is p_1 itself.
    square, half = 1.0 - 2.0 * b, b * p_2
    rest = p_2 * p_2 + (1.0 - b) * (1.0 - b) * effective * effective
    subsonic = rest / (half + sqrt(half * half + square * rest))
    return select(p_2 <= b * effective, effective, subsonic)


@law
def root_temperature(T):
    """What a flow has to know of a temperature T (K)."""
    root = sqrt(T * (1.0 / REFERENCE_TEMPERATURE))
    return RootTemperature(root, 1.0 / root)


@law
def flow_between(C, b, s, p_a, roots_a, p_b, roots_b):
    """Mass flow from a to b (negative: from b to a), kg/s, and this times T_1/T0: its enthalpy over `ENTHALPY`."""
    forward = p_a >= p_b
    full = C * REFERENCE_DENSITY * _driving(max(p_a, p_b), abs(p_a - p_b), b, s)
    flow = full * select(forward, roots_a.per_root, -roots_b.per_root)
    return flow, full * select(forward, roots_a.root, -roots_b.root)


@law
def orifice(C, b, s, p_a, T_a, p_b, T_b):
    """Mass flow from a to b (negative: from b to a) and the enthalpy it carries, in kg/s and W."""
    flow, warm = flow_between(C, b, s, p_a, root_temperature(T_a), p_b, root_temperature(T_b))
    return flow, ENTHALPY * warm
