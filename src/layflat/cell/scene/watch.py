"""Watches the scene for judges: accelerations of fruit, collisions, and what lies where."""

from __future__ import annotations

from math import sqrt
from typing import Any

import numpy as np

from layflat.cell.extras import mujoco
from layflat.cell.file.checks import place_over
from layflat.cell.file.model import Cell
from layflat.cell.scene.grip import Grip
from layflat.cell.scene.produce import Fruit
from layflat.cell.scene.truth import Collision, FruitTruth, Truth


class Watch:
    """Follows a scene step by step."""

    def __init__(self, model: Any, data: Any, cell: Cell, fruits: list[Fruit]) -> None:
        self._mj, self._model, self._data, self._cell, self._fruits = mujoco(), model, data, cell, fruits
        starts = [int(model.joint(fruit.name).dofadr[0]) for fruit in fruits]
        self._dofs = np.array([[start, start + 1, start + 2] for start in starts], int).reshape(-1, 3)
        self._before = data.qvel[self._dofs]
        # Squares of what velocities changed by, (m/s)^2: in the last step, and the greatest.
        self._change = np.zeros(len(fruits))
        self._greatest = np.zeros(len(fruits))
        self._collisions: dict[tuple[int, int], Collision] = {}
        self._bodies = [model.body(fruit.name).id for fruit in fruits]
        arm = model.jnt_bodyid[model.joint(next(iter(cell.machine.joints))).id]
        self._arm = model.body_rootid[model.geom_bodyid] == model.body_rootid[arm]
        self._fruit = np.isin(model.geom_bodyid, self._bodies)
        self._cup = model.geom("cup").id

    def follow(self) -> None:
        """After a step."""
        velocity = self._data.qvel[self._dofs]
        change = velocity - self._before
        self._before = velocity
        self._change = np.einsum("ij,ij->i", change, change)
        np.maximum(self._greatest, self._change, out=self._greatest)
        if self._data.ncon:
            self._collide()

    def _collide(self) -> None:
        pairs = self._data.contact.geom
        ours = self._arm[pairs]
        hits = ours[:, 0] ^ ours[:, 1]
        if not hits.any():
            return
        for first, second in pairs[hits]:
            part, other = (first, second) if self._arm[first] else (second, first)
            if part == self._cup and self._fruit[other]:
                continue
            key = (int(part), int(other))
            if key not in self._collisions:
                names = (self._model.geom(geom).name for geom in key)
                self._collisions[key] = Collision(float(self._data.time), *names)

    def truth(self, grip: Grip) -> Truth:
        """All that is true now."""
        data, step = self._data, self._model.opt.timestep
        fruits = {}
        for i, (fruit, body) in enumerate(zip(self._fruits, self._bodies, strict=True)):
            held = grip.held == i
            at = data.xpos[body].copy()
            fruits[fruit.name] = FruitTruth(
                fruit.name,
                fruit.kind,
                fruit.colour,
                fruit.grade,
                fruit.diameter,
                fruit.height,
                fruit.mass,
                at,
                data.xquat[body].copy(),
                sqrt(self._change[i]) / step,
                sqrt(self._greatest[i]) / step,
                float(grip.press[i]),
                held,
                None if held else self._place(at, fruit),
            )
        tip = data.site("cup").xpos.copy()
        return Truth(float(data.time), tip, fruits, tuple(self._collisions.values()))

    def _place(self, at: np.ndarray[Any, np.dtype[np.float64]], fruit: Fruit) -> tuple[str, int] | None:
        """The place in which a fruit lies: its middle is over it, and it is not on a rim."""
        for name, pack in self._cell.pack.items():
            number = place_over(pack, float(at[0]), float(at[1]))
            low = at[2] < pack.layout.wall + fruit.diameter / 2 + pack.layout.divider / 2
            if number is not None and low:
                return name, number
        return None
