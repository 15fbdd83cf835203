"""The rigid arm, of any kind. A new kind is one file and one line here; see docs/kinds.md."""

import numpy as np

from layflat.jit import composition, kernel, law
from layflat.kinds import Table
from layflat.lanes import each, gather, write_numbers
from layflat.physics.arms import chain, planar
from layflat.physics.arms.chain.space import Vector
from layflat.physics.arms.kind import NONE, ArmKind, ArmLaws, ArmPart

ARMS: Table[ArmKind] = Table("arm", planar.KIND, chain.KIND)

dynamics = ARMS.law("dynamics")
points = ARMS.law("points")


@composition
def tip(arm, angles):
    """Position of the tip (m), in the plane or in space (see `ArmLaws`), from a tuple of the joints' angles."""
    return points(arm, angles)[-1]


@law
def _level(point):
    x, y = point
    return Vector(x, y, 0.0 * x)


@composition
def _level_points(arm, angles):
    return each(_level, points(arm, angles))


@law
def _up(angle):
    zero = 0.0 * angle
    return Vector(zero, zero, zero + 1.0)


@composition
def _all_up(arm, angles):  # noqa: ARG001  (as of all arms)
    return each(_up, angles)


points_in_space = ARMS.law(lambda laws: points if laws.axes == 3 else _level_points)
"""As `points`, with three coordinates whatever the arm."""

turning = ARMS.law(lambda laws: laws.turning or _all_up)
"""Directions of the joints' axes, (x, y, z) of length 1, from a tuple of the joints' angles."""


@composition
def _level_tip(arm, angles):
    return _level(tip(arm, angles))


tip_in_space = ARMS.law(lambda laws: tip if laws.axes == 3 else _level_tip)
"""As `tip`, with three coordinates whatever the arm."""


@kernel
def tips_along(arm, like, q):
    """Positions of the tip, (instants, axes), m, from angles (instants, joints), rad; `like`: an item a joint."""
    tips = np.empty((len(q), len(tip(arm, like))))
    for i in range(len(q)):
        write_numbers(tips[i], tip(arm, gather(like, q[i])))
    return tips


@kernel
def joints_along(arm, like, q):
    """Positions of joints and tip, (instants, joints + 1, 3), m, and directions of axes, (instants, joints, 3).

    From angles (instants, joints), rad; `like`: an item a joint.
    """
    n = len(like)
    places, axes = np.empty((len(q), n + 1, 3)), np.empty((len(q), n, 3))
    for i in range(len(q)):
        angles = gather(like, q[i])
        write_numbers(places[i].reshape(3 * n + 3), points_in_space(arm, angles))
        write_numbers(axes[i].reshape(3 * n), turning(arm, angles))
    return places, axes


__all__ = [
    "ARMS",
    "NONE",
    "ArmKind",
    "ArmLaws",
    "ArmPart",
    "dynamics",
    "joints_along",
    "points",
    "points_in_space",
    "tip",
    "tip_in_space",
    "tips_along",
    "turning",
]
