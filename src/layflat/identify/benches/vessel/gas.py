"""Gas in a vessel: air by the laws of the plant, or a real gas by Redlich and Kwong's equation of state.

| symbol | meaning | unit |
|---|---|---|
| p, T, rho | absolute pressure, temperature, density | Pa, K, kg/m3 |
| R | specific gas constant | J/(kg K) |
| gamma | ratio of specific heats at low pressure | 1 |
| a, b | attraction and covolume | Pa m6 K^0.5/kg2, m3/kg |
| c_v, u, h | specific heat at constant volume, specific energy and enthalpy | J/(kg K), J/kg |
| n | isentropic exponent, -(v/p) (dp/dv) at constant entropy | 1 |
| psi | choked flow over area times sqrt(p rho) | 1 |

p = R T rho/(1 - b rho) - a rho^2/(sqrt(T) (1 + b rho)), from the critical point alone (redlich1949). It gives the
density of nitrogen, air, hydrogen, oxygen and argon at 150 bar and 288 K within 2 %, of helium within 3 %. The heat
capacity at low pressure is taken as constant, and nothing condenses. Derived in docs/derivations.md.
"""

from math import log1p, sqrt
from typing import NamedTuple

from layflat.jit import by_kind, law
from layflat.physics.air import CP, GAMMA, GAS_CONSTANT, REFERENCE_TEMPERATURE
from layflat.physics.chamber import air_mass, energy, pressure, temperature
from layflat.physics.flow import root_temperature


class IdealAir(NamedTuple):
    """Air by the laws of `chamber` and `flow`, in a wall that may stretch."""

    viscosity: float  # at T0, Pa s
    conductivity: float  # of heat, at T0, W/(m K)


class RealGas(NamedTuple):
    """Real gas, in a rigid vessel."""

    viscosity: float  # at T0, Pa s
    conductivity: float  # of heat, at T0, W/(m K)
    constant: float  # R, J/(kg K)
    gamma: float
    attraction: float  # a, Pa m6 K^0.5/kg2
    covolume: float  # b, m3/kg


def real_gas(R: float, gamma: float, T_c: float, p_c: float, viscosity: float, conductivity: float) -> RealGas:
    """Return a gas from its constants and its critical point (redlich1949).

    Args:
        R: specific gas constant, J/(kg K).
        gamma: ratio of specific heats at low pressure.
        T_c: critical temperature, K.
        p_c: critical pressure, Pa.
        viscosity: Pa s.
        conductivity: conductivity of heat, W/(m K).
    """
    return RealGas(viscosity, conductivity, R, gamma, 0.42748 * R**2 * T_c**2.5 / p_c, 0.08664 * R * T_c / p_c)


GASES_BY_NAME = {
    "air": real_gas(GAS_CONSTANT, GAMMA, 132.5, 37.86e5, 1.82e-5, 0.0257),
    "nitrogen": real_gas(296.80, 1.400, 126.19, 33.96e5, 1.76e-5, 0.0255),
    "oxygen": real_gas(259.84, 1.395, 154.58, 50.43e5, 2.03e-5, 0.0263),
    "hydrogen": real_gas(4124.2, 1.405, 33.15, 12.96e5, 0.88e-5, 0.183),
    "helium": real_gas(2077.1, 1.667, 5.195, 2.276e5, 1.96e-5, 0.154),
    "argon": real_gas(208.13, 1.667, 150.69, 48.63e5, 2.23e-5, 0.0175),
    "methane": real_gas(518.28, 1.305, 190.56, 45.99e5, 1.10e-5, 0.0336),
    "carbon dioxide": real_gas(188.92, 1.293, 304.13, 73.77e5, 1.47e-5, 0.0164),
}
"""Gases by name: constants and critical points of the NIST Chemistry WebBook, the rest at 1 bar and 293 K, rounded."""

IDEAL_AIR = IdealAir(GASES_BY_NAME["air"].viscosity, GASES_BY_NAME["air"].conductivity)


