"""Vessel that fills or empties through one path: rates of its energy, its mass and its wall's temperature.

| symbol | meaning | unit |
|---|---|---|
| E, m | energy and mass of the gas | J, kg |
| p, T | absolute pressure and temperature of the gas | Pa, K |
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
from layflat.identify.benches.vessel.gas import gas_contents, gas_outflow, gas_state
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


class VesselPath(NamedTuple):
    """Flow path between the vessel and the space outside."""

    conductance: float  # m3/(s Pa)
    critical_ratio: float


class Vessel(NamedTuple):
    """Gas space, wall and path."""

    chamber: Chamber
    wall: Wall
    path: VesselPath


class Outside(NamedTuple):
    """Gas on the other side of the path, and surroundings of the vessel."""

    pressure: float  # absolute, Pa
    temperature: float  # K
    ambient_pressure: float  # absolute, Pa
    ambient_temperature: float  # K


class Filling(NamedTuple):
    """State of a vessel, or its rates (per second)."""

    energy: float  # J
    mass: float  # kg
    wall_temperature: float  # K


class Exchange(NamedTuple):
    """Flows between a vessel, the space outside and the wall."""

    flow: float  # mass flow in, kg/s
    enthalpy: float  # of this flow, J/kg
    temperature: float  # of the gas, K
    heat: float  # heat flow from the wall per kelvin, W/K
    steepest: float  # greatest change of the mass flow by the pressure inside, kg/(s Pa)
    specific_heat: float  # of the thin gas at constant pressure, J/(kg K)


@law
def film_properties(gas, T, T_w):
    """Return the temperature of the film at the wall (K), and the gas's viscosity and conductivity there."""
    T_f = 0.5 * (T + T_w)
    warm = T_f * (1.0 / REFERENCE_TEMPERATURE)
    return T_f, gas.viscosity * warm**0.7, gas.conductivity * warm**0.8


@law
def natural_convection(c, gas, rho, c_p, T, T_w):
    """Return h of turbulent natural convection, W/(m2 K)."""
    T_f, mu, k = film_properties(gas, T, T_w)
    rho_f = rho * T / T_f
    return c * k * (GRAVITY * rho_f * rho_f * c_p * abs(T_w - T) / (T_f * mu * k)) ** (1.0 / 3.0)


@law
def forced_convection(c_f, gas, w, d, D, T, T_w):
    """Return h of a jet of mass flow w that enters through a hole of diameter d, W/(m2 K)."""
    _, mu, k = film_properties(gas, T, T_w)
    return c_f * k / D * (4.0 * max(w, 0.0) / (pi * mu * d)) ** 0.67


@law
def jet_diameter(area):
    """Return the diameter of a round jet of an area, m."""
    return sqrt(4.0 / pi * area)


@law
def compute_exchange(gas, vessel, state, outside, opening):
    """Return the `Exchange` of a `Filling` with the `Outside`, the path open by `opening`, 0..1 of its conductance."""
    chamber, wall, path = vessel.chamber, vessel.wall, vessel.path
    p, T = gas_state(gas, chamber, state.energy, state.mass, outside.ambient_pressure)
    factor, h, rho, c_p = gas_outflow(gas, p, T)
    fills = outside.pressure > p
    if fills:
        factor, h, _, _ = gas_outflow(gas, outside.pressure, outside.temperature)
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
def state_rates(vessel, state, outside, flows):
    """Return the rates of a `Filling`, per second, from its `Exchange` and the temperature `Outside`."""
    wall = vessel.wall
    inward = flows.heat * (state.wall_temperature - flows.temperature)
    outer = wall.outer_conductance * (outside.ambient_temperature - state.wall_temperature)
    return Filling(flows.flow * flows.enthalpy + inward, flows.flow, (outer - inward) / wall.heat_capacity)


@law
def rate_bounds(vessel, state, flows):
    """Return bounds, 1/s, of the rates of pressure equalisation, and of all else, from a `Filling` and its `Exchange`.

    The first is that next to equal pressures. The second is that of the gas's renewal and of the decay of temperature
    differences.
    """
    flow = (GAMMA - 1.0) * flows.specific_heat * flows.temperature * flows.steepest / vessel.chamber.dead_volume
    renewed = GAMMA * (abs(flows.flow) + flows.heat / flows.specific_heat) / state.mass
    return flow, renewed + (flows.heat + vessel.wall.outer_conductance) / vessel.wall.heat_capacity


MAX_FLOW_STEP, MAX_HEAT_STEP = 1.0, 0.3  # longest steps times the bounds of both rates: pressure, and all else
MAX_STEPS = 100_000  # between two samples; a candidate that needs more counts as diverged


