"""A vessel that fills or empties through one path: rates of its energy, its mass and its wall's temperature.

| symbol | meaning | unit |
|---|---|---|
| E, m | energy and mass of the gas | J, kg |
| T_w | temperature of the wall | K |
| C, b, s | of the path: see flow.py | |
| w | mass flow in | kg/s |
"""

from typing import NamedTuple

from layflat.jit import law
from layflat.physics.air import GAMMA, REFERENCE_DENSITY
from layflat.physics.chamber import Chamber, wall_heat
from layflat.physics.flow import effective_area, effective_pressure
from layflat.physics.gas import state_of, stream
from layflat.physics.wall import Wall, forced_convection, jet_diameter, natural_convection


class Path(NamedTuple):
    """What joins the vessel to the place beyond."""

    conductance: float
    critical_ratio: float
    laminar_slope: float


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


@law
def rates(gas, vessel, state, outside, opening):
    """Rates of change of a state while the path is open by `opening`, 0..1 of its conductance."""
    chamber, wall, path = vessel.chamber, vessel.wall, vessel.path
    p, T = state_of(gas, chamber, state.energy, state.mass, outside.ambient_pressure)
    factor, h, rho, c_p = stream(gas, p, T)
    fills = outside.pressure > p
    if fills:
        factor, h, _, _ = stream(gas, outside.pressure, outside.temperature)
    upper, lower = max(p, outside.pressure), min(p, outside.pressure)
    reach = effective_pressure(upper, lower, path.critical_ratio, path.laminar_slope)
    flow = opening * path.conductance * REFERENCE_DENSITY * reach * factor
    w = flow if fills else -flow
    T_w = state.wall_temperature
    jet = jet_diameter(effective_area(path.conductance))
    film = natural_convection(wall.natural, gas, rho, c_p, T, T_w)
    film += forced_convection(wall.forced, gas, w, jet, wall.diameter, T, T_w)
    heat = wall_heat(chamber, T, T_w) + film * wall.area * (T_w - T)
    outer = wall.outer_conductance * (outside.ambient_temperature - T_w)
    return Filling(w * h + heat, w, (outer - heat) / wall.heat_capacity)


@law
def fastest_rate(gas, vessel, state, outside, opening):
    """Bounds of the rates at which flow next to equal pressures, and heat, would end a difference, 1/s and 1/s."""
    chamber, wall, path = vessel.chamber, vessel.wall, vessel.path
    p, T = state_of(gas, chamber, state.energy, state.mass, outside.ambient_pressure)
    factor, _, rho, c_p = stream(gas, p, T)
    steepest = opening * path.conductance * path.laminar_slope * REFERENCE_DENSITY * factor
    film = natural_convection(wall.natural, gas, rho, c_p, T, state.wall_temperature)
    heat = chamber.wall_conductance + film * wall.area
    return (GAMMA - 1.0) * c_p * T * steepest / chamber.dead_volume, heat / (state.mass * c_p) * GAMMA
