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


class Kinematics:
    """Where the joints and the tip of an arm of any kind are in space; the arm's parameters are found once."""

    def __init__(self, machine: Machine) -> None:
        """Take the arm of a machine."""
        self._arm, self._like = parameters.arm(machine), (0.0,) * len(machine.joints)

    def joints(self, q: Array) -> tuple[Array, Array]:
        """Return where joints and tip are, (points, joints + 1, 3) in m, and the directions of the joints' axes.

        These are (points, joints, 3); angles are (points, joints), rad.
        """
        found: tuple[Array, Array] = joints_along(self._arm, self._like, np.ascontiguousarray(q))
        return found

    def tip(self, q: Array) -> Array:
        """Return where the tip is, (points, 3), m, at angles (points, joints), rad."""
        return self.joints(q)[0][:, -1]

    def tip_and_jacobian(self, q: Array) -> tuple[Array, Array]:
        """Return where the tip is, (points, 3), m, and by how much it moves with each joint, (points, 3, joints)."""
        places, axes = self.joints(q)
        tip = places[:, -1:]
        return tip[:, 0], np.cross(axes, tip - places[:, :-1]).swapaxes(1, 2)

    def tip_motion(self, q: Array, first: Array, second: Array) -> tuple[Array, Array]:
        """Return the first and second derivative of the tip's position, (points, 3) each, from those of the angles."""
        # Each joint's own turn is carried along by those before it, and links are accelerated as by any rotation.
        places, axes = self.joints(q)
        links, own = np.diff(places, axis=1), axes * first[..., None]
        rate = np.cumsum(own, axis=1)
        change = np.cumsum(axes * second[..., None] + np.cross(rate, own), axis=1)
        speed = np.cross(rate, links)
        return speed.sum(axis=1), (np.cross(change, links) + np.cross(rate, speed)).sum(axis=1)


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
        moved, accelerated = Kinematics(machine).tip_motion(q, first, second)
        axes = tip_position(machine, q[:1]).shape[-1]
        return moved[:, :axes], accelerated[:, :axes]
    lengths, bends = links(machine)
    along, across = directions(np.cumsum(q + bends, axis=-1))
    rate, change = (np.cumsum(of, axis=-1)[..., None] for of in (first, second))
    arms = lengths[:, None]
    return (arms * rate * across).sum(axis=-2), (arms * (change * across - rate**2 * along)).sum(axis=-2)
