"""Inputs of a joint's detectors in a cycle, and the trace of its last samples."""

from math import inf, nan, sqrt
from typing import NamedTuple

from layflat.jit import law

# Levels of detection: sensors alone; motion too, during a soft start; all, while air is on and valves obey.
SENSORS_LEVEL, MOTION_LEVEL, AIR_LEVEL = 0.0, 1.0, 2.0


class JointSample(NamedTuple):
    """Sample of a joint in one cycle, with estimates and demand."""

    angle: float  # as sampled, rad
    pressure: float  # differential pressure as sampled, Pa
    averaged_pressure: float  # mean of the same over a period of the dither, Pa
    others_light: float  # differential pressure that balances gravity and moving joints, smallest payload, Pa
    others_heavy: float  # the same with the greatest payload
    inertia: float  # of the joint alone, as differential pressure per acceleration, Pa s2/rad
    velocity: float  # rad/s
    opening: float  # of the valve as commanded, 1
    residual: float  # of the air balance, as an opening of the valve (see `physics/air_balance.py`)
    demand: float  # rad
    lead: float  # the greatest lead of any demand, rad
    elapsed: float  # since the last sample, s
    level: float  # level of detection
    alone: float  # 1 where supply and timing are without a fault, so that a deviation is the joint's own


class SampleTrace(NamedTuple):
    """Trace of the last samples of a joint."""

    angle: float = nan  # the last sample, rad
    pressure_1: float = nan  # the last samples, newest first, Pa
    pressure_2: float = nan
    pressure_3: float = nan
    oscillation: float = nan  # difference of the last pressures in which a slope cancels, Pa
    ripple: float = inf  # amplitude of the pressure at a quarter of the loop's rate; infinite at first, Pa
    step: float = 0.0  # last change of the angle, absolute, rad
    speed: float = 0.0  # of that change, rad/s
    same_angle: float = 0.0  # time for which the angle has not changed, s


@law
def count_samples(before, condition):
    """Return the count of successive samples for which a condition has held: 0 where it does not hold now."""
    return before + 1.0 if condition else 0.0


@law
def accumulate_time(before, condition, elapsed):
    """Return the time for which a condition has held without a break, s: 0 where it does not hold now."""
    return before + elapsed if condition else 0.0


@law
def is_angle_unchanged(trace, sample):
    """Return whether the angle equals that of the last sample, at the level at which joints may move."""
    return sample.level >= AIR_LEVEL and sample.angle == trace.angle


@law
def pressure_oscillation(trace, pressure):
    """Return the difference d of the last four pressures, and the dither's amplitude A in them, both Pa.

    d = (p_0 - p_2) - (p_1 - p_3), newest first, in which a constant slope cancels. With four samples per dither period
    A = sqrt((d^2 + d_before^2) / 8). A is infinite while samples are missing.
    """
    oscillation = (pressure - trace.pressure_2) - (trace.pressure_1 - trace.pressure_3)
    size = oscillation * oscillation + trace.oscillation * trace.oscillation
    return oscillation, sqrt(0.125 * size) if size >= 0.0 else inf


@law
def update_trace(trace, sample):
    """Return the trace (last samples, and the times and rates derived from them) after a sample."""
    oscillation, ripple = pressure_oscillation(trace, sample.pressure)
    same = is_angle_unchanged(trace, sample)
    step = trace.step if same else abs(sample.angle - trace.angle)
    speed = trace.speed if same else step / sample.elapsed
    same_angle = accumulate_time(trace.same_angle, same, sample.elapsed)
    return SampleTrace(
        sample.angle, sample.pressure, trace.pressure_1, trace.pressure_2, oscillation, ripple, step, speed, same_angle
    )
