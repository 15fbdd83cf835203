"""Vessels that fill or empty through one path, many candidates at once: classical Runge-Kutta steps between samples."""

from math import isfinite
from typing import NamedTuple

from layflat.arrays import Array
from layflat.identify.benches.vessel.gas import contents, state_of
from layflat.identify.benches.vessel.laws import Filling, Outside, Vessel, exchange, fastest_rates, rates
from layflat.jit import composition, kernel, law

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
    """What acts on a vessel, by sample: (samples,) each."""

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
