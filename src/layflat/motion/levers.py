"""Levers of the tip about the joints' axes: by how much each joint moves it."""

import numpy as np

from layflat.arrays import Array
from layflat.machine import Machine
from layflat.motion.kinematics import Kinematics
from layflat.motion.path import half_strokes
from layflat.physics.arms.planar import PlanarArmPart

POSTURES = 200  # at which levers are computed
MIN_LEVER = 1e-3  # below which a joint does not move the tip, m


def tip_levers(machine: Machine) -> Array:
    """Return by how much each joint moves the tip at most, in many postures, (joints,), m/rad."""
    half = half_strokes(machine)
    postures = np.random.default_rng(0).uniform(-half, half, (POSTURES, len(half)))
    _, jacobians = Kinematics(machine).tip_and_jacobian(postures)
    levers: Array = np.linalg.norm(jacobians, axis=1).max(axis=0)
    return levers


def joints_beside_tip(machine: Machine) -> list[str]:
    """Return the names of the joints that do not move the tip, as their axes always pass through it."""
    if isinstance(machine.arm, PlanarArmPart):  # its links have lengths, and no kernel need be compiled to say so
        return []
    return [name for name, lever in zip(machine.joints, tip_levers(machine), strict=True) if lever < MIN_LEVER]
