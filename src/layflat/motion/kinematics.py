"""Where the tip of a machine's arm is, and how it moves.

| symbol | meaning | unit |
|---|---|---|
| q | joint angles from the middle of each stroke | rad |
| t_i | direction of link i: q_1, and q_1 + q_2 + e, with the elbow's angle e | rad |
| l_i | length of link i | m |
| u_i, n_i | unit vectors along link i and across it | 1 |

The tip is at l_1 u_1 + l_2 u_2. It moves with l_1 t_1' n_1 + l_2 t_2' n_2, and is accelerated by
l_1 (t_1'' n_1 - t_1'^2 u_1) + l_2 (t_2'' n_2 - t_2'^2 u_2); likewise with derivatives by anything else than time.
"""

import numpy as np

from layflat.arrays import Array
from layflat.errors import MachineError
from layflat.machine import Machine, parameters
from layflat.physics.arms import joints_along, tips_along
from layflat.physics.arms.planar import PlanarArmPart


def tip_position(machine: Machine, q: Array) -> Array:
    """Position of the tip, (..., axes) in m, in the plane or in space, for angles (..., joints) in rad within +-pi."""
    rows = np.ascontiguousarray(q.reshape(-1, q.shape[-1]))
    tips: Array = tips_along(parameters.arm(machine), (0.0,) * q.shape[-1], rows)
    return tips.reshape(*q.shape[:-1], tips.shape[-1])


def joints_in_space(machine: Machine, q: Array) -> tuple[Array, Array]:
    """Return where joints and tip are, (points, joints + 1, 3) in m, and the directions of the joints' axes, likewise.

    Args:
        machine: with an arm of any kind.
        q: angles (points, joints), rad.
    """
    found: tuple[Array, Array] = joints_along(parameters.arm(machine), (0.0,) * q.shape[-1], np.ascontiguousarray(q))
    return found


def jacobian(machine: Machine, q: Array) -> Array:
    """Return by how much the tip moves with each joint, (points, 3, joints) in m/rad, at angles (points, joints)."""
    places, axes = joints_in_space(machine, q)
    moved: Array = np.cross(axes, places[:, -1:] - places[:, :-1]).swapaxes(1, 2)
    return moved


def links(machine: Machine) -> tuple[Array, Array]:
    """Return the lengths of the links (m) and the angles between them at mid-stroke (rad), (joints,) each.

    Raises:
        MachineError: the arm is not a planar one.
    """
    if not isinstance(machine.arm, PlanarArmPart):
        what, right = f"has an arm of kind {machine.arm.kind!r}", 'motions of the tip need one of kind "planar"'
        raise MachineError(what, where=machine.origin, right=right)
    lengths = np.array([joint.planar_link.length for joint in machine.joints.values()])
    return lengths, np.array([0.0, machine.arm.elbow][: len(lengths)])


def directions(angles: Array) -> tuple[Array, Array]:
    """Return unit vectors along and across directions (...,) in rad, (..., 2) each."""
    c, s = np.cos(angles), np.sin(angles)
    return np.stack([c, s], axis=-1), np.stack([-s, c], axis=-1)


def tip_motion(machine: Machine, q: Array, first: Array, second: Array) -> tuple[Array, Array]:
    """Return the first and second derivative of the tip's position, (points, axes) each, from those of the angles.

    Args:
        machine: with an arm of any kind.
        q: angles (points, joints), rad.
        first: their derivatives by time, or by the length of a path.
        second: their second derivatives.
    """
    if not isinstance(machine.arm, PlanarArmPart):
        return _tip_motion_in_space(machine, q, first, second)
    lengths, bends = links(machine)
    along, across = directions(np.cumsum(q + bends, axis=-1))
    rate, change = (np.cumsum(of, axis=-1)[..., None] for of in (first, second))
    arms = lengths[:, None]
    return (arms * rate * across).sum(axis=-2), (arms * (change * across - rate**2 * along)).sum(axis=-2)


def _tip_motion_in_space(machine: Machine, q: Array, first: Array, second: Array) -> tuple[Array, Array]:
    # Each joint's own turn is carried along by those before it, and links are accelerated as by any rotation.
    places, axes = joints_in_space(machine, q)
    links, own = np.diff(places, axis=1), axes * first[..., None]
    rate = np.cumsum(own, axis=1)
    change = np.cumsum(axes * second[..., None] + np.cross(rate, own), axis=1)
    speed = np.cross(rate, links)
    moved, accelerated = speed.sum(axis=1), (np.cross(change, links) + np.cross(rate, speed)).sum(axis=1)
    count = tip_position(machine, q[:1]).shape[-1]
    return moved[:, :count], accelerated[:, :count]
