"""Unknown torques that push the joints of many arms: none at first, then one, then another."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from layflat.gym.kernel import push_joints
from layflat.machine import Machine
from layflat.sim.loop import JointSignals

FRICTION_RATIOS = 1.0, 3.0  # range of a torque, in torques of the joint's brake, which friction alone would hold
FIRST_STEPS, SECOND_STEPS = (10, 50), (60, 120)  # ranges of the steps at which torques begin


class LoadSchedule:
    """Torques of each arm's episode, drawn at its start.

    Args:
        machine: the machine.
        steps: live numbers of the steps of the arms' episodes, (arms,).
        acting: inputs of the arms, (joints, signals, arms), to which `push` writes.
    """

    def __init__(self, machine: Machine, steps: NDArray[np.int64], acting: NDArray[np.floating[Any]]) -> None:
        self._scale = np.array([joint.brake.torque for joint in machine.joints.values()])[:, None]
        self._torques = np.zeros((2, len(self._scale), len(steps)))
        self._begins = np.zeros((2, len(steps)), np.int64)
        load = JointSignals._fields.index("load")
        self.push = push_joints.bind(self._torques, self._begins, steps, acting, load)

    def restart(self, draw: np.random.Generator, arms: NDArray[np.intp]) -> None:
        """Draw the torques of some arms."""
        shape = 2, len(self._scale), len(arms)
        sizes = draw.uniform(*FRICTION_RATIOS, shape) * np.where(draw.random(shape) < 0.5, -1.0, 1.0)
        self._torques[:, :, arms] = self._scale * sizes
        for row, steps in zip(self._begins, (FIRST_STEPS, SECOND_STEPS), strict=True):
            row[arms] = draw.integers(*steps, len(arms))
