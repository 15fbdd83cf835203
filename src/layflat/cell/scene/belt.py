"""Conveyor of the scene: a plate that slides under fruit, which is laid on it upstream and removed at its end.

The plate is a body of its own that moves along the belt, so that fruit rides, slips and rolls on it by friction. It is
uniform and is set back by each `STRIPE_PITCH`, which does not affect contacts. Fruit that has not come yet, or has
left, rests on a shelf under the table.
"""

from math import copysign
from typing import Any

import numpy as np

from layflat.cell.extras import NO_CONTACT, add_geom, mujoco
from layflat.cell.file.model import Conveyor
from layflat.cell.geometry import rotation_about_z
from layflat.cell.scene.movables import BELT_CONTACT_BIT
from layflat.cell.scene.produce import SHELF_GRID, SHELF_HEIGHT, SceneFruit

STRIPE_PITCH = 0.1  # of the plate's stripes, m
STRIPE_WIDTH = 8e-3  # m
HALF_THICKNESS = 4e-3  # of the plate, m
PLATE_MASS = 100.0  # kg: large, so that fruit does not slow the plate
GUIDE_HALF_WIDTH = 4e-3  # of the guides at its sides, m
GUIDE_HEIGHT = 10e-3  # over the belt, m: rolling fruit stays on it
WAKING_FORCE = 1e-12  # for one timestep, N: wakes a sleeping body of MuJoCo without moving it
LAYING_CLEARANCE = 1e-4  # height over the belt at which fruit is laid on it, m


def add_belt(spec: Any, belt: Conveyor) -> None:
    """Add a conveyor to a spec: plate with slide joint `belt`, guides, and the shelf for fruit that is not on it."""
    mj = mujoco()
    (length, width), (x, y) = belt.size, belt.centre
    frame = spec.worldbody.add_body(
        name="conveyor", pos=[x, y, belt.height], quat=rotation_about_z(belt.rotation).tolist()
    )
    dark = [0.5 * channel for channel in belt.colour]
    under = (belt.height - 2 * HALF_THICKNESS) / 2
    if under > 0.0:
        pos, size = [0.0, 0.0, -2 * HALF_THICKNESS - under], (length / 2, width / 2, under)
        add_geom(frame, "box", "conveyor.frame", size=size, pos=pos, rgba=[*dark, 1.0])
    for side in (-1.0, 1.0):
        half = (belt.height + GUIDE_HEIGHT) / 2
        pos, size = (
            [0.0, side * (width / 2 - GUIDE_HALF_WIDTH), GUIDE_HEIGHT - half],
            (length / 2, GUIDE_HALF_WIDTH, half),
        )
        add_geom(frame, "box", f"conveyor.guide{side:+.0f}", size=size, pos=pos, rgba=[*dark, 1.0], condim=6)
    surface = {
        "size": (length / 2, width / 2, HALF_THICKNESS),
        "pos": [0.0, 0.0, -HALF_THICKNESS],
        "rgba": [*belt.colour, 1.0],
    }
    add_geom(frame, "box", "conveyor.surface", **surface, **NO_CONTACT)
    plate = frame.add_body(name="belt")
    plate.sleep = mj.mjtSleepPolicy.mjSLEEP_NEVER
    plate.add_joint(name="belt", type=mj.mjtJoint.mjJNT_SLIDE, axis=[1, 0, 0])
    touch = {"contype": BELT_CONTACT_BIT, "conaffinity": BELT_CONTACT_BIT, "condim": 6, "mass": PLATE_MASS}
    size = (length / 2 + STRIPE_PITCH, width / 2, HALF_THICKNESS)
    add_geom(plate, "box", "belt", size=size, pos=[0.0, 0.0, -HALF_THICKNESS], rgba=[0.0, 0.0, 0.0, 0.0], **touch)
    stripe = {"size": (STRIPE_WIDTH / 2, width / 2 - 2 * GUIDE_HALF_WIDTH, 2e-4), "rgba": [*dark, 1.0], "mass": 0.0}
    for i in range(int(length / STRIPE_PITCH - 1e-9)):
        at = -length / 2 + STRIPE_WIDTH / 2 + i * STRIPE_PITCH
        add_geom(plate, "box", f"belt.stripe-{i}", pos=[at, 0.0, 0.0], **stripe, **NO_CONTACT)
    half = SHELF_GRID[0] * SHELF_GRID[1] / 2 + SHELF_GRID[1]
    shelf = {"size": (half, half, 0.01), "pos": [x, y, SHELF_HEIGHT - 0.01], "rgba": [0.0, 0.0, 0.0, 0.0]}
    add_geom(spec.worldbody, "box", "shelf", condim=6, **shelf)


