"""Values that formats of robots, and MuJoCo, ask for: greatest torque and velocity of a joint, inertia of a body."""

import numpy as np

from layflat.arrays import Array
from layflat.machine import Machine, parameters
from layflat.physics.air_balance import REFERENCE_PRESSURE
from layflat.physics.arms.chain.description import ROUNDING


def effort(machine: Machine, name: str) -> float:
    """Return a joint's greatest torque at supply pressure, N m."""
    return float(parameters.torque_constant(machine.joints[name]) * machine.supply.pressure_gauge)


def velocity(machine: Machine, name: str) -> float:
    """Return the velocity (rad/s) at which a fully open valve just keeps a hose at supply pressure.

    It is the valve's conductance x 1 bar / (torque per pressure).
    """
    joint, (valve, *_) = machine.joints[name], parameters.drive_parts(machine)
    conductance = joint.valve_size * valve.conductance
    return float(conductance * REFERENCE_PRESSURE / parameters.torque_constant(joint))


MARGIN = 1e-12  # by which the greatest moment is less than the sum of the others, as a share: MuJoCo's own rounding


def realizable_inertia(inertia: Array) -> Array | None:
    """Return the inertia of a body nearest to one (3, 3) that rounding has put out of reach, or None if it is further.

    A thin plate's greatest moment is the sum of both others. In numbers of six digits, or of sixteen, it is as often
    more than that as less. An inertia that a body can have is returned as it is.
    """
    moments, axes = np.linalg.eigh(inertia)
    excess = moments[2] - (moments[0] + moments[1]) * (1.0 - MARGIN)
    if excess <= 0.0:
        return inertia
    if excess > ROUNDING * moments[2] or moments[0] < 0.0:
        return None
    moments[2] -= excess
    if np.count_nonzero(inertia - np.diag(inertia.diagonal())):
        nearest: Array = axes @ np.diag(moments) @ axes.T
        return 0.5 * (nearest + nearest.T)
    greatest = int(np.argmax(inertia.diagonal()))
    diagonal = inertia.diagonal().copy()
    diagonal[greatest] -= excess
    return np.diag(diagonal)


def nearest_inertia(inertia: Array) -> Array:
    """Return `realizable_inertia` of what a description may have; else, of inertias that nobody checked, the same."""
    nearest = realizable_inertia(inertia)
    return inertia if nearest is None else nearest
