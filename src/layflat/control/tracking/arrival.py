"""Arrival at a goal, and the residual of the model, by which the law gives up a motion.

Arrival is decided by the position of the tip and by each joint's angle. The tip alone does not suffice: a joint whose
axis passes through the tip does not move it, as the last joint of most six-joint arms, and with the elbow to either
side the tip is at the same position. So each joint must also be near its own goal: within a tight tolerance where its
error hardly moves the tip, and within a wide one where the tip's own tolerance already bounds it.

If the model is right, the mean square of the angles' innovations is their variance. If it is many times that for a
while, the model, and with it the feedback, is wrong. Then the valves are centred and the brakes stay closed until
another goal is demanded, for which the law tries again.
"""

from math import sqrt
from typing import NamedTuple

from layflat.control.tracking.reference import reference_angle
from layflat.jit import composition, law
from layflat.lanes import each, gather, select, slots
from layflat.physics.algebra import max_magnitude
from layflat.physics.arms import tip_in_space

AVERAGING_TIME = 0.3  # time constant of the mean of the squares, s
MAX_MEAN_SQUARE = 64.0  # mean square over the variance above which the model counts as wrong
MAX_SQUARE = 120.0  # square over the variance to which a single one is clipped, so that a push does not stop the arm
NEW_GOAL_ANGLE = 0.02  # distance from the goal that was given up beyond which a goal is another one, rad


class ModelResidual(NamedTuple):
    """Residual of the law's model, and the goal that was given up because of it."""

    mean: float  # of the squares of innovations over their variances
    held: float  # 1 while a goal is given up and the arm is held, else 0
    goal: tuple[float, ...]  # the goal that was given up, rad


@law
def _difference(a, b):
    return a - b


@law
def _held_goal(held, before, goal):
    return select(held > 0.5, before, goal)


@composition
def update_residual(residual, square, goals, T):
    """Return the residual after a cycle, which begins a hold above `MAX_MEAN_SQUARE`; another goal ends the hold.

    Args: residual before it; square of the cycle's greatest innovation over its variance; goals, rad, a tuple; T.
    """
    new_goal = max_magnitude(each(_difference, goals, residual.goal)) > NEW_GOAL_ANGLE
    held, mean = select(new_goal, 0.0, residual.held), select(new_goal & (residual.held > 0.5), 0.0, residual.mean)
    mean = mean + min(T / AVERAGING_TIME, 1.0) * (min(square, MAX_SQUARE) - mean)
    held = select(mean > MAX_MEAN_SQUARE, 1.0, held)
    return ModelResidual(mean, held, each(_held_goal, held, residual.goal, goals))


class Tolerance(NamedTuple):
    """Distances from its goal within which an arm has arrived."""

    tip: float  # m
    angle: float  # of a joint, rad
    blind: float  # of a joint whose error of `angle` would not take the tip out of its tolerance, rad


@law
def _distance(a, b):
    """Return the distance between two points (`Vector`), m."""
    x, y, z = a.x - b.x, a.y - b.y, a.z - b.z
    return sqrt(x * x + y * y + z * z)


@law
def _error(q, goal):
    return abs(q - goal)


@law
def _excess(error, moved, tolerance):
    """Return a joint's error over its tolerance; `moved`: distance by which this error alone moves the tip, m."""
    visible = moved * tolerance.angle > tolerance.tip * error
    return error / select(visible, tolerance.angle, tolerance.blind)


@composition
def has_arrived(arm, q, goals, tolerance):
    """Return whether an arm at angles q (rad) is within a `Tolerance` of its goals, by its tip and by every joint.

    The goals are a tuple of `Reference`, of which only the angles count.
    """
    p = each(reference_angle, goals)
    tip, angles, moved = tip_in_space(arm, p), slots(q), slots(p)
    for j in range(len(q)):
        with_error = slots(p)
        with_error[j] = angles[j]
        moved[j] = _distance(tip_in_space(arm, gather(p, with_error)), tip)
    excess = each(_excess, each(_error, q, p), gather(p, moved), tolerance)
    return (_distance(tip_in_space(arm, q), tip) < tolerance.tip) & (max_magnitude(excess) < 1.0)
