"""Arrival at a goal, and the law's doubt of its model, in which it stops on the way.

Arrival goes by the place of the tip, and by the joints that it does not tell of. A joint whose axis passes through the
tip leaves it where it is, as the last one of most arms of six joints does, and with the elbow to either side the tip is
at the same place. So each joint has to be near its own goal too: exactly where it moves the tip by little, and roughly
where the tip's own tolerance tells of it.

Where the model is right, squares of the angles' innovations are their variances in the mean. Where they are many times
that for a while, all that follows from the model is wrong, feedback included. Then the valves are centred and the
brakes stay closed, until another goal is asked for, which is tried anew.
"""

from math import sqrt
from typing import NamedTuple

from layflat.control.tracking.reference import angle_of
from layflat.jit import composition, law
from layflat.lanes import each, gather, select, slots
from layflat.physics.algebra import largest
from layflat.physics.arms import tip_in_space

MEMORY = 0.3  # time over which squares are averaged, s
MOST = 64.0  # mean square over the variance from which the model is not gone by
CAP = 120.0  # of a single square: a push is no doubt
ELSEWHERE = 0.02  # from where a goal was given up that another one is, rad


class Doubt(NamedTuple):
    """Memory of it."""

    mean: float  # of the squares
    held: float  # 1 where the goal was given up, else 0
    goal: tuple[float, ...]  # that was given up, rad


@law
def _apart(a, b):
    return a - b


@law
def _kept(held, before, goal):
    return select(held > 0.5, before, goal)


@composition
def doubted(doubt, square, goals, T):
    """Return the doubt after a cycle with such a square over its variance; goals: angles, rad."""
    tried = largest(each(_apart, goals, doubt.goal)) > ELSEWHERE
    held, mean = select(tried, 0.0, doubt.held), select(tried & (doubt.held > 0.5), 0.0, doubt.mean)
    mean = mean + min(T / MEMORY, 1.0) * (min(square, CAP) - mean)
    held = select(mean > MOST, 1.0, held)
    return Doubt(mean, held, each(_kept, held, doubt.goal, goals))


class Tolerance(NamedTuple):
    """Distances from its goal within which an arm has arrived."""

    tip: float  # m
    angle: float  # of a joint, rad
    blind: float  # the same where so much does not take the tip out of its own, rad


@law
def _distance(a, b):
    x, y, z = a.x - b.x, a.y - b.y, a.z - b.z
    return sqrt(x * x + y * y + z * z)


@law
def _error(q, goal):
    return abs(q - goal)


@law
def _excess(error, moved, tolerance):
    # Over the tolerance; `moved`: by how much this error alone moves the tip, m.
    visible = moved * tolerance.angle > tolerance.tip * error
    return error / select(visible, tolerance.angle, tolerance.blind)


@composition
def has_arrived(arm, q, goals, tolerance):
    """Return whether an arm at angles q (rad) is within a `Tolerance` of its goals, by its tip and by every joint."""
    p = each(angle_of, goals)
    place, at, moved = tip_in_space(arm, p), slots(q), slots(p)
    for j in range(len(q)):
        beside = slots(p)
        beside[j] = at[j]
        moved[j] = _distance(tip_in_space(arm, gather(p, beside)), place)
    excess = each(_excess, each(_error, q, p), gather(p, moved), tolerance)
    return (_distance(tip_in_space(arm, q), place) < tolerance.tip) & (largest(excess) < 1.0)
