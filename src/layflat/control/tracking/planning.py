"""The reference: where the joints should be in the next cycle on their path to the goal, and when it has landed.

| symbol | meaning | unit |
|---|---|---|
| e | unit vector of the path from the reference to the goal, in joint space | 1 |
| T | control cycle | s |
"""

from math import sqrt
from typing import Any, NamedTuple

from layflat.control.tracking.arrival import has_arrived
from layflat.control.tracking.limits import LEAST_INERTIA, LEAST_SHARE, for_length, own_limits, path_limits
from layflat.control.tracking.model import loss_torque
from layflat.control.tracking.reference import (
    PathLimits,
    Reference,
    advanced,
    kept_before,
    path_acceleration,
    taken_back,
    velocity_of,
)
from layflat.jit import composition, law
from layflat.lanes import each, select
from layflat.physics.algebra import diagonal, dot, greatest, largest, least, times

SHORTEST = 1e-4  # path that is planned, rad
REST = 1e-3  # velocity of a goal below which it is at rest, rad/s
CALM = 0.05  # velocity of joints that have all but stopped, rad/s
OWN_SHARE = 0.3  # of its own inertia that a joint counts with at least
GIVEN_WAY = 0.5  # share of what a valve lacks that the reference gives way in a cycle
UNNOTICED = 0.05  # share of a joint's torque that may be lacking


class Nearness(NamedTuple):
    """How near its goal a reference has to be to be put on it."""

    angle: float  # rad
    velocity: float  # rad/s


LANDS, CAUGHT, KEPT = Nearness(1e-3, 0.05), Nearness(2e-3, 0.2), Nearness(4e-3, 0.4)
"""Of a goal at rest, of one that moves, and of either once it is there."""


class FreeResponse(NamedTuple):
    """Response of the arm a cycle later were its valves centred; tuples with an item a joint."""

    states: tuple[Any, ...]
    angles: tuple[float, ...]
    velocities: tuple[float, ...]
    mass: tuple[float, ...]  # upper triangle
    steady: tuple[float, ...]  # torque that keeps the velocity, friction and losses aside, N m
    holds: tuple[float, ...]  # torque that holds the joint there at rest, N m


class PathState(NamedTuple):
    """Where the arm is on its path, kept from cycle to cycle."""

    references: tuple[Reference, ...]
    length: float  # of the path when it began, rad
    landed: float  # 1 where the references are the goals', else 0


class Plan(NamedTuple):
    """The next cycle."""

    references: tuple[Reference, ...]
    length: float
    left: float  # of the path, rad
    landed: float
    rests: float  # 1 where the goal is at rest, else 0
    resting: float  # 1 where it has landed, the goal is at rest and the arm there, else 0
    direction: tuple[float, ...]
    limits: PathLimits


@law
def goal_of(angle, velocity, acceleration, late):
    """Return a demand as a reference, so many seconds later."""
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
def is_resting(goals):
    """Return whether goals are at rest."""
    return largest(each(_restless, goals)) < REST


@composition
def stays(path, goals):
    """Return whether an arm that has landed is to stay where it is."""
    apart = each(_apart, path.references, goals)
    return (path.landed > 0.5) & is_resting(goals) & (sqrt(dot(apart, apart)) < KEPT.angle)


