"""The rigid arm, of any kind. A new kind is one file and one line here; see docs/kinds.md."""

from layflat.jit import composition, law, portable_kernel
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


@portable_kernel()
def tip_positions(arm, like, q, tips):
    """Write positions of the tip, (instants, axes), m, at angles (instants, joints), rad, into `tips`.

    `like` is a tuple with an item a joint.
    """
    for i in range(len(q)):
        write_numbers(tips[i], tip(arm, gather(like, q[i])))


@portable_kernel()
def joint_positions_and_axes(arm, like, q, places, axes):
    """Write positions of joints and tip, and the joints' axes, at angles (instants, joints), rad.

    Args: the arm; a tuple with an item a joint; the angles; positions of joints and tip, (instants, 3 joints + 3), m,
    and axes of length 1, (instants, 3 joints), which are filled.
    """
    for i in range(len(q)):
        angles = gather(like, q[i])
        write_numbers(places[i], points_in_space(arm, angles))
        write_numbers(axes[i], joint_axes(arm, angles))


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
