"""Air in a hose: energy and mass balance of an ideal gas in an elastic wall.

| symbol | meaning | unit |
|---|---|---|
| p, T | absolute pressure, temperature | Pa, K |
| m | mass of air | kg |
| V_g | geometric volume, by the joint's angle | m3 |
| k | compliance: volume gained per pressure by the stretching wall | m3/Pa |
| p_a | pressure outside | Pa |
| E | energy of the air and of the stretched wall, m cv T + k (p^2 - p_a^2)/2 | J |

The air fills V = V_g + k (p - p_a), and p V = (gamma - 1) m cv T. Eliminating T gives a quadratic for p, solved in the
form that stays exact for k = 0. Derived in docs/derivations.md.
"""

from math import sqrt
from typing import NamedTuple

from layflat.jit import law
from layflat.physics.air import CV, GAMMA, GAS_CONSTANT, REFERENCE_TEMPERATURE
from layflat.physics.flow import RootTemperature

ISOTHERMAL_SOUND_SPEED = sqrt(GAS_CONSTANT * REFERENCE_TEMPERATURE)
"""sqrt(p V/m) of air at the reference temperature, m/s."""


class Chamber(NamedTuple):
    """Parameters of the air space of one hose."""

    dead_volume: float  # volume at the collapsed hose, m3
    compliance: float  # k, m3/Pa
    wall_conductance: float  # heat flow to the wall per kelvin, W/K


@law
def _positive_root(a, b, c):
    """Return the positive root of a p^2 + b p = c, exact for a = 0."""
    return 2.0 * c / (b + sqrt(b * b + 4.0 * a * c))


@law
def pressure(chamber, E, V_g, p_a):
    """Return the pressure of a chamber that holds energy E, Pa."""
    k = chamber.compliance
    return _positive_root(0.5 * (GAMMA + 1.0) * k, V_g - k * p_a, (GAMMA - 1.0) * (E + 0.5 * k * p_a * p_a))


@law
def pressure_after_expansion(chamber, E, V_g, dV, p, p_a):
    """Return the pressure once the volume has grown by dV to V_g (Pa), and its derivative by energy there (Pa/J).

    The work is done at the pressure at the end (implicit Euler). One Newton step from the pressure p before: its error
    is of second order in dV and in the change of E.
    """
    k = chamber.compliance
    per = 1.0 / (V_g - k * p_a + (GAMMA - 1.0) * dV + (GAMMA + 1.0) * k * p)
    energy_term = (GAMMA - 1.0) * (E + 0.5 * k * p_a * p_a) + 0.5 * (GAMMA + 1.0) * k * p * p
    return energy_term * per, (GAMMA - 1.0) * per


@law
def energy(chamber, p, V_g, p_a):
    """Return the energy of a chamber at pressure p, J: the inverse of `pressure`."""
    k = chamber.compliance
    return p * (V_g + k * (p - p_a)) / (GAMMA - 1.0) + 0.5 * k * (p * p - p_a * p_a)


@law
def temperature(chamber, p, m, V_g, p_a):
    """Return the temperature of a mass m of air at pressure p, K."""
    return p * (V_g + chamber.compliance * (p - p_a)) / (m * GAS_CONSTANT)


@law
def temperature_and_roots(chamber, p, m, V_g, p_a):
    """Return the temperature of a mass m of air at pressure p (K) and its `RootTemperature`, by a single division."""
    pV = p * (V_g + chamber.compliance * (p - p_a))
    # T = pV/(m R), so both roots are multiples of 1/sqrt(pV m).
    per = 1.0 / sqrt(pV * m)
    root = pV * per * (1.0 / ISOTHERMAL_SOUND_SPEED)
    return root * root * REFERENCE_TEMPERATURE, RootTemperature(root, m * per * ISOTHERMAL_SOUND_SPEED)


@law
def air_mass(chamber, p, T, V_g, p_a):
    """Return the mass of air at pressure p and temperature T, kg."""
    return p * (V_g + chamber.compliance * (p - p_a)) / (GAS_CONSTANT * T)


@law
def wall_heat(chamber, T, T_wall):
    """Return the heat flow from the wall into the air, W."""
    return chamber.wall_conductance * (T_wall - T)


@law
def internal_energy(m, T):
    """Return the internal energy of a mass of air, J."""
    return m * CV * T