@law
def _feasible(actuator, friction, joint, state, speed, inertial, steady, load):
    # Share of a torque that a joint can give.
    rubs = friction + abs(loss_torque(joint, state))
    force = inertial + steady - load - actuator.middle
    return (actuator.torque + select(force * speed > 0.0, -rubs, rubs)) / max(abs(force), 1e-3)


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
def plan_of(settings, path, estimate, heaviest, response, goals, tolerance, T):
    """Return the `Plan` of the next cycle towards goals (`Reference`); the arm lands within a `Tolerance` of them."""
    plant, margins, references = settings.plant, settings.margins, path.references
    apart = each(_apart, references, goals)
    distance = sqrt(dot(apart, apart))
    direction = each(_per, apart, max(distance, 1e-9))
    length = max(select(path.landed > 0.5, 0.0, path.length), distance)
    speeds, gains = each(velocity_of, references), each(_gain, references, goals)
    full = path_limits(
        margins, settings.actuators, estimate.frictions, heaviest, plant, response.angles, goals, direction,
        dot(direction, speeds),
    )  # fmt: skip
    limits = for_length(full, max(length, SHORTEST), margins.quickest)
    a = path_acceleration(references, goals, direction, limits, T)
    inertias = diagonal(response.mass, direction)
    alone = each(own_limits, settings.actuators, estimate.frictions, inertias, response.holds, gains, margins)
    going = dot(direction, gains)
    a = each(kept_before, a, references, goals, direction, going, limits, alone, T)
    inertial = times(response.mass, a)
    shares = each(
        _feasible, settings.actuators, estimate.frictions, plant.joints, response.states, speeds, inertial,
        response.steady, estimate.loads,
    )  # fmt: skip
    share = select(settings.parts.governor > 0.5, max(min(least(shares), 1.0), LEAST_SHARE), 1.0)
    rests = is_resting(goals)
    inside = has_arrived(plant.arm, response.angles, goals, tolerance)
    landed = _lands(path.landed > 0.5, rests, distance, largest(gains))
    landed = landed | (rests & inside & (largest(response.velocities) < CALM))
    onward = each(_onward, references, goals, a, share, landed, T)
    # A path begins where the arm turns to the goal.
    turns = (going <= 0.0) & (dot(direction, each(_gain, onward, goals)) > 0.0)
    return Plan(
        onward,
        select(turns, distance, length),
        distance,
        select(landed, 1.0, 0.0) + 0.0 * distance,
        select(rests, 1.0, 0.0) + 0.0 * distance,
        select(landed & rests & inside, 1.0, 0.0) + 0.0 * distance,
        direction,
        limits,
    )


@law
def _lands(landed, rests, distance, speed):
    # Whether a reference is put on its goal: a moving one is caught from further off, and one that was is kept.
    near = select(landed, KEPT.angle, select(rests, LANDS.angle, CAUGHT.angle))
    slow = select(landed, KEPT.velocity, select(rests, LANDS.velocity, CAUGHT.velocity))
    return (distance < near) & (speed < slow)


@law
def _short(actuator, lack, w, own, e, brakes):
    # By how much the acceleration along the path is too great for one joint: below zero where it can't brake.
    # A joint whose own inertia the others' motion balances still moves it.
    inertia = max(abs(w), OWN_SHARE * own * abs(e))
    much = GIVEN_WAY * abs(lack) / max(inertia, LEAST_INERTIA)
    much = select(abs(lack) > UNNOTICED * actuator.torque, much, 0.0)
    return select(lack * e > 0.0, much, select(brakes, -much, 0.0))


@law
def _acceleration_of(reference):
    return reference.acceleration


@law
def _one_back(reference, e, much, T):
    return taken_back(reference, much * e, T)


@composition
def governed(settings, plan, response, goals, lacks, T):
    """Return the references of a plan, slowed along the path where open valves give less torque than it takes.

    `lacks`: what they give less, N m, a tuple.
    """
    direction, limits = plan.direction, plan.limits
    going = dot(direction, each(_gain, plan.references, goals))
    brakes = dot(direction, each(_acceleration_of, plan.references)) < 0.0
    own, w = diagonal(response.mass, direction), times(response.mass, direction)
    shorts = each(_short, settings.actuators, lacks, w, own, direction, brakes)
    much = select(greatest(shorts) > 0.0, greatest(shorts), least(shorts))
    much = settings.parts.governor * min(max(much, -limits.jerk * T), limits.jerk * T)
    # It may wait, but does not turn back.
    much = select(plan.landed > 0.5, 0.0, min(much, max(going, 0.0) / T))
    return each(_one_back, plan.references, direction, much, T)
