"""A hand that moves the arm of a scene about, in place of pneumatic joints."""

from __future__ import annotations

from typing import Any

import mujoco as _mujoco
import numpy as np
from numpy.typing import NDArray

from layflat.cell.scene import FruitTruth, Scene

mujoco: Any = _mujoco
Array = NDArray[np.float64]
INERTIA = np.array([3.0, 0.6])


class Hand:
    """Leads both joints by springs, smoothly."""

    def __init__(self, scene: Scene) -> None:
        self.scene = scene
        joints = [scene.model.joint(name) for name in scene.cell.machine.joints]
        self._places = [int(joint.qposadr[0]) for joint in joints]
        self._dofs = [int(joint.dofadr[0]) for joint in joints]
        self._wanted = scene.data.qpos[self._places].copy()

    def advance(self, data: Any) -> None:
        error = self._wanted - data.qpos[self._places]
        data.qfrc_applied[self._dofs] = INERTIA * (2500.0 * error - 100.0 * data.qvel[self._dofs])
        mujoco.mj_step(self.scene.model, data)

    def wait(self, steps: int) -> None:
        self.scene.step(steps, self.advance)

    def go(self, x: float, y: float, steps: int = 700) -> None:
        elbow = np.arccos((x * x + y * y) / 0.32 - 1.0)
        begin, end = self._wanted.copy(), np.array([np.arctan2(y, x) - elbow / 2, elbow - np.pi / 2])
        for i in range(steps):
            u = min(1.0, (i + 1) / (0.8 * steps))
            self._wanted = begin + u**3 * (10 - 15 * u + 6 * u * u) * (end - begin)
            self.wait(1)

    def pick(self, fruit: FruitTruth, aside: tuple[float, float] = (0.0, 0.0)) -> None:
        """Suck a fruit and lift it."""
        scene = self.scene
        self.go(float(fruit.position[0]) + aside[0], float(fruit.position[1]) + aside[1])
        scene.cup.on = True
        scene.lift.demand = scene.cell.lift.clearance - top(fruit) + 2e-3
        self.wait(450)
        scene.lift.demand = 0.0
        self.wait(450)


def top(fruit: FruitTruth) -> float:
    """Height of a fruit's top, m, for one that stands upright."""
    return float(fruit.position[2]) + (0.36 if fruit.kind == "mushroom" else 0.5) * fruit.height
