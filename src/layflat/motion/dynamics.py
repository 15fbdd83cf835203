"""Joint torques that a motion requires (inverse dynamics).

| symbol | meaning | unit |
|---|---|---|
| s | distance along a path q(s) | m or rad |
| m, c, g | required torques per acceleration s'', per s'^2, and against gravity | N m per that |
| M, h | mass matrix; torques against those of the velocities, quadratic in them | kg m2, N m |

M q'' + h + g with q' = dq/ds s' and q'' = dq/ds s'' + d2q/ds2 s'^2 is m s'' + c s'^2 + g, with m = M dq/ds and
c = M d2q/ds2 + h(dq/ds). Source: bobrow1985.
"""

from typing import NamedTuple

import numpy as np

from layflat.arrays import Array
from layflat.machine import Machine, parameters
from layflat.motion.limits import JointCapabilities, static_torques
from layflat.motion.path import JointPath
from layflat.motion.trajectory import States
from layflat.physics.arms import dynamics


class PathTorques(NamedTuple):
    """Torques m, c and g of the module's table, and the derivative of the angles by s, (points, joints) each."""

    mass: Array
    centrifugal: Array
    gravity: Array
    rate: Array


def path_torques(machine: Machine, path: JointPath, s: Array, payload: float) -> PathTorques:
    """Return the torques that motions of a rigid arm, with its springs, along a path require.

    Args:
        machine: machine whose arm moves.
        path: path of its joints.
        s: distances along the path, (points,), m or rad.
        payload: kg.
    """
    q, first, second = path.evaluate(s)
    mass, coriolis, gravity = _rigid_body_terms(machine, q, first, payload)
    return PathTorques(_multiply_rows(mass, first), _multiply_rows(mass, second) + coriolis, gravity, first)


def rigid_torques(machine: Machine, states: States, payload: float) -> Array:
    """Return the torques of the rigid arm, springs included, without friction and losses.

    Args:
        machine: machine whose arm moves.
        states: states of its joints, (instants, joints) each.
        payload: kg.

    Returns:
        Torques (instants, joints), N m.
    """
    mass, coriolis, gravity = _rigid_body_terms(machine, states.angles, states.velocities, payload)
    return _multiply_rows(mass, states.accelerations) + coriolis + gravity


def hose_torques(machine: Machine, capabilities: JointCapabilities, states: States, payload: float) -> Array:
    """Return the torques that the hoses have to exert, friction and losses included.

    Args:
        machine: machine whose arm moves.
        capabilities: capabilities of its joints.
        states: states of its joints, (instants, joints) each.
        payload: kg.

    Returns:
        Torques (instants, joints), N m.
    """
    dry_friction = (capabilities.friction + capabilities.loss) * np.sign(states.velocities)
    opposing = dry_friction + capabilities.damping * states.velocities
    return rigid_torques(machine, states, payload) + opposing


def torque_margin_at_rest(
    machine: Machine, capabilities: JointCapabilities, configurations: Array, payload: float
) -> tuple[Array, Array]:
    """Return the minimum torque, over configurations, that joints have left to accelerate an arm that they hold.

    Args:
        machine: machine with the arm.
        capabilities: capabilities of its joints.
        configurations: joint angles, (configurations, joints), rad.
        payload: kg.

    Returns:
        Margin of every joint in either direction, (joints,), N m, negative where it can't hold itself; and the
        greatest absolute entries of the mass matrix, (joints, joints), kg m2.
    """
    mass, _, static = _rigid_body_terms(machine, configurations, np.zeros(configurations.shape), payload)
    opposing = capabilities.friction + capabilities.loss
    margin = np.minimum(capabilities.torque - opposing - static, static - capabilities.min_torque - opposing)
    return margin.min(axis=0), np.abs(mass).max(axis=0)


def min_inertias(machine: Machine, configurations: Array, payload: float) -> Array:
    """Return each joint's least effective inertia over configurations, with all other joints free, (joints,), kg m2.

    Args:
        machine: machine with the arm.
        configurations: joint angles, (configurations, joints), rad.
        payload: kg.
    """
    mass, _, _ = _rigid_body_terms(machine, configurations, np.zeros(configurations.shape), payload)
    each = 1.0 / np.diagonal(np.linalg.inv(mass), axis1=1, axis2=2)
    return np.asarray(each.min(axis=0), dtype=np.float64)


def _rigid_body_terms(machine: Machine, angles: Array, velocities: Array, payload: float) -> tuple[Array, Array, Array]:
    """Return mass matrices (instants, joints, joints), Coriolis and static torques to exert, (instants, joints).

    Static torques are those against gravity and springs.
    """
    arm, (count, n) = parameters.arm(machine), angles.shape
    if machine.kinds:  # laws from outside may not accept arrays
        instants = zip(angles.tolist(), velocities.tolist(), strict=True)
        rows = [dynamics(arm, payload, tuple(q), tuple(v)) for q, v in instants]
        upper, coriolis, gravity = (np.array(column) for column in zip(*rows, strict=True))
    else:
        terms = dynamics(arm, payload, tuple(angles.T), tuple(velocities.T))
        upper, coriolis, gravity = (
            np.stack([np.broadcast_to(entry, count) for entry in entries], axis=1) for entries in terms
        )
    mass = np.zeros((count, n, n))
    across, down = np.triu_indices(n)
    mass[:, across, down] = mass[:, down, across] = upper
    return mass, -coriolis, static_torques(machine, gravity, angles)


def _multiply_rows(mass: Array, vectors: Array) -> Array:
    """Return the product of each instant's matrix and vector, (instants, joints)."""
    product: Array = np.einsum("tij,tj->ti", mass, vectors)
    return product
