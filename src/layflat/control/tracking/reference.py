"""Motion of a reference along its path: straight towards the goal in joint space, as fast as its limits allow.

Along the path the motion has one dimension. In every cycle it takes the maximum acceleration from which it can still
come to rest at the goal with limited acceleration and jerk; the velocity across the path decays. Position and velocity
are relative to the goal, which may move.

| symbol | meaning | unit |
|---|---|---|
| x | distance from the goal, along the path to it: negative before it | rad |
| v, a | velocity and acceleration along the path, relative to the goal | rad/s, rad/s2 |
| d, j | max deceleration, and max jerk at rest | rad/s2, rad/s3 |
| u | velocity at which the flow of open valves just fills the hoses' change of volume | rad/s |
| T | control cycle | s |
"""

from math import sqrt
from typing import NamedTuple

from layflat.jit import composition, law
from layflat.lanes import gather, select, slots

BISECTION_STEPS = 14  # of the search for an acceleration
# The hoses of a moving joint change their volume, which takes part of the valves' flow; only the rest changes torque.
JERK_LOSS = 0.4  # share of the jerk that is lost at velocity u
MIN_JERK_SHARE = 0.4  # share of the jerk that remains at any velocity
MAX_VELOCITY_RATIO = 1.25  # max velocity over u: for a while hoses drive with the air that they hold
OFF_PATH_SPEED = 0.2  # speed of a joint relative to its path from which it counts as off the path, rad/s
MAX_OVERRUN = 0.02  # angle by which a joint off its path may overrun its goal, rad
CROSS_PATH_RATE = 40.0  # decay rate of the velocity across the path, 1/s


class Reference(NamedTuple):
    """Reference of a joint: angle (rad), velocity (rad/s) and acceleration (rad/s2)."""

    angle: float  # rad
    velocity: float  # rad/s
    acceleration: float  # rad/s2


class PathLimits(NamedTuple):
    """Limits of a motion along its path."""

    acceleration: float  # max, rad/s2
    deceleration: float  # d, with which stops are planned, rad/s2
    late_deceleration: float  # max deceleration of a motion that brakes late, rad/s2
    jerk: float  # j, rad/s3
    velocity: float  # u, which may be exceeded for a while, rad/s
    torque_velocity: float  # max velocity by the joints' Coriolis and centrifugal torques, rad/s


@law
def reference_angle(reference):
    """Return the angle of a reference, rad."""
    return reference.angle


@law
def reference_velocity(reference):
    """Return the velocity of a reference, rad/s."""
    return reference.velocity


@law
def stopping_distance(v, a, limits):
    """Return the stopping distance from velocity v and acceleration a within the limits, signed, rad."""
    d, j = limits.deceleration, limits.jerk
    forward = select(v + a * abs(a) / (2.0 * j) >= 0.0, 1.0, -1.0)
    v, a = forward * v, forward * a
    # The jerk that ends the stop is reduced by the change of the hoses' volume.
    j_3 = j * max(1.0 - JERK_LOSS * v / limits.velocity, MIN_JERK_SHARE)
    reduction = max(v + 0.5 * a * a / j, 0.0)  # of the velocity, by the triangle of deceleration
    peak = max(min(sqrt(2.0 * reduction / (1.0 / j + 1.0 / j_3)), d), -a)
    t_1, t_3 = (a + peak) / j, peak / j_3
    v_1 = v + a * t_1 - 0.5 * j * t_1 * t_1
    held = max(v_1 - 0.5 * peak * t_3, 0.0) / max(peak, 1e-9)
    v_2 = v_1 - peak * held
    length = v * t_1 + t_1 * t_1 * (0.5 * a - j * t_1 / 6.0) + held * (v_1 - 0.5 * peak * held)
    return forward * (length + t_3 * (v_2 - t_3 * peak / 3.0))


@law
def _is_too_fast(a_1, remaining, v, a, limits, T):
    """Return whether acceleration a_1 in the next cycle would overrun the remaining path or exceed the max velocity."""
    v_1 = v + 0.5 * T * (a + a_1)
    beyond = 0.5 * T * (v + v_1) + stopping_distance(v_1, a_1, limits) > remaining
    max_velocity = min(MAX_VELOCITY_RATIO * limits.velocity, limits.torque_velocity)
    return beyond | (v_1 + 0.5 * a_1 * max(a_1, 0.0) / limits.jerk > max_velocity)


