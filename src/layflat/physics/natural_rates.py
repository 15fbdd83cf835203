"""Rates of an arm: of its oscillation on its air, and of the decay of its velocities; steps are short beside both.

A joint between its hoses is a mass between springs of air.

| symbol | meaning | unit |
|---|---|---|
| k, d | stiffness of a joint's air at supply pressure, and its damping | N m/rad, N m s/rad |
| M | mass matrix, without payload | kg m2 |
| w, r | greatest frequency of k and M, and greatest rate of d and M | rad/s, 1/s |
"""

from math import sqrt
from typing import Any

import numpy as np

from layflat.arrays import Array
from layflat.physics.air import GAMMA
from layflat.physics.arms import dynamics
from layflat.physics.hose import swept_volume, torque_per_pressure
from layflat.physics.joint import Hose, Joint, Surroundings, has_second

POSTURES = 16  # in which masses are looked at


def natural_rates(arm: Any, joints: tuple[Joint, ...], around: Surroundings) -> tuple[float, float]:
    """Return w (rad/s) and r (1/s) of an arm without payload.

    Args:
        arm: parameters of its kind; as all of these, with arrays where runs differ: the lightest counts.
        joints: parameters, an item a joint.
        around: supply and surroundings.
    """
    stiffness = np.array([float(np.max(_air_stiffness(joint, around))) for joint in joints])
    damping = np.array([float(np.max(_damping(joint, around))) for joint in joints])
    half = np.array([float(np.min(joint.stops.squeeze_angle)) for joint in joints])
    postures = np.random.default_rng(0).uniform(-half, half, (POSTURES, len(half)))
    mobilities = np.asarray(np.linalg.inv(_masses(arm, postures)), np.float64)
    return sqrt(_greatest(stiffness, mobilities)), _greatest(damping, mobilities)


def _greatest(of_joints: Array, mobilities: Array) -> float:
    """Return the greatest eigenvalue of M^-1 diag(of_joints), of stacked inverses of M; 0 where none is positive.

    A search may ask for links that can't be bodies, whose masses are negative.
    """
    roots = np.sqrt(of_joints)
    return max(0.0, float(np.linalg.eigvalsh(roots[:, None] * mobilities * roots)[..., -1].max()))


def _air_stiffness(joint: Joint, around: Surroundings) -> Any:
    """Stiffness of a joint in mid-stroke, its hoses shut and at supply pressure, N m/rad."""
    return _hose_stiffness(joint.hose_a, around) + has_second(joint.second) * _hose_stiffness(joint.hose_b, around)


def _hose_stiffness(hose: Hose, around: Surroundings) -> Any:
    K, n_p = torque_per_pressure(hose.stroke, hose.neutral), GAMMA * around.supply_pressure
    V = hose.chamber.dead_volume + swept_volume(hose.stroke, hose.neutral)
    return K * K * n_p / (V + hose.chamber.compliance * n_p)


def _damping(joint: Joint, around: Surroundings) -> Any:
    gauge, a, b = around.supply_pressure - around.ambient_pressure, joint.hose_a.damping, joint.hose_b.damping
    return joint.viscous_friction + (a.base + b.base) + (a.slope + b.slope) * gauge


def _masses(arm: Any, postures: Array) -> Array:
    """Return mass matrices (postures, runs, joints, joints), kg m2; of one run where all have the same."""
    n = postures.shape[1]
    upper, _, _ = dynamics(arm, 0.0, tuple(postures.T[..., None]), (0.0,) * n)
    items = np.broadcast_arrays(np.zeros((len(postures), 1)), *upper)[1:]
    masses = np.zeros((*items[0].shape, n, n))
    for row, column, item in zip(*np.triu_indices(n), items, strict=True):
        masses[..., row, column] = masses[..., column, row] = item
    return masses
