"""What detectors are given of a joint in every cycle, and the trace that its last samples leave."""

from math import inf, nan, sqrt
from typing import NamedTuple

from layflat.jit import law

# What there is to watch: sensors alone; motion too, while air comes; all, where air is there and valves obey.
SENSORS, MOTION, AIR = 0.0, 1.0, 2.0


class Sample(NamedTuple):
    """A joint in one cycle."""

    angle: float  # as sampled, rad
    pressure: float  # differential pressure as sampled, Pa
    averaged_pressure: float  # the same over a dither period, Pa
    others_light: float  # what gravity and joints that turn would hold off of it, with the least payload, Pa
    others_heavy: float  # and with the greatest
    inertia: float  # of the joint alone, as differential pressure per acceleration, Pa s2/rad
    velocity: float  # rad/s
    opening: float  # of the valve as asked for, 1
    residual: float  # air that the valve was not asked for, as an opening of it (see `physics/air_balance.py`)
    demand: float  # rad
    lead: float  # the greatest lead of any demand, rad
    elapsed: float  # since the last sample, s
    level: float  # what there is to watch
    alone: float  # 1 where the supply is beyond doubt, so that what is wrong is the joint's own


class Trace(NamedTuple):
    """What the last samples left."""

    angle: float = nan  # the last sample, rad
    pressure_1: float = nan  # the last samples, newest first, Pa
    pressure_2: float = nan
    pressure_3: float = nan
    swing: float = nan
    ripple: float = inf  # amplitude of the pressure at a quarter of the loop's rate; infinite at first, Pa
    step: float = 0.0  # by which the angle last changed, rad
    speed: float = 0.0  # with which it did, rad/s
    same_angle: float = 0.0  # for which the angle has not changed, s


@law
def counted(before, condition):
    """Samples for which a condition has held."""
    return before + 1.0 if condition else 0.0


@law
def lasted(before, condition, elapsed):
    """Time for which a condition has held, s."""
    return before + elapsed if condition else 0.0


@law
def unchanged(trace, sample):
    """Whether the angle is that of the last sample, where joints may move."""
    return sample.level >= AIR and sample.angle == trace.angle


@law
def swung(trace, pressure):
    """Swing and ripple: a slope cancels in a swing, and two swings are a quarter of a period apart."""
    swing = (pressure - trace.pressure_2) - (trace.pressure_1 - trace.pressure_3)
    size = swing * swing + trace.swing * trace.swing
    return swing, sqrt(0.125 * size) if size >= 0.0 else inf


@law
def followed(trace, sample):
    """The trace after a sample."""
    swing, ripple = swung(trace, sample.pressure)
    same = unchanged(trace, sample)
    step = trace.step if same else abs(sample.angle - trace.angle)
    speed = trace.speed if same else step / sample.elapsed
    same_angle = lasted(trace.same_angle, same, sample.elapsed)
    return Trace(
        sample.angle, sample.pressure, trace.pressure_1, trace.pressure_2, swing, ripple, step, speed, same_angle
    )
