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

Many candidates run at once, by classical Runge-Kutta steps between the samples.
"""

from math import isfinite, pi, sqrt
from typing import NamedTuple

from layflat.arrays import Array
from layflat.identify.benches.vessel.gas import contents, state_of, stream
from layflat.jit import composition, kernel, law
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
    """Path from the vessel to the place beyond."""

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
    """Flows between a vessel, the place beyond and the wall."""

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
    """Return what passes while the path is open by `opening`, 0..1 of its conductance."""
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


FLOW_STEP, STEP = 1.0, 0.3
"""Longest steps over the shortest times in which flow next to equal pressures, and all else, would end a difference."""

MOST_STEPS = 100_000  # between two samples; a candidate that needs more counts as diverged


class Setup(NamedTuple):
    """A vessel, what is outside where the log does not say, and its pressure (Pa) and temperature (K) at the start."""

    vessel: Vessel
    outside: Outside
    pressure: float
    temperature: float


class Course(NamedTuple):
    """Signals that act on a vessel, by sample: (samples,) each."""

    time: Array  # s, growing
    supply: Array  # absolute pressure beyond the path, Pa, linear in between; not a number: the pressure of `Outside`
    opening: Array  # of the path, 0..1; holds until the next sample


@law
def _beyond(outside, supply):
    pressure = supply if supply == supply else outside.pressure  # noqa: PLR0124
    return Outside(pressure, outside.temperature, outside.ambient_pressure, outside.ambient_temperature)


@law
def _moved(state, rate, h):
    return Filling(
        state.energy + h * rate.energy, state.mass + h * rate.mass, state.wall_temperature + h * rate.wall_temperature
    )


@law
def _rates(gas, vessel, state, outside, opening):
    return rates(vessel, state, outside, exchange(gas, vessel, state, outside, opening))


@law
def step_vessel(gas, vessel, state, k_1, middle, after, opening, h):
    """State a step of h later; given the rates at its beginning, and what is outside in its middle and at its end."""
    k_2 = _rates(gas, vessel, _moved(state, k_1, 0.5 * h), middle, opening)
    k_3 = _rates(gas, vessel, _moved(state, k_2, 0.5 * h), middle, opening)
    k_4 = _rates(gas, vessel, _moved(state, k_3, h), after, opening)
    state = _moved(_moved(state, k_1, h / 6.0), k_4, h / 6.0)
    return _moved(_moved(state, k_2, h / 3.0), k_3, h / 3.0)


@law
def steps_for(vessel, state, passes, time, refined):
    """Number of steps in which to go through a time (s) at the rates of now; 0 if no number will do."""
    flow, rest = fastest_rates(vessel, state, passes)
    count = refined * time * (flow / FLOW_STEP + rest / STEP)
    return int(count) + 1 if count < MOST_STEPS else 0


@composition
def cross(gas, vessel, usual, state, course, k, refined):
    """State at sample k + 1, given that at sample k, and whether it came there; every step is as long as it may be."""
    opening, time = course.opening[k], course.time[k + 1] - course.time[k]
    first, rise = course.supply[k], course.supply[k + 1] - course.supply[k]
    gone = 0.0
    for _ in range(MOST_STEPS):
        outside = _beyond(usual, first + gone * rise)
        passes = exchange(gas, vessel, state, outside, opening)
        left = steps_for(vessel, state, passes, (1.0 - gone) * time, refined)
        if left == 0:
            break
        share = (1.0 - gone) / left
        middle = _beyond(usual, first + (gone + 0.5 * share) * rise)
        after = _beyond(usual, first + (gone + share) * rise)
        k_1 = rates(vessel, state, outside, passes)
        state = step_vessel(gas, vessel, state, k_1, middle, after, opening, share * time)
        if left == 1:
            return state, True
        gone += share
    return state, False


@kernel
def run_vessel(setup, gas, course, refined, out):
    """Run a vessel from rest through a course.

    Args: `Setup`, a gas of gas.py, `Course`, by what to divide the default step (results are then nearer to the laws),
    and room for pressure (Pa), temperatures of gas and wall (K) by sample, (samples, 3), left not a number from where
    it diverged.
    """
    vessel, T, p_a = setup.vessel, setup.temperature, setup.outside.ambient_pressure
    samples = len(course.time)
    E, m = contents(gas, vessel.chamber, setup.pressure, T, p_a)
    state = Filling(E, m, T)
    for k in range(samples):
        p, T = state_of(gas, vessel.chamber, state.energy, state.mass, p_a)
        if not (isfinite(p) and p >= 0.0 and T > 0.0):
            break
        out[k, 0], out[k, 1], out[k, 2] = p, T, state.wall_temperature
        if k == samples - 1:
            break
        state, there = cross(gas, vessel, setup.outside, state, course, k, refined)
        if not there:
            break
