"""Regulated joints through the commands of a log, many candidates at once."""

from __future__ import annotations

from math import ceil, isfinite
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from layflat.identify.benches.regulated.friction import LaggingFriction
from layflat.identify.benches.regulated.joint import (
    Air,
    JointState,
    RegulatedJoint,
    at_rest,
    chamber_at_rest,
    exchange_gas,
    lag_shares,
    move,
)
from layflat.identify.benches.regulated.regulator import Regulator, asked_set_point
from layflat.jit import kernel, law
from layflat.parallel import on_all_cores, parts
from layflat.physics.chamber import Chamber
from layflat.physics.flow import laminar_slope

Array = NDArray[np.float64]

STEP = 1e-3
"""Longest step, s."""

NOTHING, MOTION, PRESSURES = 0, 1, 2
"""What of the log is given besides the commands."""


class Candidates(NamedTuple):
    """What differs from candidate to candidate, SI, (candidates,) each; see joint.py."""

    gain: Array
    offset: Array
    lag: Array
    delay: Array
    conductance_in: Array
    conductance_out: Array
    band_in: Array
    band_out: Array
    critical_ratio: Array
    volume: Array
    wall_conductance: Array
    supply_pressure: Array
    ambient_pressure: Array
    temperature: Array
    torque_per_pressure: Array
    inertia: Array
    damping: Array
    load_torque: Array
    stiffness: Array
    friction_torque: Array
    friction_fade: Array
    friction_lag: Array
    lower_stop: Array
    upper_stop: Array
    start_angle: Array


class Course(NamedTuple):
    """Signals of a log by sample, (samples,) each."""

    time: Array
    """s, growing."""
    setpoint_a: Array
    """Command, absolute, Pa; holds until the next sample."""
    setpoint_b: Array
    angle: Array
    """rad; used where the motion is given."""
    pressure_a: Array
    """Absolute, Pa; the first one is the start, the others are used where the pressures are given."""
    pressure_b: Array


@law
def _joint(c, i):
    b = c.critical_ratio[i]
    valve = Regulator(
        c.gain[i],
        c.offset[i],
        c.lag[i],
        c.conductance_in[i],
        c.conductance_out[i],
        c.band_in[i],
        c.band_out[i],
        b,
        laminar_slope(b),
    )
    return RegulatedJoint(
        valve,
        Chamber(c.volume[i], 0.0, c.wall_conductance[i]),
        c.torque_per_pressure[i],
        c.inertia[i],
        c.damping[i],
        c.load_torque[i],
        c.stiffness[i],
        LaggingFriction(c.friction_torque[i], c.friction_fade[i], c.friction_lag[i]),
        c.lower_stop[i],
        c.upper_stop[i],
    )


@law
def _asked(valve, commands, j, share, before, p_a):
    # Mean over a step of what is asked: command j, after a share of the step the next one; before the first one came
    # the valve goes on as it was.
    last = len(commands) - 1
    now = asked_set_point(valve, commands[j], p_a) if j >= 0 else before
    after = asked_set_point(valve, commands[min(j + 1, last)], p_a)
    return now + share * (after - now)


@law
def _between(values, k, share):
    return values[k] + share * (values[k + 1] - values[k])


@kernel
def run_regulated(candidates, course, given, step, out):
    """Run every candidate from rest through a course.

    Args: `Candidates`, `Course`, what else is `given`, the longest step (s), and room for angle and both pressures by
    sample, (candidates, samples, 3), left not a number where a candidate diverged.
    """
    time, samples = course.time, len(course.time)
    for i in range(len(candidates.gain)):
        joint = _joint(candidates, i)
        air = Air(candidates.supply_pressure[i], candidates.ambient_pressure[i], candidates.temperature[i])
        motion = at_rest(joint, candidates.start_angle[i])
        a = chamber_at_rest(joint, motion.angle, course.pressure_a[0], air)
        b = chamber_at_rest(joint, -motion.angle, course.pressure_b[0], air)
        delay, j = candidates.delay[i], -1
        for k in range(samples):
            if not (isfinite(motion.angle) and a.pressure > 0.0 and b.pressure > 0.0 and a.mass * b.mass > 0.0):
                break
            out[i, k, 0], out[i, k, 1], out[i, k, 2] = motion.angle, a.pressure, b.pressure
            if given == PRESSURES:
                out[i, k, 1], out[i, k, 2] = course.pressure_a[k], course.pressure_b[k]
            if k == samples - 1:
                break
            count = ceil((time[k + 1] - time[k]) / step - 1e-9)
            h = (time[k + 1] - time[k]) / count
            shares = lag_shares(joint, h)
            for n in range(count):
                share = (n + 1.0) / count
                if given == MOTION:
                    q = _between(course.angle, k, share)
                    motion = JointState(q, (q - motion.angle) / h, motion.friction)
                elif given == PRESSURES:
                    p_a, p_b = _between(course.pressure_a, k, share), _between(course.pressure_b, k, share)
                    motion = move(joint, motion, p_a, p_b, shares, h)
                else:
                    motion = move(joint, motion, a.pressure, b.pressure, shares, h)
                if given == PRESSURES:
                    continue
                end = time[k] + share * (time[k + 1] - time[k]) - delay
                while j + 1 < samples and time[j + 1] <= end - h:
                    j += 1
                late = (end - time[j + 1]) / h if j + 1 < samples else 0.0
                late = min(max(late, 0.0), 1.0)
                p_out = air.ambient_pressure
                asked_a = _asked(joint.valve, course.setpoint_a, j, late, a.set_point, p_out)
                asked_b = _asked(joint.valve, course.setpoint_b, j, late, b.set_point, p_out)
                a = exchange_gas(joint, a, motion.angle, asked_a, air, shares, h)
                b = exchange_gas(joint, b, -motion.angle, asked_b, air, shares, h)


def simulate_regulated(
    candidates: Candidates,
    courses: list[Course],
    *,
    given: int = NOTHING,
    step: float = STEP,
    threads: int | None = None,
) -> list[Array]:
    """Run many candidates from rest through several courses, on all cores.

    Args:
        candidates: their parameters, (candidates,) each; `start_angle` (courses, candidates).
        courses: what acts in each.
        given: `MOTION` if the joint moves as measured, `PRESSURES` if the pressures are those measured.
        step: longest step, s.
        threads: default: one a core. Results do not depend on it.

    Returns:
        Angle (rad) and absolute pressures (Pa) by candidate and sample, (candidates, samples, 3) for each course; not
        numbers from where a candidate diverged.
    """
    count = len(candidates.gain)
    found = [np.full((count, len(course.time), 3), np.nan) for course in courses]

    def work(job: tuple[int, slice]) -> None:
        number, part = job
        own = candidates._replace(start_angle=candidates.start_angle[number])
        some = Candidates(*(np.ascontiguousarray(column[part]) for column in own))
        run_regulated(some, courses[number], given, step, found[number][part])

    shares = parts(count, len(courses), threads)
    on_all_cores(work, [(number, part) for number in range(len(courses)) for part in shares], threads)
    return found
