"""Vessels that fill or empty through one path, many candidates at once: classical Runge-Kutta steps between samples."""

from __future__ import annotations

from math import isfinite
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from layflat.identify.benches.vessel.gas import IdealAir, RealGas, contents, state_of
from layflat.identify.benches.vessel.laws import Filling, Outside, Path, Vessel, exchange, fastest_rates, rates
from layflat.identify.benches.vessel.wall import Wall
from layflat.jit import composition, kernel, law
from layflat.parallel import on_all_cores, parts
from layflat.physics.chamber import Chamber
from layflat.physics.flow import laminar_slope

Array = NDArray[np.float64]

FLOW_STEP, STEP = 1.0, 0.3
"""Longest steps over the shortest times in which flow next to equal pressures, and all else, would end a difference."""

MOST_STEPS = 100_000
"""Between two samples; a candidate that needs more counts as diverged."""


class Candidates(NamedTuple):
    """What differs from candidate to candidate, SI: (candidates,) each; see description.py."""

    volume: Array
    compliance: Array
    wall_conductance: Array
    area: Array
    diameter: Array
    natural: Array
    forced: Array
    heat_capacity: Array
    outer_conductance: Array
    conductance: Array
    critical_ratio: Array
    outside_pressure: Array
    outside_temperature: Array
    ambient_pressure: Array
    ambient_temperature: Array
    start_pressure: Array
    start_temperature: Array


class Course(NamedTuple):
    """What acts on a vessel, by sample: (samples,) each."""

    time: Array
    """s, growing."""
    supply: Array
    """Absolute pressure beyond the path, Pa, linear in between; not a number: `outside_pressure` of the candidate."""
    opening: Array
    """Of the path, 0..1; holds until the next sample."""


@law
def _vessel(c, i):
    chamber = Chamber(c.volume[i], c.compliance[i], c.wall_conductance[i])
    wall = Wall(c.area[i], c.diameter[i], c.natural[i], c.forced[i], c.heat_capacity[i], c.outer_conductance[i])
    b = c.critical_ratio[i]
    return Vessel(chamber, wall, Path(c.conductance[i], b, laminar_slope(b)))


@law
def _beyond(c, i, supply):
    pressure = supply if supply == supply else c.outside_pressure[i]  # noqa: PLR0124
    return Outside(pressure, c.outside_temperature[i], c.ambient_pressure[i], c.ambient_temperature[i])


@law
def _moved(state, rate, h):
    return Filling(
        state.energy + h * rate.energy,
        state.mass + h * rate.mass,
        state.wall_temperature + h * rate.wall_temperature,
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
def cross(gas, candidates, i, vessel, state, course, k, refined):
    """State at sample k + 1, given that at sample k, and whether it came there; every step is as long as it may be."""
    opening, time = course.opening[k], course.time[k + 1] - course.time[k]
    first, rise = course.supply[k], course.supply[k + 1] - course.supply[k]
    gone = 0.0
    for _ in range(MOST_STEPS):
        outside = _beyond(candidates, i, first + gone * rise)
        passes = exchange(gas, vessel, state, outside, opening)
        left = steps_for(vessel, state, passes, (1.0 - gone) * time, refined)
        if left == 0:
            break
        share = (1.0 - gone) / left
        middle = _beyond(candidates, i, first + (gone + 0.5 * share) * rise)
        after = _beyond(candidates, i, first + (gone + share) * rise)
        k_1 = rates(vessel, state, outside, passes)
        state = step_vessel(gas, vessel, state, k_1, middle, after, opening, share * time)
        if left == 1:
            return state, True
        gone += share
    return state, False


@kernel
def run_vessels(gas, candidates, course, refined, out):
    """Run every candidate from rest through a course.

    Args: a gas of gas.py, `Candidates`, `Course`, by what to divide the default step, and room for pressure,
    temperature and wall temperature by sample, (candidates, samples, 3), left not a number where a candidate diverged.
    """
    samples = len(course.time)
    for i in range(len(candidates.volume)):
        vessel = _vessel(candidates, i)
        outside = _beyond(candidates, i, course.supply[0])
        T = candidates.start_temperature[i]
        E, m = contents(gas, vessel.chamber, candidates.start_pressure[i], T, outside.ambient_pressure)
        state = Filling(E, m, T)
        for k in range(samples):
            p, T = state_of(gas, vessel.chamber, state.energy, state.mass, outside.ambient_pressure)
            if not (isfinite(p) and p >= 0.0 and T > 0.0):
                break
            out[i, k, 0], out[i, k, 1], out[i, k, 2] = p, T, state.wall_temperature
            if k == samples - 1:
                break
            state, there = cross(gas, candidates, i, vessel, state, course, k, refined)
            if not there:
                break


def simulate_vessels(
    gas: IdealAir | RealGas, candidates: Candidates, course: Course, *, refined: float = 1.0, threads: int | None = None
) -> Array:
    """Run many candidates from rest through a course, on all cores.

    Args:
        gas: what fills them.
        candidates: their parameters, (candidates,) each.
        course: what acts on them, (samples,) each.
        refined: divides the default step; results are then nearer to the laws.
        threads: default: one a core. Results do not depend on it.

    Returns:
        Pressure (Pa), temperature of gas and of wall (K) by candidate and sample, (candidates, samples, 3); not numbers
        from where a candidate diverged.
    """
    count = len(candidates.volume)
    out = np.full((count, len(course.time), 3), np.nan)

    def work(part: slice) -> None:
        run_vessels(gas, Candidates(*(column[part] for column in candidates)), course, refined, out[part])

    on_all_cores(work, parts(count, threads=threads), threads)
    return out
