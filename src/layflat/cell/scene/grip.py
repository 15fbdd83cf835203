"""Cup and fruit in the scene: when the lip seals, when the vacuum holds, when a fruit is released."""

from typing import Any

import numpy as np

from layflat.cell.extras import mujoco
from layflat.cell.file.model import Cell
from layflat.cell.scene.produce import SceneFruit
from layflat.cell.scene.tool import SuctionCup

SMOOTHED = 5e-3  # time over which forces on the lip are averaged, s: its rubber does not tear off within a step


class Grip:
    """What the cup does to fruit."""

    def __init__(self, model: Any, data: Any, cell: Cell, fruits: list[SceneFruit]) -> None:
        self._mj, self._model, self._data, self._most_tilt = mujoco(), model, data, cell.cup.tilt
        self.cup = SuctionCup(cell.cup)
        self.held: int | None = None  # number of the fruit that it holds
        self.press = np.zeros(len(fruits))  # greatest force with which the cup pressed each fruit so far, N
        self._geom, self._body = model.geom("cup").id, model.body("cup").id
        self._bodies = [model.body(fruit.name).id for fruit in fruits]
        self._welds = [model.equality(f"hold.{fruit.name}").id for fruit in fruits]
        numbers = {body: i for i, body in enumerate(self._bodies)}
        self._of = {geom: numbers[body] for geom, body in enumerate(model.geom_bodyid.tolist()) if body in numbers}
        self._skins = [model.geom(fruit.name).id for fruit in fruits]
        self._pull = self._shear = 0.0
        self._step: float = model.opt.timestep

    def follow(self) -> None:
        """Advance vacuum and seal after a step, and drop a fruit that no longer holds."""
        step, touched = self._step, self._touched()
        self._net(touched, step)
        if self.held is None and self.cup.on and len(touched) == 1:
            (fruit,) = touched  # two under one lip leave it open
            if self._tilt(fruit) <= self._most_tilt:
                self._hold(fruit)
        self.cup.advance(self.held is not None, step)
        if self.held is not None and not self.cup.holds(self._pull, self._shear):
            data, tree = self._data, self._model.body_treeid
            data.eq_active[self._welds[self.held]] = 0
            # A fruit that rested in the cup would fall asleep in the air: it gets the arm's count, which never does.
            data.tree_asleep[tree[self._bodies[self.held]]] = data.tree_asleep[tree[self._body]]
            self.held = None

    def _touched(self) -> dict[int, float]:
        """Return fruit that the cup's lip touches, and how hard, N."""
        touched: dict[int, float] = {}
        if not self._data.ncon:
            return touched
        contact, force = self._data.contact, np.zeros(6)
        for i in np.flatnonzero((contact.geom == self._geom).any(axis=1)):
            first, second = contact.geom[i]
            fruit = self._of.get(int(second if first == self._geom else first))
            if fruit is not None and contact.dist[i] <= 0.0:
                self._mj.mj_contactForce(self._model, self._data, int(i), force)
                touched[fruit] = touched.get(fruit, 0.0) + float(force[0])
        return touched

    def _tilt(self, fruit: int) -> float:
        """Return the angle between the cup's axis and the normal of the skin under it, rad; infinite beside the fruit.

        The skin is the ellipsoid x^2/a^2 + y^2/b^2 + z^2/c^2 = 1 in the fruit's frame.
        """
        data, skin = self._data, self._skins[fruit]
        R, size = data.geom_xmat[skin].reshape(3, 3), self._model.geom_size[skin]
        along = R.T @ data.xmat[self._body].reshape(3, 3)[:, 2]
        start = R.T @ (data.xpos[self._body] - data.geom_xpos[skin])
        p, d = start / size, along / size
        a, b, c = d @ d, p @ d, p @ p - 1.0
        inside = b * b - a * c
        if inside < 0.0:
            return float("inf")
        point = start + (-b + np.sqrt(inside)) / a * along
        normal = point / size**2
        return float(np.arccos(np.clip(normal @ along / np.linalg.norm(normal), -1.0, 1.0)))

    def _hold(self, fruit: int) -> None:
        data, weld, body = self._data, self._welds[fruit], self._bodies[fruit]
        R = data.xmat[self._body].reshape(3, 3)
        back, turned = np.zeros(4), np.zeros(4)
        self._mj.mju_negQuat(back, data.xquat[self._body])
        self._mj.mju_mulQuat(turned, back, data.xquat[body])
        self._model.eq_data[weld, :11] = [0, 0, 0, *(R.T @ (data.xpos[body] - data.xpos[self._body])), *turned, 1.0]
        data.eq_active[weld] = 1
        self.held, self._pull, self._shear = fruit, 0.0, 0.0

    def _net(self, touched: dict[int, float], step: float) -> None:
        """Book what lip and vacuum together do to fruit: smoothed pull and shear on what is held, N, and the press."""
        for fruit, push in touched.items():
            if fruit != self.held:
                self.press[fruit] = max(self.press[fruit], push)
        if self.held is None:
            return
        data = self._data
        rows = (data.efc_type == self._mj.mjtConstraint.mjCNSTR_EQUALITY) & (data.efc_id == self._welds[self.held])
        force = data.efc_force[rows][:3]  # on the cup; the rest are moments
        if len(force) < 3:
            return
        axis = data.xmat[self._body].reshape(3, 3)[:, 2]
        along = float(force @ axis)
        pull = -along - touched.get(self.held, 0.0)
        shear = float(np.linalg.norm(force - along * axis))
        share = min(1.0, step / SMOOTHED)
        self._pull += share * (pull - self._pull)
        self._shear += share * (shear - self._shear)
        self.press[self.held] = max(self.press[self.held], -pull)
