"""The rig's own view of a joint, whatever law controls it: angle, velocity and differential pressure without dither.

| symbol | meaning |
|---|---|
| x, p | angle (rad) and differential pressure (Pa) as sampled |
"""

from typing import NamedTuple

from layflat.control.average import mean4, ripple4
from layflat.jit import law


class Memory(NamedTuple):
    """The last three samples of both, newest first, and the last averaged angle."""

    angle_0: float
    angle_1: float
    angle_2: float
    pressure_0: float
    pressure_1: float
    pressure_2: float
    last_angle: float


class Estimate(NamedTuple):
    """A joint in a cycle; names are those of the recorded signals."""

    averaged_angle: float  # rad
    averaged_velocity: float  # rad/s
    averaged_pressure: float  # differential, Pa
    ripple: float  # amplitude of the pressure at the dither's frequency, Pa


@law
def woken(x, p):
    """Memory of an estimator that wakes up at these samples."""
    return Memory(x, x, x, p, p, p, x)


@law
def estimated(memory, x, p, averaged, elapsed):
    """Memory and estimate after samples taken `elapsed` seconds after the last; averaged: 1, or 0 without dither."""
    x_mean = mean4(x, memory.angle_0, memory.angle_1, memory.angle_2)
    p_mean = mean4(p, memory.pressure_0, memory.pressure_1, memory.pressure_2)
    ripple = ripple4(p, memory.pressure_0, memory.pressure_1, memory.pressure_2)
    x_used = x + averaged * (x_mean - x)
    p_used = p + averaged * (p_mean - p)
    after = Memory(x, memory.angle_0, memory.angle_1, p, memory.pressure_0, memory.pressure_1, x_used)
    return after, Estimate(x_used, (x_used - memory.last_angle) / elapsed, p_used, ripple)
