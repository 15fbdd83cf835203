"""Masses of the arm, and what surrounds it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from layflat.machine.model import Machine
from layflat.physics.arms import ARMS, dynamics
from layflat.physics.joint import Surroundings

Array = NDArray[np.float64]


def arm(machine: Machine) -> Any:
    """Masses of the arm, without payload: parameters of its kind."""
    return ARMS.parameters(machine.arm, list(machine.joints.values()))


def mass_and_pull(arm: Any, payload: float, angles: Sequence[float]) -> tuple[Array, Array]:
    """Mass matrix (joints, joints), kg m2, and torques that come of the angles (joints,), N m, of an arm at rest.

    Args:
        arm: parameters of a kind of arm.
        payload: kg.
        angles: rad, (joints,).
    """
    n = len(angles)
    upper, _, pulls = dynamics(arm, payload, tuple(map(float, angles)), (0.0,) * n)
    mass = np.zeros((n, n))
    mass[np.triu_indices(n)] = upper
    return mass + np.triu(mass, 1).T, np.array(pulls)


def surroundings(machine: Machine) -> Surroundings:
    """Air outside and at the supply, and the payload."""
    air = machine.supply
    return Surroundings(
        air.pressure, air.temperature, air.ambient_pressure, air.ambient_temperature, machine.arm.payload
    )
