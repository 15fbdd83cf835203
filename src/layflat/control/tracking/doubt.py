"""When the model is too far from the plant to go by: the law says so, and holds the arm.

Where the model is right, squares of the angles' innovations are their variances in the mean. Where they are many times
that for a while, all that follows from the model is wrong, feedback included. Then the valves are centred and the
brakes stay closed, until another goal is asked for, which is tried anew.
"""

from typing import NamedTuple

from layflat.jit import composition, law
from layflat.lanes import each, select
from layflat.physics.algebra import largest

MEMORY = 0.3  # time over which squares are averaged, s
MOST = 64.0  # mean square over the variance from which the model is not gone by
CAP = 120.0  # of a single square: a push is no doubt
ELSEWHERE = 0.02  # from where a goal was given up that another one is, rad


class Doubt(NamedTuple):
    """What is remembered of it."""

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
