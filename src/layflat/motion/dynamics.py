"""Torques that a motion asks of an arm's joints.

| symbol | meaning | unit |
|---|---|---|
| s | how far along a path, q(s) | m or rad |
| m, c, g | torques that are needed per acceleration s'', per s'^2, and against gravity | N m per that |
| M, h | mass matrix; torques against those of the velocities, quadratic in them | kg m2, N m |

M q'' + h + g with q' = dq/ds s' and q'' = dq/ds s'' + d2q/ds2 s'^2 is m s'' + c s'^2 + g, with m = M dq/ds and
c = M d2q/ds2 + h(dq/ds). Source: bobrow1985.
"""

from typing import NamedTuple

import numpy as np

from layflat.arrays import Array
from layflat.machine import Machine, parameters
from layflat.machine.single_acting import needed_at_rest
from layflat.motion.limits import Ability
from layflat.motion.path import Path
from layflat.motion.trajectory import States
from layflat.physics.arms import dynamics


class PathTorques(NamedTuple):
    """Symbols m, c and g of the module's table, (points, joints) each, and the derivative of the angles, likewise."""

    mass: Array
    centrifugal: Array
    gravity: Array
    rate: Array


def path_torques(machine: Machine, path: Path, s: Array, payload: float) -> PathTorques:
    """Return what motions along a path ask of the joints at distances (points,), with a payload in kg."""
    q, first, second = path.at(s)
    mass, of_velocities, gravity = _rigid_body(machine, q, first, payload)
    return PathTorques(_times(mass, first), _times(mass, second) + of_velocities, gravity, first)


def rigid_torques(machine: Machine, states: States, payload: float) -> Array:
    """Return the torques that move the masses and hold them with the springs, (instants, joints), N m."""
    mass, of_velocities, gravity = _rigid_body(machine, states.angles, states.velocities, payload)
    return _times(mass, states.accelerations) + of_velocities + gravity


def hose_torques(machine: Machine, able: Ability, states: States, payload: float) -> Array:
    """Return the torques that the hoses have to give, friction and losses included, (instants, joints), N m."""
    opposing = (able.friction + able.loss) * np.sign(states.velocities) + able.damping * states.velocities
    return rigid_torques(machine, states, payload) + opposing


def room_at_rest(machine: Machine, able: Ability, postures: Array, payload: float) -> tuple[Array, Array]:
    """Return what is left to move an arm that its hoses hold, at the worst of some postures.

    Args:
        machine: with the arm.
        able: what its joints can do.
        postures: rad, (postures, joints).
        payload: kg.

    Returns:
        Torque that every joint has left either way, (joints,), N m, below zero where it can't hold itself; and the
        greatest inertias, (joints, joints), kg m2.
    """
    mass, _, held = _rigid_body(machine, postures, np.zeros(postures.shape), payload)
    opposing = able.friction + able.loss
    left = np.minimum(able.torque - opposing - held, held - able.least_torque - opposing)
    return left.min(axis=0), np.abs(mass).max(axis=0)


def least_inertias(machine: Machine, postures: Array, payload: float) -> Array:
    """Return the inertia that a torque on one joint meets while all others are free, (joints,), kg m2.

    Args:
        machine: with the arm.
        postures: rad, (postures, joints); the least of them counts.
        payload: kg.
    """
    mass, _, _ = _rigid_body(machine, postures, np.zeros(postures.shape), payload)
    each = 1.0 / np.diagonal(np.linalg.inv(mass), axis1=1, axis2=2)
    return np.asarray(each.min(axis=0), dtype=np.float64)


def _rigid_body(machine: Machine, angles: Array, velocities: Array, payload: float) -> tuple[Array, Array, Array]:
    """Return mass matrices (instants, joints, joints), torques against velocities and to stay, (instants, joints)."""
    arm, (count, n) = parameters.arm(machine), angles.shape
    if machine.kinds:  # laws from outside may not be ones for arrays
        postures = zip(angles.tolist(), velocities.tolist(), strict=True)
        rows = [dynamics(arm, payload, tuple(q), tuple(v)) for q, v in postures]
        upper, of_velocities, pulls = (np.array(column) for column in zip(*rows, strict=True))
    else:
        found = dynamics(arm, payload, tuple(angles.T), tuple(velocities.T))
        upper, of_velocities, pulls = (np.stack([np.broadcast_to(one, count) for one in of], axis=1) for of in found)
    mass = np.zeros((count, n, n))
    across, down = np.triu_indices(n)
    mass[:, across, down] = mass[:, down, across] = upper
    return mass, -of_velocities, needed_at_rest(machine, pulls, angles)


def _times(mass: Array, of: Array) -> Array:
    product: Array = np.einsum("tij,tj->ti", mass, of)
    return product