class VesselSetup(NamedTuple):
    """Vessel, its outside where the log does not have it, and its pressure (Pa) and temperature (K) at the start."""

    vessel: Vessel
    outside: Outside
    pressure: float
    temperature: float


class VesselInputs(NamedTuple):
    """Input signals of a vessel, (samples,) each."""

    time: Array  # s, increasing
    supply: Array  # absolute pressure outside, Pa, linear in between; not a number: the pressure of `Outside`
    opening: Array  # of the path, 0..1; holds until the next sample


@law
def _outside_at(outside, supply):
    """Return the outside with the pressure `supply` of a log, Pa, or its own where that is NaN."""
    pressure = supply if supply == supply else outside.pressure  # noqa: PLR0124
    return Outside(pressure, outside.temperature, outside.ambient_pressure, outside.ambient_temperature)


@law
def _advance(state, rate, h):
    """Return the state after a step of h seconds at constant rates."""
    return Filling(
        state.energy + h * rate.energy, state.mass + h * rate.mass, state.wall_temperature + h * rate.wall_temperature
    )


@law
def _exchange_rates(gas, vessel, state, outside, opening):
    return state_rates(vessel, state, outside, compute_exchange(gas, vessel, state, outside, opening))


@law
def step_vessel(gas, vessel, state, k_1, middle, after, opening, h):
    """Return the state a step of h (s) later, from its rates k_1 at the start and the outside at its middle and end."""
    k_2 = _exchange_rates(gas, vessel, _advance(state, k_1, 0.5 * h), middle, opening)
    k_3 = _exchange_rates(gas, vessel, _advance(state, k_2, 0.5 * h), middle, opening)
    k_4 = _exchange_rates(gas, vessel, _advance(state, k_3, h), after, opening)
    state = _advance(_advance(state, k_1, h / 6.0), k_4, h / 6.0)
    return _advance(_advance(state, k_2, h / 3.0), k_3, h / 3.0)


@law
def count_steps(vessel, state, flows, time, refined):
    """Return the number of steps for a time (s) at the present rates, `refined` times finer.

    It is 0 for `MAX_STEPS` or more, and for rates that are no numbers.
    """
    flow, rest = rate_bounds(vessel, state, flows)
    count = refined * time * (flow / MAX_FLOW_STEP + rest / MAX_HEAT_STEP)
    return int(count) + 1 if count < MAX_STEPS else 0


@composition
def advance_sample(gas, vessel, default, state, inputs, k, refined):
    """Return the state at sample k + 1 from that at k, and whether it was reached.

    Steps are the longest allowed ones, `refined` times finer; the outside is `default` where the log has no supply.
    """
    opening, time = inputs.opening[k], inputs.time[k + 1] - inputs.time[k]
    first, rise = inputs.supply[k], inputs.supply[k + 1] - inputs.supply[k]
    done = 0.0
    for _ in range(MAX_STEPS):
        outside = _outside_at(default, first + done * rise)
        flows = compute_exchange(gas, vessel, state, outside, opening)
        steps = count_steps(vessel, state, flows, (1.0 - done) * time, refined)
        if steps == 0:
            break
        fraction = (1.0 - done) / steps
        middle = _outside_at(default, first + (done + 0.5 * fraction) * rise)
        after = _outside_at(default, first + (done + fraction) * rise)
        k_1 = state_rates(vessel, state, outside, flows)
        state = step_vessel(gas, vessel, state, k_1, middle, after, opening, fraction * time)
        if steps == 1:
            return state, True
        done += fraction
    return state, False


@kernel
def run_vessel(setup, gas, inputs, refined, out):
    """Simulate a vessel from rest through a log.

    Args: `VesselSetup`, a gas of gas.py, `VesselInputs`, a divisor of the default step, and an array for pressure (Pa)
    and temperatures of gas and wall (K) by sample, (samples, 3), not a number from where it diverged.
    """
    vessel, T, p_a = setup.vessel, setup.temperature, setup.outside.ambient_pressure
    samples = len(inputs.time)
    E, m = gas_contents(gas, vessel.chamber, setup.pressure, T, p_a)
    state = Filling(E, m, T)
    for k in range(samples):
        p, T = gas_state(gas, vessel.chamber, state.energy, state.mass, p_a)
        if not (isfinite(p) and p >= 0.0 and T > 0.0):
            break
        out[k, 0], out[k, 1], out[k, 2] = p, T, state.wall_temperature
        if k == samples - 1:
            break
        state, reached = advance_sample(gas, vessel, setup.outside, state, inputs, k, refined)
        if not reached:
            break