class BeltDrive:
    """Drive of the belt: moves the plate, lays fruit on it in time, and removes it at its ends.

    Attributes:
        speed: speed of the belt now, m/s.
        speed_override: demanded speed in place of the description's, m/s; None: the description's.
        here: True for each fruit that is in the cell, (fruit,).
        gone: True for each fruit that the belt has carried away, (fruit,).
    """

    def __init__(self, model: Any, data: Any, belt: Conveyor, fruits: list[SceneFruit]) -> None:
        """Begin with the belt at rest, and all fruit at its present pose on the shelf."""
        self._data, self._belt, self._step = data, belt, float(model.opt.timestep)
        joint = model.joint("belt")
        self._place, self._dof = int(joint.qposadr[0]), int(joint.dofadr[0])
        joints = [model.joint(fruit.name) for fruit in fruits]
        self._places = [slice(int(one.qposadr[0]), int(one.qposadr[0]) + 7) for one in joints]
        self._dofs = [slice(int(one.dofadr[0]), int(one.dofadr[0]) + 6) for one in joints]
        self._rest = [data.qpos[place].copy() for place in self._places]
        self._comes = [(fruit.comes or (0.0, 0.0)) for fruit in fruits]
        self.here, self.gone = np.zeros(len(fruits), bool), np.zeros(len(fruits), bool)
        self.speed, self._way = 0.0, 0.0
        self.speed_override: float | None = None
        self._waking: list[slice] = []

    def advance(self, held: int | None) -> bool:
        """Advance the belt by a timestep in the MjData: move it, lay fruit on it and remove fruit at its ends.

        Return whether any fruit was laid or removed; that of number `held` is never removed.
        """
        demand = self._belt.demanded_speed(self._data.time) if self.speed_override is None else self.speed_override
        max_change = self._belt.acceleration * self._step
        self.speed += min(max(demand - self.speed, -max_change), max_change)
        self._way += self.speed * self._step
        self._data.qvel[self._dof] = self.speed
        if abs(self._data.qpos[self._place]) >= STRIPE_PITCH:
            self._data.qpos[self._place] -= copysign(STRIPE_PITCH, self._data.qpos[self._place])
        for dofs in self._waking:
            self._data.qfrc_applied[dofs] = 0.0
        self._waking.clear()
        changed = False
        for number, (distance, across) in enumerate(self._comes):
            if not self.here[number] and not self.gone[number] and distance <= self._way:
                self._place_fruit(number, self._way - distance, across)
                changed = True
            elif self.here[number] and number != held and self._has_passed(number):
                self._data.qpos[self._places[number]] = self._rest[number]
                self._data.qvel[self._dofs[number]] = 0.0
                self.here[number], self.gone[number], changed = False, True, True
        return changed

    def _place_fruit(self, number: int, onwards: float, across: float) -> None:
        """Lay a fruit on the belt, at its speed, `onwards` m from the laying position and `across` m from the middle.

        It keeps the orientation that it had on the shelf.
        """
        belt, data, rest = self._belt, self._data, self._rest[number]
        x, y = belt.to_cell_frame(np.array([[onwards - belt.size[0] / 2 + belt.size[1] / 2, across]]))[0]
        data.qpos[self._places[number]] = [x, y, rest[2] - SHELF_HEIGHT + belt.height + LAYING_CLEARANCE, *rest[3:]]
        (vx, vy), _ = belt.to_cell_frame(np.array([[self.speed, 0.0], [0.0, 0.0]])) - np.array(belt.centre)
        data.qvel[self._dofs[number]] = [vx, vy, 0.0, 0.0, 0.0, 0.0]
        data.qfrc_applied[self._dofs[number]] = WAKING_FORCE
        self._waking.append(self._dofs[number])
        self.here[number] = True

    def _has_passed(self, number: int) -> bool:
        """Return whether a fruit over the belt is at the belt's end, or at its begin while it runs backwards."""
        x, y = self._data.qpos[self._places[number]][:2]
        along, across = self._belt.from_centre(float(x), float(y))
        if abs(across) > self._belt.size[1] / 2:  # it was taken elsewhere
            return False
        end, begin = self._belt.size[0] / 2, self._belt.size[1] / 2 - self._belt.size[0] / 2
        return bool(along > end - 0.02 or (self.speed < 0.0 and along < begin))
