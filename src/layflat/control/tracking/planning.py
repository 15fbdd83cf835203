"""Where the joints should be in the next cycle: the reference on its way to the goal, and when it has landed.

| symbol | meaning | unit |
|---|---|---|
| e | unit vector of the way from the reference to the goal, in joint space | 1 |
| T | control cycle | s |
"""

from math import sqrt
from typing import Any, NamedTuple

from layflat.control.tracking.algebra import diagonal, dot, greatest, largest, least, times
from layflat.control.tracking.model import loss_torque
from layflat.control.tracking.pace import LEAST_INERTIA, LEAST_SHARE, gentle, pace_of
from layflat.control.tracking.reference import Pace, Reference, advanced, angle_of, taken_back, towards, velocity_of
from layflat.jit import composition, law
from layflat.lanes import each, select
from layflat.physics.arms import tip

SHORTEST = 1e-4  # way that is planned, rad
REST = 1e-3  # velocity of a goal below which it is at rest, rad/s
CALM = 0.05  # velocity of joints that have all but stopped, rad/s


class Ahead(NamedTuple):
    """The arm a cycle later, were its valves centred; tuples with an item a joint."""

    states: tuple[Any, ...]
    angles: tuple[float, ...]
    velocities: tuple[float, ...]
    mass: tuple[float, ...]  # upper triangle
    steady: tuple[float, ...]  # torque that keeps the velocity, friction and losses aside, N m


class Course(NamedTuple):
    """Where the arm is on its way, kept from cycle to cycle."""

    references: tuple[Reference, ...]
    leg: float  # length of the way when it began, rad
    landed: float  # 1 where the references are the goals', else 0


class Plan(NamedTuple):
    """The next cycle."""

    references: tuple[Reference, ...]
    leg: float
    landed: float
    rests: float  # 1 where the goal is at rest, else 0
    resting: float  # 1 where it has landed, the goal is at rest and the tip there, else 0
    way: tuple[float, ...]
    pace: Pace


@law
def goal_of(angle, velocity, acceleration, late):
    """A demand as a reference, so many seconds later."""
    return Reference(
        angle + late * (velocity + 0.5 * late * acceleration), velocity + late * acceleration, acceleration
    )


@law
def _apart(reference, goal):
    return goal.angle - reference.angle


@law
def _gain(reference, goal):
    return reference.velocity - goal.velocity


@law
def _per(x, size):
    return x / size


@law
def _restless(goal):
    return abs(goal.velocity) + abs(goal.acceleration)


@composition
def tip_distance(arm, q, p):
    """Distance of the tips of an arm at two postures, m."""
    (x, y), (x_p, y_p) = tip(arm, q), tip(arm, p)
    return sqrt((x - x_p) * (x - x_p) + (y - y_p) * (y - y_p))


@law
def _feasible(able, friction, joint, state, speed, inertial, steady, load):
    # Share of a torque that a joint can give.
    rubs = friction + abs(loss_torque(joint, state))
    force = inertial + steady - load
    return (able.torque + select(force * speed > 0.0, -rubs, rubs)) / max(abs(force), 1e-3)


@law
def _onward(reference, goal, a, share, landed, T):
    # A reference that has landed goes along with its goal.
    free, with_goal = advanced(reference, share * a, T), advanced(goal, goal.acceleration, T)
    return Reference(
        select(landed, with_goal.angle, free.angle),
        select(landed, with_goal.velocity, free.velocity),
        select(landed, with_goal.acceleration, free.acceleration),
    )


@composition
def planned(settings, course, belief, ahead, goals, T):
    """`Plan` of the next cycle, on the way to goals (a tuple of `Reference`)."""
    plant, care, references = settings.plant, settings.care, course.references
    apart = each(_apart, references, goals)
    distance = sqrt(dot(apart, apart))
    way = each(_per, apart, max(distance, 1e-9))
    leg = max(select(course.landed > 0.5, 0.0, course.leg), distance)
    full = pace_of(care, settings.abilities, belief, plant.arm, ahead, goals, way, references)
    pace = gentle(full, max(leg, SHORTEST), care.quickest)
    a = towards(references, goals, way, pace, T)
    speeds, gains = each(velocity_of, references), each(_gain, references, goals)
    inertial = times(ahead.mass, a)
    shares = each(
        _feasible, settings.abilities, belief.frictions, plant.joints, ahead.states, speeds, inertial, ahead.steady,
        belief.loads,
    )  # fmt: skip
    share = max(min(least(shares), 1.0), LEAST_SHARE)
    rests = largest(each(_restless, goals)) < REST
    inside = tip_distance(plant.arm, ahead.angles, each(angle_of, goals)) < care.tolerance
    landed = _lands(course.landed > 0.5, rests, distance, largest(gains))
    landed = landed | (rests & inside & (largest(ahead.velocities) < CALM))
    onward = each(_onward, references, goals, a, share, landed, T)
    # A way begins where the arm turns to the goal.
    turns = (dot(way, gains) <= 0.0) & (dot(way, each(_gain, onward, goals)) > 0.0)
    return Plan(
        onward,
        select(turns, distance, leg),
        select(landed, 1.0, 0.0) + 0.0 * distance,
        select(rests, 1.0, 0.0) + 0.0 * distance,
        select(landed & rests & inside, 1.0, 0.0) + 0.0 * distance,
        way,
        pace,
    )


@law
def _lands(landed, rests, distance, speed):
    # Whether a reference is put on its goal: a moving one is caught from further off, and one that was is kept.
    near, slow = select(rests, 1e-3, 2e-3), select(rests, 0.05, 0.2)
    near, slow = select(landed, 4e-3, near), select(landed, 0.4, slow)
    return (distance < near) & (speed < slow)


@law
def _short(able, lack, w, own, e, brakes):
    # By how much the acceleration along the way is too great for one joint: below zero where it can't brake.
    inertia = max(abs(w), 0.3 * own * abs(e))
    much = 0.5 * abs(lack) / max(inertia, LEAST_INERTIA)
    much = select(abs(lack) > 0.05 * able.torque, much, 0.0)
    return select(lack * e > 0.0, much, select(brakes, -much, 0.0))


@law
def _acceleration_of(reference):
    return reference.acceleration


@law
def _one_back(reference, e, much, T):
    return taken_back(reference, much * e, T)


@composition
def slowed(settings, plan, ahead, goals, lacks, T):
    """References of a plan, slowed along the way where open valves give less torque than it takes (`lacks`, N m)."""
    way, pace = plan.way, plan.pace
    going = dot(way, each(_gain, plan.references, goals))
    brakes = dot(way, each(_acceleration_of, plan.references)) < 0.0
    own, w = diagonal(ahead.mass, way), times(ahead.mass, way)
    shorts = each(_short, settings.abilities, lacks, w, own, way, brakes)
    much = select(greatest(shorts) > 0.0, greatest(shorts), least(shorts))
    much = min(max(much, -pace.jerk * T), pace.jerk * T)
    # It may wait, but does not turn back.
    much = select(plan.landed > 0.5, 0.0, min(much, max(going, 0.0) / T))
    return each(_one_back, plan.references, way, much, T)
