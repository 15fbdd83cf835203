"""Limits of the motion along a path, by what the joints' actuators can do.

| symbol | meaning | unit |
|---|---|---|
| e | unit vector of the path from the reference to the goal, in joint space | 1 |
| w | torque per acceleration along the path, of each joint: M e | kg m2 |
| h | torque that holds a joint at rest less the middle of what its hoses give, along the path | N m |
| c | torque of velocities on a joint, over the square of the velocity along the path | N m s2 |
"""

from math import inf, sqrt
from typing import NamedTuple

from layflat.control.tracking.arrival import Tolerance
from layflat.control.tracking.reference import ASIDE, PathLimits, angle_of
from layflat.jit import composition, law
from layflat.lanes import each, select
from layflat.physics.algebra import least, times
from layflat.physics.arms import dynamics
from layflat.physics.stops_and_springs import spring_torque

LEAST_SHARE = 0.1  # of its torque that a joint is always given to accelerate, whatever its friction is estimated to be
LEAST_INERTIA = 1e-3  # along a path, kg m2
SWUNG = 0.4  # share of a joint's torque that may go against those of velocities: they grow with their square


class ActuatorLimits(NamedTuple):
    """Limits of a joint's hoses and valve."""

    torque: float  # greatest, to either side of the middle, N m
    middle: float  # 0 with two hoses, N m
    rate: float  # of the torque with the valve open, N m/s
    speed: float  # at which an open valve just feeds the hoses, rad/s


class Margins(NamedTuple):
    """Shares of its actuators' limits that the arm uses, and its accuracy."""

    braking: float  # share of the torque to decelerate that is planned with
    late: float  # the same where a motion is late
    jerk: float  # share of the torque's rate
    quickest: float  # no move is meant to take less, s
    tolerance: Tolerance


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
def _held(actuator, holds, c, w, going):
    # Along the path, what velocities add to it included.
    h = holds - c * going * going - actuator.middle
    return select(w < 0.0, -h, h)


@law
def _most(actuator, friction, held, w):
    return max(actuator.torque - friction - held, LEAST_SHARE * actuator.torque) / w


@law
def _brakes(actuator, friction, held, w):
    return max(actuator.torque + friction + held, LEAST_SHARE * actuator.torque) / w


@law
def _jerk(actuator, w):
    return actuator.rate / w


@law
def _speed(actuator, e):
    return actuator.speed / max(abs(e), 1e-6)


@law
def _heaviest(here, on, there):
    heavier, later = max(abs(here), LEAST_INERTIA), max(abs(on), abs(there))
    return max(heavier, later)


@law
def _greater(here, on, there):
    later = max(on, there)
    return max(here, later)


@law
def _lesser(here, on, there):
    later = min(on, there)
    return min(here, later)


@law
def _bears(actuator, holds, c):
    # Velocity along the path, rad/s, at which its share of the torque bears c.
    spare = max(actuator.torque - abs(holds - actuator.middle), LEAST_SHARE * actuator.torque)
    return sqrt(SWUNG * spare / max(abs(c), 1e-9))


@law
def _between(q, p):
    return 0.5 * (q + p)


@law
def own_limits(actuator, friction, inertia, holds, speed, margins):
    """Return the limits of a joint alone, of an inertia (kg m2), whichever way it turns; a torque holds it at rest.

    No stop from a speed (rad/s) is meant to take less than a quarter of what a move takes: light joints would swing.
    """
    w, h, quickest = max(inertia, LEAST_INERTIA), abs(holds - actuator.middle), margins.quickest
    gentle = 8.0 * max(abs(speed), ASIDE) / quickest
    brakes = min(_brakes(actuator, friction, -h, w), gentle)
    return PathLimits(
        _most(actuator, friction, h, w),
        margins.braking * brakes,
        margins.late * brakes,
        min(margins.jerk * _jerk(actuator, w), 8.0 * gentle / quickest),
        actuator.speed,
        inf,
    )


class Place(NamedTuple):
    """Demands of a posture on the joints along a path."""

    inertias: tuple[float, ...]  # w, kg m2
    held: tuple[float, ...]  # h, and what velocities add to it, N m
    fastest: float  # at which they bear the torques of velocities, rad/s


@composition
def _place(plant, actuators, payload, q, direction, going):
    mass, swings, pulls = dynamics(plant.arm, payload, q, direction)
    w, holds = times(mass, direction), each(holding, plant.joints, q, pulls)
    held = each(_held, actuators, holds, swings, w, going)
    return Place(w, held, least(each(_bears, actuators, holds, swings)))


@composition
def path_limits(margins, actuators, frictions, payload, plant, angles, goals, direction, going):
    """Return limits along a path, by the torques that remain here, half of the way on and at the goal.

    Whichever of the three leaves less counts. Args: payload, kg; where the path is, rad, a tuple, and how fast the arm
    goes along it, rad/s.
    """
    q = each(angle_of, goals)
    here = _place(plant, actuators, payload, angles, direction, going)
    on = _place(plant, actuators, payload, each(_between, angles, q), direction, going)
    there = _place(plant, actuators, payload, q, direction, going)
    w = each(_heaviest, here.inertias, on.inertias, there.inertias)
    brakes = least(each(_brakes, actuators, frictions, each(_lesser, here.held, on.held, there.held), w))
    return PathLimits(
        least(each(_most, actuators, frictions, each(_greater, here.held, on.held, there.held), w)),
        margins.braking * brakes,
        margins.late * brakes,
        margins.jerk * least(each(_jerk, actuators, w)),
        least(each(_speed, actuators, direction)),
        _lesser(here.fastest, on.fastest, there.fastest),
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
        limits.fastest,
    )
