"""Rates of an arm: of its oscillation on its air, and of the decay of its velocities, which limit the time step.

A joint between its hoses is a mass between air springs.

| symbol | meaning | unit |
|---|---|---|
| k, d | stiffness of a joint's air at supply pressure, and its damping | N m/rad, N m s/rad |
| M | mass matrix, without payload | kg m2 |
| w, r | maximum natural frequency of k and M, and maximum decay rate of d and M | rad/s, 1/s |
"""

from math import sqrt
from typing import TYPE_CHECKING, Any

from layflat.lazy import numpy as np
from layflat.physics.air import GAMMA
from layflat.physics.arms import dynamics
from layflat.physics.hose import swept_volume, torque_per_pressure
from layflat.physics.joint import HoseParameters, JointParameters, Surroundings, has_second

if TYPE_CHECKING:
    from layflat.arrays import Array

CONFIGURATION_SAMPLES = 16  # number of random configurations in which mass matrices are computed


def natural_rates(arm: Any, joints: tuple[JointParameters, ...], around: Surroundings) -> tuple[float, float]:
    """Return w (rad/s) and r (1/s) of an arm without payload.

    Args:
        arm: parameters of its kind; here and in the others, arrays where runs differ: the maximum over runs counts.
        joints: parameters of the joints.
        around: supply and surroundings.
    """
    stiffness = np.array([float(np.max(_air_stiffness(joint, around))) for joint in joints])
    damping = np.array([float(np.max(_joint_damping(joint, around))) for joint in joints])
    half = np.array([float(np.min(joint.stops.squeeze_angle)) for joint in joints])
    configurations = np.random.default_rng(0).uniform(-half, half, (CONFIGURATION_SAMPLES, len(half)))
    mobilities = np.asarray(np.linalg.inv(_mass_matrices(arm, configurations)), np.float64)
    return sqrt(_max_eigenvalue(stiffness, mobilities)), _max_eigenvalue(damping, mobilities)


def _max_eigenvalue(of_joints: "Array", mobilities: "Array") -> float:
    """Return the maximum eigenvalue of M^-1 diag(of_joints) over stacked inverses of M; 0 where none is positive.

    A search may try links that can't be bodies, whose masses are negative.
    """
    roots = np.sqrt(of_joints)
    return max(0.0, float(np.linalg.eigvalsh(roots[:, None] * mobilities * roots)[..., -1].max()))


def _air_stiffness(joint: JointParameters, around: Surroundings) -> Any:
    """Return the stiffness of a joint in mid-stroke, its hoses closed at supply pressure, N m/rad."""
    return _hose_stiffness(joint.hose_a, around) + has_second(joint.second) * _hose_stiffness(joint.hose_b, around)


def _hose_stiffness(hose: HoseParameters, around: Surroundings) -> Any:
    """Return the stiffness of one closed hose's air in mid-stroke, adiabatic, in an elastic wall, N m/rad."""
    K, n_p = torque_per_pressure(hose.stroke, hose.neutral), GAMMA * around.supply_pressure
    V = hose.chamber.dead_volume + swept_volume(hose.stroke, hose.neutral)
    return K * K * n_p / (V + hose.chamber.compliance * n_p)


def _joint_damping(joint: JointParameters, around: Surroundings) -> Any:
    """Return the damping of a joint with both hoses at supply pressure, without that of its stops, N m s/rad."""
    gauge, a, b = around.supply_pressure - around.ambient_pressure, joint.hose_a.damping, joint.hose_b.damping
    return joint.viscous_friction + (a.base + b.base) + (a.slope + b.slope) * gauge


def _mass_matrices(arm: Any, configurations: "Array") -> "Array":
    """Return mass matrices (configurations, runs, joints, joints), kg m2; runs is 1 where all have the same."""
    n = configurations.shape[1]
    upper, _, _ = dynamics(arm, 0.0, tuple(configurations.T[..., None]), (0.0,) * n)
    items = np.broadcast_arrays(np.zeros((len(configurations), 1)), *upper)[1:]
    masses = np.zeros((*items[0].shape, n, n))
    for row, column, item in zip(*np.triu_indices(n), items, strict=True):
        masses[..., row, column] = masses[..., column, row] = item
    return masses