@law
def next_acceleration(remaining, v, a, limits, T):
    """Return the max acceleration of the next cycle from which the motion can stop within the remaining path (rad).

    If there is none, it is the lowest that jerk and late deceleration allow.
    """
    rise = limits.jerk * min(max(1.0 - JERK_LOSS * v / limits.velocity, MIN_JERK_SHARE), 1.0)
    low, high = a - limits.jerk * T, a + rise * T
    low, high = (
        min(max(low, -limits.late_deceleration), limits.acceleration),
        max(min(high, limits.acceleration), -limits.late_deceleration),
    )
    low, high = min(low, high), max(low, high)
    for _ in range(BISECTION_STEPS):
        middle = 0.5 * (low + high)
        over = _is_too_fast(middle, remaining, v, a, limits, T)
        low, high = select(over, low, middle), select(over, middle, high)
    return 0.5 * (low + high)


@law
def limit_before_goal(a, reference, goal, e, velocity, limits, isolated_limits, T):
    """Return a joint's acceleration, limited so that the joint does not overrun its own goal.

    A joint off the path, with the velocity of a motion to an earlier goal, would overrun it otherwise.

    Args: acceleration, rad/s2; reference; goal (`Reference`); component of the path's unit vector; velocity along the
    path, rad/s; limits of the path, and of the joint alone (`PathLimits`); T.
    """
    d = max(isolated_limits.deceleration, limits.deceleration * abs(e))
    j = max(isolated_limits.jerk, limits.jerk * abs(e))
    joint_limits = PathLimits(
        isolated_limits.acceleration, d, d, j, isolated_limits.velocity, isolated_limits.torque_velocity
    )
    v, a_0, a_1 = reference.velocity - goal.velocity, reference.acceleration - goal.acceleration, a - goal.acceleration
    forward = select(v >= 0.0, 1.0, -1.0)
    v_1 = v + 0.5 * T * (a_0 + a_1)
    ends = reference.angle + 0.5 * T * (v + v_1) + stopping_distance(v_1, a_1, joint_limits)
    brake = max(forward * a_0 - j * T, -d)
    passes = (
        (forward * (ends - goal.angle) > MAX_OVERRUN)
        & (forward * a_1 > brake)
        & (abs(v - velocity * e) > OFF_PATH_SPEED)
    )
    return select(passes, forward * brake + goal.acceleration, a)


@law
def advance_reference(reference, a, T):
    """Return the reference a cycle later, whose acceleration is then a."""
    v = reference.velocity + 0.5 * T * (reference.acceleration + a)
    return Reference(reference.angle + 0.5 * T * (reference.velocity + v), v, a)


@law
def reduce_acceleration(reference, a, T):
    """Return the reference with its acceleration at the end of the last cycle reduced by a."""
    return Reference(reference.angle - 0.5 * T * T * a, reference.velocity - T * a, reference.acceleration - a)


@composition
def path_acceleration(references, goals, direction, limits, T):
    """Return the accelerations of all joints a cycle later, on the path to their goals, rad/s2, a tuple.

    Args: references and goals, tuples of `Reference`; unit vector of the path, a tuple; `PathLimits`; T.
    """
    n = len(direction)
    here, goal, e = slots(references), slots(goals), slots(direction)
    zero = 0.0 * e[0]
    left, v, a = zero, zero, zero
    for j in range(n):
        left = left + (goal[j].angle - here[j].angle) * e[j]
        v = v + (here[j].velocity - goal[j].velocity) * e[j]
        a = a + (here[j].acceleration - goal[j].acceleration) * e[j]
    along = next_acceleration(left, v, a, limits, T)
    across, size = slots(direction, zero), zero
    for j in range(n):
        v_j = here[j].velocity - goal[j].velocity - v * e[j]
        a_j = here[j].acceleration - goal[j].acceleration - a * e[j]
        across[j] = -CROSS_PATH_RATE * v_j - a_j
        size = size + across[j] * across[j]
    part = min(limits.jerk * T / max(sqrt(size), 1e-9), 1.0)
    for j in range(n):
        a_j = here[j].acceleration - goal[j].acceleration - a * e[j]
        across[j] = goal[j].acceleration + along * e[j] + a_j + part * across[j]
    return gather(direction, across)
