"""Limits of the motion along a path, from the torques and torque rates of the joints' actuators.

| symbol | meaning | unit |
|---|---|---|
| e | unit vector of the path from the reference to the goal, in joint space | 1 |
| w | torque per acceleration along the path, of each joint: M e | kg m2 |
| h | torque that holds a joint at rest, less the middle of its torque range, positive along the path | N m |
| c | Coriolis and centrifugal torque on a joint, over the square of the velocity along the path | N m s2 |
"""

from math import inf, sqrt
from typing import NamedTuple

from layflat.control.tracking.arrival import Tolerance
from layflat.control.tracking.reference import OFF_PATH_SPEED, PathLimits, reference_angle
from layflat.jit import composition, law
from layflat.lanes import each, select
from layflat.physics.algebra import min_item, multiply_symmetric
from layflat.physics.arms import dynamics
from layflat.physics.stops_and_springs import spring_torque

MIN_TORQUE_SHARE = 0.1  # share of its torque that a joint always has to accelerate, whatever its estimated friction
MIN_INERTIA = 1e-3  # along a path, kg m2
VELOCITY_TORQUE_SHARE = 0.4  # share of a joint's spare torque that Coriolis and centrifugal torques may take


class ActuatorLimits(NamedTuple):
    """Limits of a joint's hoses and valve."""

    torque: float  # half the range of torques, N m
    middle: float  # middle of this range, N m; 0 with two hoses
    rate: float  # of the torque with an open valve, N m/s
    speed: float  # at which the flow of an open valve just fills the hoses' change of volume, rad/s


class Margins(NamedTuple):
    """Shares of its actuators' limits that the arm uses, and its accuracy."""

    braking: float  # share of the decelerating torque in plans
    late: float  # share of it that may be used if a motion brakes late
    jerk: float  # share of the torque's rate
    min_duration: float  # of a move, s
    tolerance: Tolerance


class LawParts(NamedTuple):
    """Parts of the law: 1, or 0 to leave a part out for comparison."""

    feedforward: float  # of accelerations
    friction: float  # compensation of friction
    governor: float  # slows a reference that the valves can't follow
    landing: float  # new path from where the arm stopped outside its tolerance


@law
def holding_torque(joint, q, pull):
    """Return the torque that holds a joint at rest at an angle (rad) against a pull (N m) of its arm, N m."""
    return -(pull + spring_torque(joint.spring, q))


@law
def _path_torque(actuator, holds, c, w, velocity):
    """Return h, with the torque of the velocity along the path, N m."""
    h = holds - c * velocity * velocity - actuator.middle
    return select(w < 0.0, -h, h)


@law
def _max_acceleration(actuator, friction, h, w):
    return max(actuator.torque - friction - h, MIN_TORQUE_SHARE * actuator.torque) / w


@law
def _max_deceleration(actuator, friction, h, w):
    return max(actuator.torque + friction + h, MIN_TORQUE_SHARE * actuator.torque) / w


@law
def _max_jerk(actuator, w):
    return actuator.rate / w


@law
def _max_speed(actuator, e):
    return actuator.speed / max(abs(e), 1e-6)


@law
def _max_inertia(here, halfway, goal):
    """Return the greatest magnitude of three inertias, at least `MIN_INERTIA`, kg m2."""
    first, later = max(abs(here), MIN_INERTIA), max(abs(halfway), abs(goal))
    return max(first, later)


@law
def _max_of_three(here, halfway, goal):
    later = max(halfway, goal)
    return max(here, later)


@law
def _min_of_three(here, halfway, goal):
    later = min(halfway, goal)
    return min(here, later)


@law
def _torque_limited_speed(actuator, holds, c):
    """Return the velocity along the path, rad/s, at which c takes its share of the torque."""
    spare = max(actuator.torque - abs(holds - actuator.middle), MIN_TORQUE_SHARE * actuator.torque)
    return sqrt(VELOCITY_TORQUE_SHARE * spare / max(abs(c), 1e-9))