@law
def gas_pressure(gas, T, rho):
    """Return the pressure by Redlich and Kwong, Pa."""
    x = gas.covolume * rho
    return rho * (gas.constant * T / (1.0 - x) - gas.attraction * rho / (sqrt(T) * (1.0 + x)))


@law
def _attraction_energy(gas, rho):
    """Return the energy of attraction between molecules, times sqrt(T) and over 1.5, J K^0.5/kg."""
    x = gas.covolume * rho
    return gas.attraction * rho if x < 1e-12 else gas.attraction / gas.covolume * log1p(x)


@law
def gas_energy(gas, T, rho):
    """Return the specific energy, J/kg, relative to the ideal gas at 0 K."""
    return gas.constant / (gas.gamma - 1.0) * T - 1.5 * _attraction_energy(gas, rho) / sqrt(T)


@law
def _below_temperature(c_v, w, u):
    """Return a temperature at or below the root T of c_v T - w/sqrt(T) = u, however small or negative u (J/kg) is."""
    if w <= 0.0:
        return u / c_v
    balance = (w / c_v) ** (2.0 / 3.0)
    lack = max(-u / (c_v * balance), 0.0)
    return max(u / c_v, balance / ((1.0 + lack) * (1.0 + lack)))


@law
def gas_temperature(gas, u, rho):
    """Return the temperature from specific energy and density, K: inverse of `gas_energy`.

    Newton's steps rise to the root from below, as energy is concave in temperature. In a thin gas u/c_v is close below
    the root. In a cold dense one u is small or negative. With T_0 from c_v T_0 = w/sqrt(T_0), w/sqrt(T) the energy of
    attraction, the root is above T_0 for u >= 0, and above T_0/(1 - u/(c_v T_0))^2 for u < 0. From the highest of
    these bounds six steps converge to rounding.
    """
    c_v, w = gas.constant / (gas.gamma - 1.0), 1.5 * _attraction_energy(gas, rho)
    T = _below_temperature(c_v, w, u)
    for _ in range(6):
        T -= (c_v * T - w / sqrt(T) - u) / (c_v + 0.5 * w / (T * sqrt(T)))
    return T


@law
def gas_stiffness(gas, T, rho):
    """Return (dp/drho) at constant temperature, J/kg, and (dp/dT) at constant density, Pa/K."""
    x = gas.covolume * rho
    root = sqrt(T)
    by_density = gas.constant * T / (1.0 - x) ** 2 - gas.attraction * rho * (2.0 + x) / (root * (1.0 + x) ** 2)
    by_temperature = rho * gas.constant / (1.0 - x) + 0.5 * gas.attraction * rho * rho / (T * root * (1.0 + x))
    return by_density, by_temperature


@law
def gas_density(gas, p, T):
    """Return the density from pressure and temperature, kg/m3: inverse of `gas_pressure`, in the gas phase.

    Newton's steps rise to the root from below where pressure is concave in density. Next to the critical point it is
    flat and they can miss the root; there bisection is used.
    """
    rho = min(p / (gas.constant * T), 0.5 / gas.covolume)
    for _ in range(8):
        rho -= (gas_pressure(gas, T, rho) - p) / gas_stiffness(gas, T, rho)[0]
    inside = 0.0 < rho < 1.0 / gas.covolume
    return rho if inside and abs(gas_pressure(gas, T, rho) - p) <= 1e-11 * p else _bisected_density(gas, p, T)


@law
def _bisected_density(gas, p, T):
    """Return the density (kg/m3) at p and T by bisection between 0 and that of the covolume."""
    low, high = 0.0, 1.0 / gas.covolume
    for _ in range(60):
        middle = 0.5 * (low + high)
        below = gas_pressure(gas, T, middle) < p
        low, high = (middle, high) if below else (low, middle)
    return low


