"""Arrival at a goal: by the place of the tip, and by the joints that it does not tell of.

A joint whose axis passes through the tip leaves it where it is, as the last one of most arms of six joints does, and
with the elbow to either side the tip is at the same place. So each joint has to be near its own goal too: exactly
where it moves the tip by little, and roughly where the tip's own tolerance tells of it.
"""

from math import sqrt
from typing import NamedTuple

from layflat.control.tracking.reference import angle_of
from layflat.jit import composition, law
from layflat.lanes import each, gather, select, slots
from layflat.physics.algebra import largest
from layflat.physics.arms import tip_in_space


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
