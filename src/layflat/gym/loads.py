"""Unknown torques that push the joints of many arms: none at first, then one, then another."""

import numpy as np
from numpy.typing import NDArray

from layflat.arrays import Array
from layflat.machine import Machine

FRICTION_RATIOS = 1.0, 3.0  # range of a torque, in torques of the joint's brake, which friction alone would hold
FIRST_STEPS, SECOND_STEPS = (10, 50), (60, 120)  # ranges of the steps at which torques begin


class LoadSchedule:
    """Torques of each arm's episode, drawn at its start."""

    def __init__(self, machine: Machine, count: int) -> None:
        self._scale = np.array([joint.brake.torque for joint in machine.joints.values()])[:, None]
        self._torques = np.zeros((2, len(self._scale), count))
        self._begins = np.zeros((2, count), np.int64)

    def restart(self, draw: np.random.Generator, arms: NDArray[np.intp]) -> None:
        """Draw the torques of some arms."""
        shape = 2, len(self._scale), len(arms)
        sizes = draw.uniform(*FRICTION_RATIOS, shape) * np.where(draw.random(shape) < 0.5, -1.0, 1.0)
        self._torques[:, :, arms] = self._scale * sizes
        for row, steps in zip(self._begins, (FIRST_STEPS, SECOND_STEPS), strict=True):
            row[arms] = draw.integers(*steps, len(arms))

    def torques(self, steps: NDArray[np.int64]) -> Array:
        """Return the torques on the joints, (joints, arms), N m, in the steps (arms,) of the arms' episodes."""
        first, second = self._torques
        return np.where(steps >= self._begins[1], second, np.where(steps >= self._begins[0], first, 0.0))
