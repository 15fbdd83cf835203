"""Plan of the next cycle: the reference of the joints on their path to the goal, and whether it has landed there.

| symbol | meaning | unit |
|---|---|---|
| e | unit vector of the path from the reference to the goal, in joint space | 1 |
| T | control cycle | s |
"""

from math import sqrt
from typing import Any, NamedTuple

from layflat.control.tracking.arrival import has_arrived
from layflat.control.tracking.limits import (
    MIN_INERTIA,
    MIN_TORQUE_SHARE,
    joint_path_limits,
    limit_by_length,
    path_limits,
)
from layflat.control.tracking.model import loss_torque
from layflat.control.tracking.reference import (
    PathLimits,
    Reference,
    advance_reference,
    limit_before_goal,
    path_acceleration,
    reduce_acceleration,
    reference_velocity,
)
from layflat.jit import composition, law
from layflat.lanes import each, select
from layflat.physics.algebra import diagonal, dot, max_item, max_magnitude, min_item, multiply_symmetric

MIN_PATH_LENGTH = 1e-4  # of a path that is planned, rad
RESTING_GOAL_SPEED = 1e-3  # speed of a goal below which it is at rest, rad/s
STOPPED_SPEED = 0.05  # speed of joints below which they may land, rad/s
MIN_INERTIA_SHARE = 0.3  # min inertia of a joint along the path, over its own inertia
GOVERNOR_SHARE = 0.5  # share of a missing torque by which the reference is slowed in a cycle
GOVERNOR_DEADBAND = 0.05  # missing torque that is ignored, over the joint's torque


class CaptureLimits(NamedTuple):
    """Distance and relative speed from its goal within which a reference lands on it."""

    angle: float  # rad
    velocity: float  # rad/s


RESTING_CAPTURE = CaptureLimits(1e-3, 0.05)  # of a goal at rest
MOVING_CAPTURE = CaptureLimits(2e-3, 0.2)  # of a moving goal
LANDED_CAPTURE = CaptureLimits(4e-3, 0.4)  # of a reference that has landed, to stay landed


class FreeResponse(NamedTuple):
    """Predicted response of the arm a cycle later with centred valves; tuples with an item per joint."""

    states: tuple[Any, ...]
    angles: tuple[float, ...]  # rad
    velocities: tuple[float, ...]  # rad/s
    mass: tuple[float, ...]  # upper triangle of the mass matrix, kg m2
    steady: tuple[float, ...]  # torque that keeps the velocity, without friction and losses, N m
    holds: tuple[float, ...]  # torque that holds the joint at rest at these angles, N m


class PathState(NamedTuple):
    """State of the path between cycles."""

    references: tuple[Reference, ...]
    length: float  # of the path at its beginning, rad
    landed: float  # 1 if the references are the goals, else 0


class CyclePlan(NamedTuple):
    """Plan of the next cycle."""

    references: tuple[Reference, ...]
    length: float  # of the path at its beginning, rad
    remaining_path: float  # remaining path, rad
    landed: float  # 1 if the references are the goals, else 0
    rests: float  # 1 if the goal is at rest, else 0
    resting: float  # 1 if it has landed on a goal at rest, and the arm is within its tolerance, else 0
    direction: tuple[float, ...]  # e
    limits: PathLimits


@law
def delayed_goal(angle, velocity, acceleration, late):
    """Return a demand (rad, rad/s, rad/s2) as a reference, extrapolated by `late` seconds."""
    return Reference(
        angle + late * (velocity + 0.5 * late * acceleration), velocity + late * acceleration, acceleration
    )


@law
def _angle_to_goal(reference, goal):
    return goal.angle - reference.angle


@law
def _relative_velocity(reference, goal):
    return reference.velocity - goal.velocity


@law
def _divide(x, size):
    return x / size


@law
def _goal_motion(goal):
    return abs(goal.velocity) + abs(goal.acceleration)


@composition
def is_resting(goals):
    """Return whether all goals are at rest: |velocity| + |acceleration| below `RESTING_GOAL_SPEED`."""
    return max_magnitude(each(_goal_motion, goals)) < RESTING_GOAL_SPEED


@composition
def is_to_stay(path, goals):
    """Return whether an arm that has landed is to stay: its goal is at rest and near its references."""
    apart = each(_angle_to_goal, path.references, goals)
    return (path.landed > 0.5) & is_resting(goals) & (sqrt(dot(apart, apart)) < LANDED_CAPTURE.angle)


@law
def _torque_ratio(actuator, friction, joint, state, speed, inertial, steady, load):
    """Return the torque that a joint can exert over that of its planned acceleration, 1 or more if it suffices."""
    losses = friction + abs(loss_torque(joint, state))
    torque = inertial + steady - load - actuator.middle
    return (actuator.torque + select(torque * speed > 0.0, -losses, losses)) / max(abs(torque), 1e-3)


