"""All detectors of a joint, one after the other; the worst fault that they find."""

from typing import NamedTuple

from layflat.jit import law
from layflat.rig.safety.detectors import (
    angle_frozen,
    doubt,
    following,
    outside,
    over_pressure,
    over_speed,
    pressure_frozen,
    rail,
    sample,
    valve_unresponsive,
)  # fmt: skip


class Limits(NamedTuple):
    """Limits of each detector."""

    rail: rail.Limits
    over_pressure: float  # of the differential pressure, Pa
    over_speed: float  # rad/s
    outside: outside.Limits
    doubt: doubt.Limits
    angle_frozen: angle_frozen.Limits
    valve_unresponsive: valve_unresponsive.Limits
    pressure_frozen: pressure_frozen.Limits
    following: following.Limits


class Memory(NamedTuple):
    """Memory of each detector."""

    trace: sample.Trace
    rail: float  # samples at fault, as the next three
    over_pressure: float
    over_speed: float
    outside: float
    doubt: doubt.Memory
    angle_frozen: angle_frozen.Memory
    valve_unresponsive: float  # s without a ripple
    following: following.Memory


# Of detectors that begin.
FRESH = Memory(
    sample.Trace(), 0.0, 0.0, 0.0, outside.AWAY, doubt.Memory(), angle_frozen.Memory(), 0.0, following.Memory()
)


@law
def find(limits, memory, taken):
    """Memory after a `Sample`, and the number of the worst fault; a greater one is worse."""
    now = sample.followed(memory.trace, taken)
    at_rail, a = rail.find(limits.rail, memory.rail, taken)
    pressed, b = over_pressure.find(limits.over_pressure, memory.over_pressure, taken)
    fast, c = over_speed.find(limits.over_speed, memory.over_speed, limits.rail, memory.trace, taken)
    out, d = outside.find(limits.outside, memory.outside, limits.rail, taken)
    doubted, doubts = doubt.doubt(limits.doubt, memory.doubt, memory.trace, now, taken)
    stood, e = angle_frozen.find(limits.angle_frozen, memory.angle_frozen, doubts, memory.trace, now, taken)
    blocked = angle_frozen.blocked(limits.angle_frozen, stood, now)
    air, f = valve_unresponsive.find(limits.valve_unresponsive, memory.valve_unresponsive, doubts, blocked, now, taken)
    g = pressure_frozen.find(limits.pressure_frozen, doubted.same_pressure, doubts.suspect)
    left, h = following.find(limits.following, memory.following, taken)
    after = Memory(now, at_rail, pressed, fast, out, doubted, stood, air, left)
    return after, max(a, b, c, d, e, f, g, h)
