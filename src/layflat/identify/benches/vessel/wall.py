"""Heat between the gas in a vessel and its wall.

| symbol | meaning | unit |
|---|---|---|
| h | heat transfer coefficient | W/(m2 K) |
| k, mu | heat conductivity and viscosity of the gas, at the mean of its temperature and the wall's | W/(m K), Pa s |
| T_f | that mean | K |
| rho, c_p | density and specific heat at constant pressure | kg/m3, J/(kg K) |
| D, d | inner diameter of the vessel, diameter of the jet | m |
| w | mass flow in | kg/s |

Turbulent natural convection has Nu = c Ra^(1/3), with c about 0.13 (mcadams1954): the size of the vessel cancels, and h
grows as p^(2/3) |T - T_w|^(1/3). A jet that enters adds Nu_D = c_f Re_d^0.67, with c_f about 0.56 (woodfield2008).
"""

from math import pi, sqrt
from typing import NamedTuple

from layflat.jit import law
from layflat.physics.air import REFERENCE_TEMPERATURE

GRAVITY = 9.81
"""m/s2"""


class Wall(NamedTuple):
    """Wall of a vessel, of one temperature."""

    area: float
    """Inside, m2."""
    diameter: float
    """Inside, m."""
    natural: float
    """c of natural convection."""
    forced: float
    """c_f of the jet that fills."""
    heat_capacity: float
    """J/K; infinite for a wall that keeps its temperature."""
    outer_conductance: float
    """From the wall to the surroundings, W/K."""


@law
def film(gas, T, T_w):
    """Temperature of the film at the wall (K), and the gas's viscosity and conductivity there."""
    T_f = 0.5 * (T + T_w)
    warm = T_f * (1.0 / REFERENCE_TEMPERATURE)
    return T_f, gas.viscosity * warm**0.7, gas.conductivity * warm**0.8


@law
def natural_convection(c, gas, rho, c_p, T, T_w):
    """H of turbulent natural convection, W/(m2 K)."""
    T_f, mu, k = film(gas, T, T_w)
    rho_f = rho * T / T_f
    return c * k * (GRAVITY * rho_f * rho_f * c_p * abs(T_w - T) / (T_f * mu * k)) ** (1.0 / 3.0)


@law
def forced_convection(c_f, gas, w, d, D, T, T_w):
    """H of a jet of mass flow w that enters through a hole of diameter d, W/(m2 K)."""
    _, mu, k = film(gas, T, T_w)
    return c_f * k / D * (4.0 * max(w, 0.0) / (pi * mu * d)) ** 0.67


@law
def jet_diameter(area):
    """Diameter of a round jet of this area, m."""
    return sqrt(4.0 / pi * area)