@law
def _next_reference(reference, goal, a, share, landed, T):
    """Return the reference a cycle later, with acceleration `share` times a; once landed, it moves as its goal."""
    free, with_goal = advance_reference(reference, share * a, T), advance_reference(goal, goal.acceleration, T)
    return Reference(
        select(landed, with_goal.angle, free.angle),
        select(landed, with_goal.velocity, free.velocity),
        select(landed, with_goal.acceleration, free.acceleration),
    )


@composition
def plan_cycle(settings, path, estimate, heaviest, response, goals, tolerance, T):
    """Return the `CyclePlan` of the next cycle towards goals.

    Args: `Settings` of the law; `PathState`; `LoadEstimate`; upper bound of the payload, kg; `FreeResponse`; goals, a
    tuple of `Reference`; `Tolerance` within which the arm lands; T.
    """
    plant, margins, references = settings.plant, settings.margins, path.references
    apart = each(_angle_to_goal, references, goals)
    distance = sqrt(dot(apart, apart))
    direction = each(_divide, apart, max(distance, 1e-9))
    length = max(select(path.landed > 0.5, 0.0, path.length), distance)
    speeds, relative = each(reference_velocity, references), each(_relative_velocity, references, goals)
    full = path_limits(
        margins, settings.actuators, estimate.frictions, heaviest, plant, response.angles, goals, direction,
        dot(direction, speeds),
    )  # fmt: skip
    limits = limit_by_length(full, max(length, MIN_PATH_LENGTH), margins.min_duration)
    a = path_acceleration(references, goals, direction, limits, T)
    inertias = diagonal(response.mass, direction)
    alone = each(joint_path_limits, settings.actuators, estimate.frictions, inertias, response.holds, relative, margins)
    velocity = dot(direction, relative)
    a = each(limit_before_goal, a, references, goals, direction, velocity, limits, alone, T)
    inertial = multiply_symmetric(response.mass, a)
    shares = each(
        _torque_ratio, settings.actuators, estimate.frictions, plant.joints, response.states, speeds, inertial,
        response.steady, estimate.loads,
    )  # fmt: skip
    share = select(settings.parts.governor > 0.5, max(min(min_item(shares), 1.0), MIN_TORQUE_SHARE), 1.0)
    rests = is_resting(goals)
    inside = has_arrived(plant.arm, response.angles, goals, tolerance)
    landed = _is_captured(path.landed > 0.5, rests, distance, max_magnitude(relative))
    landed = landed | (rests & inside & (max_magnitude(response.velocities) < STOPPED_SPEED))
    onward = each(_next_reference, references, goals, a, share, landed, T)
    # A path begins when the motion turns towards the goal.
    turns = (velocity <= 0.0) & (dot(direction, each(_relative_velocity, onward, goals)) > 0.0)
    return CyclePlan(
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
def _is_captured(landed, rests, distance, speed):
    """Return whether a reference lands on its goal: from farther on a moving one, and once landed it stays with it."""
    near = select(landed, LANDED_CAPTURE.angle, select(rests, RESTING_CAPTURE.angle, MOVING_CAPTURE.angle))
    slow = select(landed, LANDED_CAPTURE.velocity, select(rests, RESTING_CAPTURE.velocity, MOVING_CAPTURE.velocity))
    return (distance < near) & (speed < slow)


@law
def _excess_acceleration(actuator, lack, w, inertia, e, brakes):
    """Return the excess of the acceleration along the path by one joint's lack of torque (N m), rad/s2.

    It is negative if the joint can't brake enough. A joint whose inertia along the path is balanced by the motion of
    others still has to move itself.
    """
    along = max(abs(w), MIN_INERTIA_SHARE * inertia * abs(e))
    excess = GOVERNOR_SHARE * abs(lack) / max(along, MIN_INERTIA)
    excess = select(abs(lack) > GOVERNOR_DEADBAND * actuator.torque, excess, 0.0)
    return select(lack * e > 0.0, excess, select(brakes, -excess, 0.0))


@law
def _acceleration_of(reference):
    return reference.acceleration


@law
def _reduce_along_path(reference, e, excess, T):
    return reduce_acceleration(reference, excess * e, T)


@composition
def govern_references(settings, plan, response, goals, lacks, T):
    """Return the references of a plan, slowed along the path if fully open valves yield too little torque for it.

    Args: `Settings` of the law; `CyclePlan`; `FreeResponse`; goals (`Reference`), a tuple; missing torques, N m, a
    tuple; T.
    """
    direction, limits = plan.direction, plan.limits
    velocity = dot(direction, each(_relative_velocity, plan.references, goals))
    brakes = dot(direction, each(_acceleration_of, plan.references)) < 0.0
    inertias, w = diagonal(response.mass, direction), multiply_symmetric(response.mass, direction)
    excesses = each(_excess_acceleration, settings.actuators, lacks, w, inertias, direction, brakes)
    excess = select(max_item(excesses) > 0.0, max_item(excesses), min_item(excesses))
    excess = settings.parts.governor * min(max(excess, -limits.jerk * T), limits.jerk * T)
    # The reference may stop, but does not reverse.
    excess = select(plan.landed > 0.5, 0.0, min(excess, max(velocity, 0.0) / T))
    return each(_reduce_along_path, plan.references, direction, excess, T)
