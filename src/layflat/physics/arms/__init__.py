"""The rigid arm, of any kind. A new kind is one file and one line here; see docs/kinds.md."""

import numpy as np

from layflat.jit import composition, kernel, law
from layflat.kinds import KindTable
from layflat.lanes import each, gather, write_numbers
from layflat.physics.arms import chain, planar
from layflat.physics.arms.chain.space import Vector
from layflat.physics.arms.kind import NO_TORQUE, ArmKind, ArmLaws, ArmPart

ARM_KINDS: KindTable[ArmKind] = KindTable("arm", planar.KIND, chain.KIND)

dynamics = ARM_KINDS.law("dynamics")
points = ARM_KINDS.law("points")


@composition
def tip(arm, angles):
    """Return the position of the tip (m), in the plane or in space (see `ArmLaws`), at joint angles (rad), a tuple."""
    return points(arm, angles)[-1]


@law
def _to_space(point):
    """Return a point (x, y) of a plane as a `Vector` with z = 0."""
    x, y = point
    return Vector(x, y, 0.0 * x)


@composition
def _planar_points_in_space(arm, angles):
    return each(_to_space, points(arm, angles))


@law
def _vertical_axis(angle):
    """Return the unit vector along z, in the lanes of an angle."""
    zero = 0.0 * angle
    return Vector(zero, zero, zero + 1.0)


@composition
def _vertical_axes(arm, angles):  # noqa: ARG001  (signature of all arms)
    return each(_vertical_axis, angles)


points_in_space = ARM_KINDS.law(lambda laws: points if laws.axes == 3 else _planar_points_in_space)
"""Positions of joints and tip, as `points`, with three coordinates whatever the arm."""

joint_axes = ARM_KINDS.law(lambda laws: laws.axis_directions or _vertical_axes)
"""Unit vectors (x, y, z) of the joints' axes at joint angles (rad), a tuple."""


@composition
def _planar_tip_in_space(arm, angles):
    return _to_space(tip(arm, angles))


tip_in_space = ARM_KINDS.law(lambda laws: tip if laws.axes == 3 else _planar_tip_in_space)
"""Position of the tip, as `tip`, with three coordinates whatever the arm."""


@kernel
def tip_positions(arm, like, q):
    """Return positions of the tip, (instants, axes), m, at angles (instants, joints), rad.

    `like` is a tuple with an item a joint.
    """
    tips = np.empty((len(q), len(tip(arm, like))))
    for i in range(len(q)):
        write_numbers(tips[i], tip(arm, gather(like, q[i])))
    return tips


@kernel
def joint_positions_and_axes(arm, like, q):
    """Return positions of joints and tip, (instants, joints + 1, 3), m, and axes, (instants, joints, 3), of length 1.

    They are those at angles (instants, joints), rad; `like` is a tuple with an item a joint.
    """
    n = len(like)
    places, axes = np.empty((len(q), n + 1, 3)), np.empty((len(q), n, 3))
    for i in range(len(q)):
        angles = gather(like, q[i])
        write_numbers(places[i].reshape(3 * n + 3), points_in_space(arm, angles))
        write_numbers(axes[i].reshape(3 * n), joint_axes(arm, angles))
    return places, axes


__all__ = [
    "ARM_KINDS",
    "NO_TORQUE",
    "ArmKind",
    "ArmLaws",
    "ArmPart",
    "dynamics",
    "joint_axes",
    "joint_positions_and_axes",
    "points",
    "points_in_space",
    "tip",
    "tip_in_space",
    "tip_positions",
]
