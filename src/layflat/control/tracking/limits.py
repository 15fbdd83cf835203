"""Limits of the motion along a path, by what the joints' actuators can do.

| symbol | meaning | unit |
|---|---|---|
| e | unit vector of the path from the reference to the goal, in joint space | 1 |
| w | torque per acceleration along the path, of each joint: M e | kg m2 |
| h | torque that holds a joint at rest less the middle of what its hoses give, along the path | N m |
"""

from typing import NamedTuple

from layflat.control.tracking.reference import PathLimits, angle_of, velocity_of
from layflat.jit import composition, law
from layflat.lanes import each, select
from layflat.physics.algebra import least, times
from layflat.physics.arms import dynamics
from layflat.physics.spring import spring_torque

LEAST_SHARE = 0.1  # of its torque that a joint is always given to accelerate, whatever its friction is estimated to be
LEAST_INERTIA = 1e-3  # along a path, kg m2


class ActuatorLimits(NamedTuple):
    """What hoses and valve of a joint can do."""

    torque: float  # greatest, to either side of the middle, N m
    middle: float  # 0 with two hoses, N m
    rate: float  # of the torque with the valve open, N m/s
    speed: float  # at which an open valve just feeds the hoses, rad/s


class Margins(NamedTuple):
    """How much of its actuators' limits the arm uses, and how exact it is."""

    braking: float  # share of the torque to decelerate that is planned with
    late: float  # the same where a motion is late
    jerk: float  # share of the torque's rate
    quickest: float  # no move is meant to take less, s
    tolerance: float  # distance of the tip from its goal within which the arm has arrived, m


class Parts(NamedTuple):
    """Parts of the law, 1, or 0 where it does without one: for comparisons."""

    feedforward: float  # of accelerations
    friction: float  # torque against friction
    governor: float  # that slows a reference which valves can't follow
    landing: float  # setting out again from beside the goal


@law
def holding(joint, q, pull):
    """Return the torque that holds a joint at rest at an angle (rad) against a pull (N m) of its arm, N m."""
    return -(pull + spring_torque(joint.spring, q))


@law
def _held(actuator, holds, w):
    h = holds - actuator.middle
    return select(w < 0.0, -h, h)


@law
def _most(actuator, friction, here, there, w):
    return max(actuator.torque - friction - max(here, there), LEAST_SHARE * actuator.torque) / w


@law
def _brakes(actuator, friction, here, there, w):
    return max(actuator.torque + friction + min(here, there), LEAST_SHARE * actuator.torque) / w


@law
def _jerk(actuator, w):
    return actuator.rate / w


@law
def _speed(actuator, e):
    return actuator.speed / max(abs(e), 1e-6)


@law
def _heavier(here, there):
    heavier = max(abs(here), abs(there))
    return max(heavier, LEAST_INERTIA)


@law
def own_limits(actuator, friction, inertia, holds, margins):
    """Return the limits of a joint alone, of an inertia (kg m2), whichever way it turns; a torque holds it at rest."""
    w, h = max(inertia, LEAST_INERTIA), abs(holds - actuator.middle)
    return PathLimits(
        _most(actuator, friction, h, h, w),
        margins.braking * _brakes(actuator, friction, -h, -h, w),
        margins.late * _brakes(actuator, friction, -h, -h, w),
        margins.jerk * _jerk(actuator, w),
        actuator.speed,
    )


@composition
def path_limits(margins, actuators, estimate, plant, response, goals, direction):
    """Return limits along a path, by the torques that remain here and at the goal, whichever leave less."""
    q = each(angle_of, goals)
    mass, _, pulls = dynamics(plant.arm, estimate.payload, q, each(velocity_of, goals))
    w_1, w_2 = times(response.mass, direction), times(mass, direction)
    here = each(_held, actuators, response.holds, w_1)
    there = each(_held, actuators, each(holding, plant.joints, q, pulls), w_2)
    w = each(_heavier, w_1, w_2)
    brakes = least(each(_brakes, actuators, estimate.frictions, here, there, w))
    return PathLimits(
        least(each(_most, actuators, estimate.frictions, here, there, w)),
        margins.braking * brakes,
        margins.late * brakes,
        margins.jerk * least(each(_jerk, actuators, w)),
        least(each(_speed, actuators, direction)),
    )


@law
def for_length(limits, length, quickest):
    """Return limits with which a path of this length (rad) takes some time at least (s), were jerk the only limit."""
    # Jerk alone takes t for 1/32 j t^3, and comes to an acceleration of 1/4 j t on the way.
    acceleration = 8.0 * length / (quickest * quickest)
    return PathLimits(
        min(limits.acceleration, acceleration),
        min(limits.deceleration, acceleration),
        limits.hardest,
        min(limits.jerk, 4.0 * acceleration / quickest),
        limits.velocity,
    )
