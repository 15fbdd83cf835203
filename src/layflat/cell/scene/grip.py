"""Lift and suction cup of the scene: seal of the lip, vacuum, holding and release of fruit."""

from math import copysign, exp, pi, sqrt
from typing import Any

import numpy as np

from layflat.cell.extras import mujoco
from layflat.cell.file.model import Cell
from layflat.cell.file.parts import Cup, Lift
from layflat.cell.scene.produce import SceneFruit
from layflat.physics.air import GAS_CONSTANT, NORMAL_DENSITY, REFERENCE_TEMPERATURE

STIFFNESS = 4000.0  # of the air in the cylinder, between the piston and its reference, N/m
AMBIENT = 101325.0  # Pa
SMOOTHING_TIME = 5e-3  # time constant of forces on the lip, s: its rubber does not detach within a timestep


class LiftDrive:
    """Pneumatic cylinder with position control, within limits of speed, acceleration and force.

    Strokes count from up (0) to down, m. `air` is its consumption so far, m^3 of normal volume: a stroke in either
    direction fills the swept volume. `force` is called once a `step` (s).
    """

    def __init__(self, described: Lift, step: float) -> None:
        """Begin with the piston up and at rest, and the damping critical."""
        self._lift, self._step = described, step
        self._damping = 2.0 * sqrt(STIFFNESS * described.mass)  # critical
        density = (described.pressure + AMBIENT) / (GAS_CONSTANT * REFERENCE_TEMPERATURE)
        self._air_per_metre = described.force / described.pressure * density / NORMAL_DENSITY
        self._at, self._speed, self._demand, self.air = 0.0, 0.0, 0.0, 0.0

    @property
    def demand(self) -> float:
        """Demanded stroke, m; settable, cut to the stroke's ends."""
        return self._demand

    @demand.setter
    def demand(self, stroke: float) -> None:
        self._demand = min(max(stroke, 0.0), self._lift.stroke)

    def force(self, stroke: float, speed: float) -> float:
        """Advance a timestep; return the limited downward force on the piston, N, at a stroke (m) and speed (m/s)."""
        # The reference of a blocked piston stays within the greatest force, so that it does not jump when freed.
        max_lag = self._lift.force / STIFFNESS
        if abs(self._at - stroke) > max_lag:
            self._at, self._speed = stroke + copysign(max_lag, self._at - stroke), 0.0
        self.air += self._air_per_metre * abs(speed) * self._step
        tracking = STIFFNESS * (self._at - stroke) + self._damping * (self._speed - speed)
        last_speed = self._speed
        self._advance_reference()
        force = tracking + self._lift.mass * (self._speed - last_speed) / self._step
        return min(max(force, -self._lift.force), self._lift.force)

    def _advance_reference(self) -> None:
        """Advance the reference towards the demand, always able to stop there at the greatest deceleration."""
        h, limit = self._step, self._lift.acceleration
        distance = self._demand - self._at
        # The greatest speed from which whole timesteps of deceleration still end at the demand.
        stopping = sqrt((0.5 * limit * h) ** 2 + 2.0 * limit * abs(distance)) - 0.5 * limit * h
        demanded_speed = copysign(min(self._lift.speed, stopping, abs(distance) / h), distance)
        change = min(max(demanded_speed - self._speed, -limit * h), limit * h)
        self._speed += change
        self._at += self._speed * h


class SuctionCup:
    """Suction cup: its vacuum (below ambient, Pa) and holding force; set `on` to switch the ejector.

    The ejector draws the vacuum p towards its level while it is on; air that leaks in, more through an open cup than
    through skin, draws it to zero; a valve that is off lets air in besides:
    p' = on (level - p) / build_up - p / leak - off p / release. Each step is solved exactly. `air` is what the ejector
    has taken so far, m^3 of normal volume.
    """

    def __init__(self, described: Cup) -> None:
        self._cup = described
        self._area = pi / 4.0 * described.effective_diameter**2
        self.on, self.vacuum, self.air = False, 0.0, 0.0

    @property
    def force(self) -> float:
        """Force of the vacuum on a fruit under the cup, N."""
        return self.vacuum * self._area

    def advance(self, sealed: bool, step: float) -> None:
        """Advance the vacuum by a timestep (s), with the lip sealed on a skin or open."""
        rate = 1.0 / (self._cup.leak if sealed else self._cup.open_leak)
        if self.on:
            rate += 1.0 / self._cup.build_up
            self.air += self._cup.air_consumption * step
        else:
            rate += 1.0 / self._cup.release
        end = self._cup.vacuum / (self._cup.build_up * rate) if self.on else 0.0
        self.vacuum = end + (self.vacuum - end) * exp(-rate * step)

    def holds(self, pull: float, shear: float) -> bool:
        """Return whether the cup holds against a pull and a shear force, N; its bellows transmit no moments."""
        # The lip presses with the vacuum's force less the pull, which bounds friction.
        return self.force >= pull and shear <= self._cup.friction * (self.force - pull)


class Grip:
    """Contact between cup and fruit: seal, holding force and release."""

    def __init__(self, model: Any, data: Any, cell: Cell, fruits: list[SceneFruit]) -> None:
        """Begin with an empty cup, suction off."""
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

    def update(self) -> None:
        """Advance the vacuum after a timestep; release a fruit that the cup can't hold, or hold one.

        With suction on, it holds the only fruit that touches the lip, if its skin is within the cup's tilt.
        """
        step, touched = self._step, self._touched()
        self._measure_forces(touched, step)
        if self.held is None and self.cup.on and len(touched) == 1:
            (fruit,) = touched  # two under one lip leave it open
            if self._tilt(fruit) <= self._most_tilt:
                self._weld_fruit(fruit)
        self.cup.advance(self.held is not None, step)
        if self.held is not None and not self.cup.holds(self._pull, self._shear):
            data, tree = self._data, self._model.body_treeid
            data.eq_active[self._welds[self.held]] = 0
            # A fruit that rested in the cup would fall asleep in the air: it gets the arm's count, which never does.
            data.tree_asleep[tree[self._bodies[self.held]]] = data.tree_asleep[tree[self._body]]
            self.held = None

    def _touched(self) -> dict[int, float]:
        """Return the normal force, N, by number of the fruit that the cup's lip touches."""
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

    def _weld_fruit(self, fruit: int) -> None:
        """Weld a fruit to the cup at their present relative pose."""
        data, weld, body = self._data, self._welds[fruit], self._bodies[fruit]
        R = data.xmat[self._body].reshape(3, 3)
        back, turned = np.zeros(4), np.zeros(4)
        self._mj.mju_negQuat(back, data.xquat[self._body])
        self._mj.mju_mulQuat(turned, back, data.xquat[body])
        self._model.eq_data[weld, :11] = [0, 0, 0, *(R.T @ (data.xpos[body] - data.xpos[self._body])), *turned, 1.0]
        data.eq_active[weld] = 1
        self.held, self._pull, self._shear = fruit, 0.0, 0.0

    def _measure_forces(self, touched: dict[int, float], step: float) -> None:
        """Update the forces of the cup on fruit, N: smoothed pull and shear of the held one, greatest press of each."""
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
        weight = min(1.0, step / SMOOTHING_TIME)
        self._pull += weight * (pull - self._pull)
        self._shear += weight * (shear - self._shear)
        self.press[self.held] = max(self.press[self.held], -pull)
