"""Detectors of faults of a machine by its sensors alone, each with its limits, memory and law.

A detector of a joint is a law `find_...(limits, memory, ...) -> (memory, fault)`: the number of its fault (see
`rig/safety/faults.py`), or 0. All conditions are written so that NaN is a fault. docs/rig-faults.md lists the limits.
This module runs all of them in turn; the worst fault counts.
"""

from typing import NamedTuple

from layflat.jit import law
from layflat.rig.safety.detectors import air, angle_frozen, bounds, following, sample

__all__ = ["DetectorLimits"]


class DetectorLimits(NamedTuple):
    """Limits of each detector."""

    rail: bounds.RailLimits
    over_pressure: float  # of the differential pressure, Pa
    over_speed: float  # rad/s
    outside: bounds.StrokeLimits
    suspicion: air.SuspicionLimits  # of the sensors, by the air
    angle_frozen: angle_frozen.FrozenAngleLimits
    valve_unresponsive: air.ValveResponseLimits
    pressure_frozen: air.FrozenPressureLimits
    following: following.FollowingLimits


class DetectorMemory(NamedTuple):
    """Memory of each detector."""

    trace: sample.SampleTrace
    rail: float  # successive samples at fault, as the next three
    over_pressure: float
    over_speed: float
    outside: float
    suspicion: air.SuspicionMemory
    angle_frozen: angle_frozen.FrozenAngleMemory
    valve_unresponsive: float  # s without a ripple
    following: following.FollowingMemory


# Memory of detectors that start.
INITIAL_MEMORY = DetectorMemory(
    sample.SampleTrace(),
    0.0,
    0.0,
    0.0,
    bounds.NOT_YET_INSIDE,
    air.SuspicionMemory(),
    angle_frozen.FrozenAngleMemory(),
    0.0,
    following.FollowingMemory(),
)


@law
def find_joint_fault(limits, memory, joint_sample):
    """Return the memory after a `JointSample`, and the number of the worst fault, or 0; a greater one is worse."""
    now = sample.update_trace(memory.trace, joint_sample)
    at_rail, a = bounds.find_rail(limits.rail, memory.rail, joint_sample)
    pressed, b = bounds.find_over_pressure(limits.over_pressure, memory.over_pressure, joint_sample)
    fast, c = bounds.find_over_speed(limits.over_speed, memory.over_speed, limits.rail, memory.trace, joint_sample)
    out, d = bounds.find_outside(limits.outside, memory.outside, limits.rail, joint_sample)
    doubted, doubts = air.update_suspicion(limits.suspicion, memory.suspicion, memory.trace, now, joint_sample)
    stood, e = angle_frozen.find_angle_frozen(
        limits.angle_frozen, memory.angle_frozen, doubts, memory.trace, now, joint_sample
    )
    blocked = angle_frozen.is_blocked(limits.angle_frozen, stood, now)
    quiet, f = air.find_valve_unresponsive(
        limits.valve_unresponsive, memory.valve_unresponsive, doubts, blocked, now, joint_sample
    )
    g = air.find_pressure_frozen(limits.pressure_frozen, doubted.same_pressure, doubts.suspect)
    left, h = following.find_following_error(limits.following, memory.following, joint_sample)
    after = DetectorMemory(now, at_rail, pressed, fast, out, doubted, stood, quiet, left)
    return after, max(a, b, c, d, e, f, g, h)