@law
def is_gas(gas, p, T):
    """Return whether p and T are of a gas: above the critical temperature, or thinner (b rho < 0.26) and stable."""
    critical = (gas.attraction / (4.934 * gas.constant * gas.covolume)) ** (2.0 / 3.0)
    rho = gas_density(gas, p, T)
    thin = gas.covolume * rho < 0.26 and gas_stiffness(gas, T, rho)[0] > 0.0
    return critical < T or (thin and abs(gas_pressure(gas, T, rho) - p) < 1e-6 * p)


@law
def isentropic_exponent(gas, T, rho):
    """Return the exponent n at a state; gamma where the pressure is low."""
    by_density, by_temperature = gas_stiffness(gas, T, rho)
    c_v = gas.constant / (gas.gamma - 1.0) + 0.75 * _attraction_energy(gas, rho) / (T * sqrt(T))
    return rho / gas_pressure(gas, T, rho) * (by_density + T * (by_temperature / rho) ** 2 / c_v)


@law
def choked_flow_factor(n):
    """Return psi of a frictionless nozzle from its isentropic exponent: ISO 4126-7, ISO 6358-1 annex."""
    return sqrt(n) * (2.0 / (n + 1.0)) ** ((n + 1.0) / (2.0 * (n - 1.0)))


@law
def _ideal_contents(gas, chamber, p, T, p_a):  # noqa: ARG001  (as all kinds of gas)
    """Return `gas_contents` of ideal air: energy and mass."""
    return energy(chamber, p, chamber.dead_volume, p_a), air_mass(chamber, p, T, chamber.dead_volume, p_a)


@law
def _real_contents(gas, chamber, p, T, p_a):  # noqa: ARG001
    """Return `gas_contents` of a real gas in a rigid vessel: energy and mass."""
    rho = gas_density(gas, p, T)
    m = rho * chamber.dead_volume
    return m * gas_energy(gas, T, rho), m


@law
def _ideal_state(gas, chamber, E, m, p_a):  # noqa: ARG001
    """Return `gas_state` of ideal air: absolute pressure and temperature."""
    p = pressure(chamber, E, chamber.dead_volume, p_a)
    return p, temperature(chamber, p, m, chamber.dead_volume, p_a)


@law
def _real_state(gas, chamber, E, m, p_a):  # noqa: ARG001
    """Return `gas_state` of a real gas in a rigid vessel: absolute pressure and temperature."""
    rho = m / chamber.dead_volume
    T = gas_temperature(gas, E / m, rho)
    return gas_pressure(gas, T, rho), T


@law
def _ideal_outflow(gas, p, T):  # noqa: ARG001
    """Return `gas_outflow` of ideal air: flow over that of air at T0, specific enthalpy, density and c_p."""
    return root_temperature(T).per_root, CP * T, p / (GAS_CONSTANT * T), CP


@law
def _real_outflow(gas, p, T):
    """Return `gas_outflow` of a real gas: flow over that of air, specific enthalpy, density and c_p."""
    rho = gas_density(gas, p, T)
    n = max(isentropic_exponent(gas, T, rho), 1.01)
    factor = choked_flow_factor(n) / choked_flow_factor(GAMMA) * sqrt(REFERENCE_TEMPERATURE * GAS_CONSTANT * rho / p)
    c_p = gas.gamma / (gas.gamma - 1.0) * gas.constant
    return factor, gas_energy(gas, T, rho) + p / rho, rho, c_p


gas_contents = by_kind({IdealAir: _ideal_contents, RealGas: _real_contents})
"""Energy (J) and mass (kg) of the gas in a chamber at p and T: `gas_contents(gas, chamber, p, T, p_a)`."""

gas_state = by_kind({IdealAir: _ideal_state, RealGas: _real_state})
"""Pressure (Pa) and temperature (K) of the gas in a chamber: `gas_state(gas, chamber, E, m, p_a)`."""

gas_outflow = by_kind({IdealAir: _ideal_outflow, RealGas: _real_outflow})
"""Properties of the gas that flows out of a space at p and T: `gas_outflow(gas, p, T)`.

Returns the mass flow through a path over that of air at T0 through it, specific enthalpy (J/kg), density (kg/m3) and
specific heat at constant pressure and low density (J/(kg K)).
"""
