"""Position and velocity of the tip of a machine's arm.

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
from layflat.motion.path import half_strokes
from layflat.physics.arms import joint_positions_and_axes, tip, tip_positions
from layflat.physics.arms.planar import PlanarArmPart


def tip_position(machine: Machine, q: Array) -> Array:
    """Return the tip's position (..., axes), m, in the plane or in space, at angles q (..., joints), rad, in +-pi."""
    rows = np.ascontiguousarray(q.reshape(-1, q.shape[-1]))
    arm, angles = parameters.arm(machine), (0.0,) * q.shape[-1]
    tips = np.empty((len(rows), len(tip(arm, angles))))
    tip_positions(arm, angles, rows, tips)
    return tips.reshape(*q.shape[:-1], tips.shape[-1])


class Kinematics:
    """Positions of joints and tip of an arm of any kind in space; the arm's parameters are computed once."""

    def __init__(self, machine: Machine) -> None:
        """Compute the parameters of a machine's arm."""
        self._arm, self._zero_angles = parameters.arm(machine), (0.0,) * len(machine.joints)

    def joints(self, q: Array) -> tuple[Array, Array]:
        """Return positions of joints and tip, (points, joints + 1, 3), m, and unit vectors of the joints' axes.

        The unit vectors are (points, joints, 3); angles q are (points, joints), rad.
        """
        points, n = len(q), len(self._zero_angles)
        positions, axes = np.empty((points, 3 * n + 3)), np.empty((points, 3 * n))
        joint_positions_and_axes(self._arm, self._zero_angles, np.ascontiguousarray(q), positions, axes)
        return positions.reshape(points, n + 1, 3), axes.reshape(points, n, 3)

    def tip(self, q: Array) -> Array:
        """Return the tip's position, (points, 3), m, at angles (points, joints), rad."""
        return self.joints(q)[0][:, -1]

    def tip_and_jacobian(self, q: Array) -> tuple[Array, Array]:
        """Return the tip's position, (points, 3), m, and its Jacobian, (points, 3, joints), m/rad."""
        positions, axes = self.joints(q)
        tip = positions[:, -1:]
        return tip[:, 0], np.cross(axes, tip - positions[:, :-1]).swapaxes(1, 2)

    def tip_motion(self, q: Array, first: Array, second: Array) -> tuple[Array, Array]:
        """Return the first and second derivative of the tip's position, (points, 3) each.

        Args:
            q: angles (points, joints), rad.
            first: their derivatives by time, or by the length of a path.
            second: their second derivatives.
        """
        # Angular velocities of the joints add up from the base; the links rotate about the joints' positions.
        positions, axes = self.joints(q)
        links, relative = np.diff(positions, axis=1), axes * first[..., None]
        rate = np.cumsum(relative, axis=1)
        change = np.cumsum(axes * second[..., None] + np.cross(rate, relative), axis=1)
        speed = np.cross(rate, links)
        return speed.sum(axis=1), (np.cross(change, links) + np.cross(rate, speed)).sum(axis=1)


def planar_links(machine: Machine) -> tuple[Array, Array]:
    """Return the lengths of the links (m) and the angles between them at mid-stroke (rad), (joints,) each.

    Raises:
        MachineError: the arm is not a planar one.
    """
    if not isinstance(machine.arm, PlanarArmPart):
        what, right = f"has an arm of kind {machine.arm.kind!r}", 'motions of the tip need one of kind "planar"'
        raise MachineError(what, where=machine.origin, right=right)
    lengths = np.array([joint.planar_link.length for joint in machine.joints.values()])
    return lengths, np.array([0.0, machine.arm.elbow][: len(lengths)])


def unit_vectors(angles: Array) -> tuple[Array, Array]:
    """Return unit vectors along and across directions (...,) in rad, (..., 2) each."""
    c, s = np.cos(angles), np.sin(angles)
    return np.stack([c, s], axis=-1), np.stack([-s, c], axis=-1)


def tip_motion(machine: Machine, q: Array, first: Array, second: Array) -> tuple[Array, Array]:
    """Return the first and second derivative of the tip's position, (points, axes) each, from those of the angles.

    Args:
        machine: machine with an arm of any kind.
        q: angles (points, joints), rad.
        first: their derivatives by time, or by the length of a path.
        second: their second derivatives.
    """
    if not isinstance(machine.arm, PlanarArmPart):
        moved, accelerated = Kinematics(machine).tip_motion(q, first, second)
        axes = tip_position(machine, q[:1]).shape[-1]
        return moved[:, :axes], accelerated[:, :axes]
    lengths, bends = planar_links(machine)
    along, across = unit_vectors(np.cumsum(q + bends, axis=-1))
    rate, change = (np.cumsum(derivative, axis=-1)[..., None] for derivative in (first, second))
    arms = lengths[:, None]
    return (arms * rate * across).sum(axis=-2), (arms * (change * across - rate**2 * along)).sum(axis=-2)


LEVER_SAMPLES = 200  # random configurations at which lever arms are computed
MIN_LEVER = 1e-3  # lever arm below which a joint does not move the tip, m


def tip_levers(machine: Machine) -> Array:
    """Return each joint's greatest lever arm to the tip over random configurations in the strokes, (joints,), m/rad."""
    half = half_strokes(machine)
    configurations = np.random.default_rng(0).uniform(-half, half, (LEVER_SAMPLES, len(half)))
    _, jacobians = Kinematics(machine).tip_and_jacobian(configurations)
    levers: Array = np.linalg.norm(jacobians, axis=1).max(axis=0)
    return levers


def joints_not_moving_tip(machine: Machine) -> list[str]:
    """Return the names of the joints whose axes pass the tip within `MIN_LEVER`; none of a planar arm."""
    if isinstance(machine.arm, PlanarArmPart):  # its links have lengths, and no kernel need be compiled to say so
        return []
    return [name for name, lever in zip(machine.joints, tip_levers(machine), strict=True) if lever < MIN_LEVER]