@law
def _midpoint(q, p):
    return 0.5 * (q + p)


@law
def joint_path_limits(actuator, friction, inertia, holds, speed, margins):
    """Return the `PathLimits` of a joint by itself, those of the worse direction.

    A stop takes at least a quarter of the min duration of a move, since light joints would oscillate otherwise.

    Args: `ActuatorLimits`; friction, N m; inertia, kg m2; torque that holds the joint at rest, N m; speed from which it
    stops, rad/s; `Margins`.
    """
    w, h, min_duration = max(inertia, MIN_INERTIA), abs(holds - actuator.middle), margins.min_duration
    smooth = 8.0 * max(abs(speed), OFF_PATH_SPEED) / min_duration
    deceleration = min(_max_deceleration(actuator, friction, -h, w), smooth)
    return PathLimits(
        _max_acceleration(actuator, friction, h, w),
        margins.braking * deceleration,
        margins.late * deceleration,
        min(margins.jerk * _max_jerk(actuator, w), 8.0 * smooth / min_duration),
        actuator.speed,
        inf,
    )


class PathLoad(NamedTuple):
    """Load of a configuration on the joints' actuators, along a path."""

    inertias: tuple[float, ...]  # w, kg m2
    torques: tuple[float, ...]  # h, with the torque of the velocity along the path, N m
    torque_velocity: float  # max velocity along the path by the torques of velocities, rad/s


@composition
def _path_load(plant, actuators, payload, q, direction, velocity):
    """Return the load on the actuators at angles q, moving in a direction of joint space at a velocity, rad/s."""
    mass, coriolis, pulls = dynamics(plant.arm, payload, q, direction)
    w, holds = multiply_symmetric(mass, direction), each(holding_torque, plant.joints, q, pulls)
    h = each(_path_torque, actuators, holds, coriolis, w, velocity)
    return PathLoad(w, h, min_item(each(_torque_limited_speed, actuators, holds, coriolis)))


@composition
def path_limits(margins, actuators, frictions, payload, plant, angles, goals, direction, velocity):
    """Return limits along a path: the tightest of those here, halfway to the goal and at the goal.

    Args: `Margins`; `ActuatorLimits`, frictions (N m), tuples; payload, kg; model of the plant; present angles, rad;
    goals (`Reference`); unit vector of the path; velocity along the path, rad/s.
    """
    q = each(reference_angle, goals)
    here = _path_load(plant, actuators, payload, angles, direction, velocity)
    halfway = _path_load(plant, actuators, payload, each(_midpoint, angles, q), direction, velocity)
    goal = _path_load(plant, actuators, payload, q, direction, velocity)
    w = each(_max_inertia, here.inertias, halfway.inertias, goal.inertias)
    low = each(_min_of_three, here.torques, halfway.torques, goal.torques)
    high = each(_max_of_three, here.torques, halfway.torques, goal.torques)
    deceleration = min_item(each(_max_deceleration, actuators, frictions, low, w))
    return PathLimits(
        min_item(each(_max_acceleration, actuators, frictions, high, w)),
        margins.braking * deceleration,
        margins.late * deceleration,
        margins.jerk * min_item(each(_max_jerk, actuators, w)),
        min_item(each(_max_speed, actuators, direction)),
        _min_of_three(here.torque_velocity, halfway.torque_velocity, goal.torque_velocity),
    )


@law
def limit_by_length(limits, length, min_duration):
    """Return limits with which a path of a length (rad) takes at least the duration `min_duration` (s)."""
    # With constant jerk j, a move of duration t has length 1/32 j t^3 and a peak acceleration of 1/4 j t.
    acceleration = 8.0 * length / (min_duration * min_duration)
    return PathLimits(
        min(limits.acceleration, acceleration),
        min(limits.deceleration, acceleration),
        limits.late_deceleration,
        min(limits.jerk, 4.0 * acceleration / min_duration),
        limits.velocity,
        limits.torque_velocity,
    )
