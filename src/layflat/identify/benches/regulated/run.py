"""Regulated joints through the commands of a log, many candidates at once."""

from math import ceil, isfinite
from typing import NamedTuple

from layflat.arrays import Array
from layflat.identify.benches.regulated.laws import (
    Air,
    JointState,
    RegulatedJoint,
    asked_set_point,
    at_rest,
    chamber_at_rest,
    exchange_gas,
    lag_shares,
    move,
)
from layflat.jit import kernel, law

STEP = 2e-3  # longest step, s
NOTHING, MOTION, PRESSURES = 0, 1, 2  # what of the log is given besides the commands


class Setup(NamedTuple):
    """A joint with the air around it, the delay of its valves (s), and the angle that it begins at (rad)."""

    joint: RegulatedJoint
    air: Air
    delay: float
    start_angle: float


class Course(NamedTuple):
    """Signals of a log by sample, (samples,) each."""

    time: Array  # s, growing
    setpoint_a: Array  # command, absolute, Pa; holds until the next sample
    setpoint_b: Array
    angle: Array  # rad; used where the motion is given
    pressure_a: Array  # absolute, Pa; the first one is the start, the others are used where the pressures are given
    pressure_b: Array


@law
def _asked(valve, offset, commands, j, share, before, p_a):
    # Mean over a step of what is asked: command j, after a share of the step the next one; before the first one came
    # the valve goes on as it was.
    last = len(commands) - 1
    now = asked_set_point(valve, offset, commands[j], p_a) if j >= 0 else before
    after = asked_set_point(valve, offset, commands[min(j + 1, last)], p_a)
    return now + share * (after - now)


@law
def _between(values, k, share):
    return values[k] + share * (values[k + 1] - values[k])


@kernel
def run_regulated(setup, course, given, step, out):
    """Run a joint from rest through a course.

    Args: `Setup`, `Course`, what else is `given`, the longest step (s), and room for angle and both pressures by
    sample, (samples, 3), left not a number from where it diverged.
    """
    time, samples = course.time, len(course.time)
    joint, valve, air = setup.joint, setup.joint.valve, setup.air
    motion = at_rest(setup.start_angle)
    a = chamber_at_rest(joint, motion.angle, course.pressure_a[0], air)
    b = chamber_at_rest(joint, -motion.angle, course.pressure_b[0], air)
    delay, j = setup.delay, -1
    for k in range(samples):
        if not (isfinite(motion.angle) and a.pressure > 0.0 and b.pressure > 0.0 and a.mass * b.mass > 0.0):
            break
        out[k, 0], out[k, 1], out[k, 2] = motion.angle, a.pressure, b.pressure
        if given == PRESSURES:
            out[k, 1], out[k, 2] = course.pressure_a[k], course.pressure_b[k]
        if k == samples - 1:
            break
        count = ceil((time[k + 1] - time[k]) / step - 1e-9)
        h = (time[k + 1] - time[k]) / count
        shares = lag_shares(joint, h)
        for n in range(count):
            share = (n + 1.0) / count
            if given == MOTION:
                q = _between(course.angle, k, share)
                motion = JointState(q, (q - motion.angle) / h, motion.remembered)
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
            asked_a = _asked(valve, valve.offset_a, course.setpoint_a, j, late, a.set_point, p_out)
            asked_b = _asked(valve, valve.offset_b, course.setpoint_b, j, late, b.set_point, p_out)
            a = exchange_gas(joint, a, motion.angle, asked_a, air, shares, h)
            b = exchange_gas(joint, b, -motion.angle, asked_b, air, shares, h)
