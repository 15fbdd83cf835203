"""The motion of a reference along its path: straight towards the goal in joint space, as fast as its limits allow.

Along the path it is a motion in one dimension. In every cycle it takes the greatest acceleration from which it can
still come to rest at the goal with limited acceleration and jerk; across the path its velocity dies out. Position and
velocity are those relative to the goal, which may move.

| symbol | meaning | unit |
|---|---|---|
| x | distance from the goal, along the path to it: negative before it | rad |
| v, a | velocity and acceleration along the path, relative to the goal | rad/s, rad/s2 |
| d, j | greatest deceleration, and jerk at rest | rad/s2, rad/s3 |
| u | velocity at which open valves just feed the hoses | rad/s |
| T | control cycle | s |
"""

from math import sqrt
from typing import NamedTuple

from layflat.jit import composition, law
from layflat.lanes import gather, select, slots

HALVINGS = 14
# Hoses of a joint that moves are springs: what valves feed makes up for that before it turns into torque. Share of the
# jerk that is gone at u, least share that is left, and the greatest velocity over u: for a while hoses drive by what
# they hold.
GONE, LEFT, BEYOND = 0.4, 0.4, 1.25
# Of a joint on another way than its path: speed from which that counts, rad/s; how far it may pass its goal, rad.
ASIDE, PASSES = 0.2, 0.02
ACROSS = 40.0  # rate at which the velocity across the path dies out, 1/s


class Reference(NamedTuple):
    """Where a joint should be, and its derivatives."""

    angle: float
    velocity: float
    acceleration: float


class PathLimits(NamedTuple):
    """Limits of a motion along its path."""

    acceleration: float  # greatest, rad/s2
    deceleration: float  # d, with which stops are planned
    hardest: float  # deceleration, of a motion that is late, rad/s2
    jerk: float  # j
    velocity: float  # u, which it may exceed for a while
    fastest: float  # at which joints bear the torques of velocities besides, rad/s


@law
def angle_of(reference):
    """Its angle, rad."""
    return reference.angle


@law
def velocity_of(reference):
    """Its velocity, rad/s."""
    return reference.velocity


@law
def stop_at(v, a, limits):
    """Return how far it still goes when it stops as soon as it can, rad."""
    d, j = limits.deceleration, limits.jerk
    forward = select(v + a * abs(a) / (2.0 * j) >= 0.0, 1.0, -1.0)
    v, a = forward * v, forward * a
    # The jerk that ends the stop has the springs against it.
    j_3 = j * max(1.0 - GONE * v / limits.velocity, LEFT)
    turned = max(v + 0.5 * a * a / j, 0.0)
    peak = max(min(sqrt(2.0 * turned / (1.0 / j + 1.0 / j_3)), d), -a)
    t_1, t_3 = (a + peak) / j, peak / j_3
    v_1 = v + a * t_1 - 0.5 * j * t_1 * t_1
    held = max(v_1 - 0.5 * peak * t_3, 0.0) / max(peak, 1e-9)
    v_2 = v_1 - peak * held
    length = v * t_1 + t_1 * t_1 * (0.5 * a - j * t_1 / 6.0) + held * (v_1 - 0.5 * peak * held)
    return forward * (length + t_3 * (v_2 - t_3 * peak / 3.0))


@law
def _too_fast(a_1, left, v, a, limits, T):
    v_1 = v + 0.5 * T * (a + a_1)
    beyond = 0.5 * T * (v + v_1) + stop_at(v_1, a_1, limits) > left
    most = min(BEYOND * limits.velocity, limits.fastest)
    return beyond | (v_1 + 0.5 * a_1 * max(a_1, 0.0) / limits.jerk > most)


@law
def next_acceleration(left, v, a, limits, T):
    """Return the greatest acceleration a cycle later with which it still stops at what is left of the path."""
    rise = limits.jerk * min(max(1.0 - GONE * v / limits.velocity, LEFT), 1.0)
    low, high = a - limits.jerk * T, a + rise * T
    low, high = (
        min(max(low, -limits.hardest), limits.acceleration),
        max(min(high, limits.acceleration), -limits.hardest),
    )
    low, high = min(low, high), max(low, high)
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        over = _too_fast(middle, left, v, a, limits, T)
        low, high = select(over, low, middle), select(over, middle, high)
    return 0.5 * (low + high)


@law
def kept_before(a, reference, goal, e, going, limits, alone, T):
    """Return a joint's acceleration, no more than that with which it stops at its own goal as soon as it can.

    A joint that is on another way than its path, from a goal before, would pass it. `e`: its share of the path, on
    which the reference is `going` so fast, rad/s; `alone`: what it can do alone.
    """
    d, j = max(alone.deceleration, limits.deceleration * abs(e)), max(alone.jerk, limits.jerk * abs(e))
    own = PathLimits(alone.acceleration, d, d, j, alone.velocity, alone.fastest)
    v, a_0, a_1 = reference.velocity - goal.velocity, reference.acceleration - goal.acceleration, a - goal.acceleration
    forward = select(v >= 0.0, 1.0, -1.0)
    v_1 = v + 0.5 * T * (a_0 + a_1)
    ends = reference.angle + 0.5 * T * (v + v_1) + stop_at(v_1, a_1, own)
    brake = max(forward * a_0 - j * T, -d)
    passes = (forward * (ends - goal.angle) > PASSES) & (forward * a_1 > brake) & (abs(v - going * e) > ASIDE)
    return select(passes, forward * brake + goal.acceleration, a)


@law
def advanced(reference, a, T):
    """Return the reference a cycle later, with an acceleration then."""
    v = reference.velocity + 0.5 * T * (reference.acceleration + a)
    return Reference(reference.angle + 0.5 * T * (reference.velocity + v), v, a)


@law
def taken_back(reference, a, T):
    """Return the reference with so much less acceleration in the last cycle."""
    return Reference(reference.angle - 0.5 * T * T * a, reference.velocity - T * a, reference.acceleration - a)


@composition
def path_acceleration(references, goals, direction, limits, T):
    """Return the accelerations of all joints a cycle later, a tuple, on the path to their goals.

    `goals`: a tuple of `Reference`; `direction`: unit vector of the path, a tuple.
    """
    n = len(direction)
    at, to, e = slots(references), slots(goals), slots(direction)
    zero = 0.0 * e[0]
    left, v, a = zero, zero, zero
    for j in range(n):
        left = left + (to[j].angle - at[j].angle) * e[j]
        v = v + (at[j].velocity - to[j].velocity) * e[j]
        a = a + (at[j].acceleration - to[j].acceleration) * e[j]
    along = next_acceleration(left, v, a, limits, T)
    across, size = slots(direction, zero), zero
    for j in range(n):
        v_j = at[j].velocity - to[j].velocity - v * e[j]
        a_j = at[j].acceleration - to[j].acceleration - a * e[j]
        across[j] = -ACROSS * v_j - a_j
        size = size + across[j] * across[j]
    part = min(limits.jerk * T / max(sqrt(size), 1e-9), 1.0)
    for j in range(n):
        a_j = at[j].acceleration - to[j].acceleration - a * e[j]
        across[j] = to[j].acceleration + along * e[j] + a_j + part * across[j]
    return gather(direction, across)
