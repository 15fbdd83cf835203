"""A vessel that fills or empties through one path: rates of its energy, its mass and its wall's temperature.

| symbol | meaning | unit |
|---|---|---|
| E, m | energy and mass of the gas | J, kg |
| T_w | temperature of the wall | K |
| C, b, s | of the path: see flow.py | |
| w | mass flow in | kg/s |
| h | heat transfer coefficient | W/(m2 K) |
| k, mu | heat conductivity and viscosity of the gas, at the mean of its temperature and the wall's | W/(m K), Pa s |
| T_f | that mean | K |
| rho, c_p | density and specific heat at constant pressure | kg/m3, J/(kg K) |
| D, d | inner diameter of the vessel, diameter of the jet | m |

Turbulent natural convection has Nu = c Ra^(1/3), with c about 0.13 (mcadams1954): the size of the vessel cancels, and h
grows as p^(2/3) |T - T_w|^(1/3). A jet that enters adds Nu_D = c_f Re_d^0.67, with c_f about 0.56 (woodfield2008).
"""

from math import pi, sqrt
from typing import NamedTuple

from layflat.identify.benches.vessel.gas import state_of, stream
from layflat.jit import law
from layflat.physics.air import GAMMA, REFERENCE_DENSITY, REFERENCE_TEMPERATURE
from layflat.physics.chamber import Chamber
from layflat.physics.flow import effective_area, effective_pressure, laminar_slope

GRAVITY = 9.81  # m/s2


class Wall(NamedTuple):
    """Wall of a vessel, of one temperature."""

    area: float  # inside, m2
    diameter: float  # inside, m
    natural: float  # c of natural convection
    forced: float  # c_f of the jet that fills
    heat_capacity: float  # J/K; infinite for a wall that keeps its temperature
    outer_conductance: float  # from the wall to the surroundings, W/K


class Path(NamedTuple):
    """What joins the vessel to the place beyond."""

    conductance: float
    critical_ratio: float


class Vessel(NamedTuple):
    """Gas space, wall and path."""

    chamber: Chamber
    wall: Wall
    path: Path


class Outside(NamedTuple):
    """Beyond the path, and around the vessel."""

    pressure: float
    temperature: float
    ambient_pressure: float
    ambient_temperature: float


class Filling(NamedTuple):
    """State of a vessel, or its rates."""

    energy: float
    mass: float
    wall_temperature: float


class Exchange(NamedTuple):
    """What passes between a vessel, the place beyond and the wall."""

    flow: float  # mass flow in, kg/s
    enthalpy: float  # that it carries, J/kg
    temperature: float  # of the gas, K
    heat: float  # heat flow from the wall per kelvin, W/K
    steepest: float  # greatest change of the mass flow by the pressure inside, kg/(s Pa)
    specific_heat: float  # of the thin gas at constant pressure, J/(kg K)


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


@law
def exchange(gas, vessel, state, outside, opening):
    """What passes while the path is open by `opening`, 0..1 of its conductance."""
    chamber, wall, path = vessel.chamber, vessel.wall, vessel.path
    p, T = state_of(gas, chamber, state.energy, state.mass, outside.ambient_pressure)
    factor, h, rho, c_p = stream(gas, p, T)
    fills = outside.pressure > p
    if fills:
        factor, h, _, _ = stream(gas, outside.pressure, outside.temperature)
    upper, lower = max(p, outside.pressure), min(p, outside.pressure)
    slope = laminar_slope(path.critical_ratio)
    reach = effective_pressure(upper, lower, path.critical_ratio, slope)
    per_reach = opening * path.conductance * REFERENCE_DENSITY * factor
    w = per_reach * reach if fills else -per_reach * reach
    T_w = state.wall_temperature
    jet = jet_diameter(effective_area(path.conductance))
    film = natural_convection(wall.natural, gas, rho, c_p, T, T_w)
    film += forced_convection(wall.forced, gas, w, jet, wall.diameter, T, T_w)
    heat = chamber.wall_conductance + film * wall.area
    return Exchange(w, h, T, heat, per_reach * slope, c_p)


@law
def rates(vessel, state, outside, passes):
    """Rates of change of a state, given what passes."""
    wall = vessel.wall
    inward = passes.heat * (state.wall_temperature - passes.temperature)
    outer = wall.outer_conductance * (outside.ambient_temperature - state.wall_temperature)
    return Filling(passes.flow * passes.enthalpy + inward, passes.flow, (outer - inward) / wall.heat_capacity)


@law
def fastest_rates(vessel, state, passes):
    """Bounds, 1/s, of the rates at which flow would end a difference of pressure, and of the rest.

    The first is that next to equal pressures. The second is that at which gas is renewed, and at which heat would end
    differences of temperature.
    """
    flow = (GAMMA - 1.0) * passes.specific_heat * passes.temperature * passes.steepest / vessel.chamber.dead_volume
    renewed = GAMMA * (abs(passes.flow) + passes.heat / passes.specific_heat) / state.mass
    return flow, renewed + (passes.heat + vessel.wall.outer_conductance) / vessel.wall.heat_capacity
