"""The conveyor in the scene: a plate that slides under fruit, which is laid on it upstream and taken off at its end.

The plate is a body of its own that moves along the belt, so that fruit rides, slips and rolls on it by friction. It is
alike all along and begins anew after each `PITCH`, which no contact notices. What has not come yet, and what has gone,
rests on a shelf under the table.
"""

from math import copysign
from typing import Any

import numpy as np

from layflat.cell.extras import UNTOUCHED, add_geom, mujoco
from layflat.cell.file.conveyor import Conveyor
from layflat.cell.geometry import about_z
from layflat.cell.scene.movables import BELT
from layflat.cell.scene.produce import GRID, SHELF, SceneFruit

PITCH = 0.1  # of the plate's stripes, m
STRIPE = 8e-3  # their width, m
THICK = 4e-3  # half the plate's thickness, m
HEAVY = 100.0  # mass of the plate, kg: what lies on it does not slow it
RAIL = 4e-3  # half the width of the guides at its sides, m
RAISED = 10e-3  # height of the guides over the belt, m: what rolls stays on it
WAKES = 1e-12  # force for one timestep that wakes fruit which sleeps on the shelf, and does no more, N
LAID = 1e-4  # over the belt, at which fruit is laid on it, m


def add_belt(spec: Any, belt: Conveyor) -> None:
    """Add a conveyor to a spec: slide joint `belt`, its guides, and the shelf for what is not on it."""
    mj = mujoco()
    (length, width), (x, y) = belt.size, belt.centre
    frame = spec.worldbody.add_body(name="conveyor", pos=[x, y, belt.height], quat=about_z(belt.rotation).tolist())
    dark = [0.5 * channel for channel in belt.colour]
    under = (belt.height - 2 * THICK) / 2
    if under > 0.0:
        pos, size = [0.0, 0.0, -2 * THICK - under], (length / 2, width / 2, under)
        add_geom(frame, "box", "conveyor.frame", size=size, pos=pos, rgba=[*dark, 1.0])
    for side in (-1.0, 1.0):
        half = (belt.height + RAISED) / 2
        pos, size = [0.0, side * (width / 2 - RAIL), RAISED - half], (length / 2, RAIL, half)
        add_geom(frame, "box", f"conveyor.guide{side:+.0f}", size=size, pos=pos, rgba=[*dark, 1.0], condim=6)
    surface = {"size": (length / 2, width / 2, THICK), "pos": [0.0, 0.0, -THICK], "rgba": [*belt.colour, 1.0]}
    add_geom(frame, "box", "conveyor.surface", **surface, **UNTOUCHED)
    plate = frame.add_body(name="belt")
    plate.sleep = mj.mjtSleepPolicy.mjSLEEP_NEVER
    plate.add_joint(name="belt", type=mj.mjtJoint.mjJNT_SLIDE, axis=[1, 0, 0])
    touch = {"contype": BELT, "conaffinity": BELT, "condim": 6, "mass": HEAVY}
    size = (length / 2 + PITCH, width / 2, THICK)
    add_geom(plate, "box", "belt", size=size, pos=[0.0, 0.0, -THICK], rgba=[0.0, 0.0, 0.0, 0.0], **touch)
    stripe = {"size": (STRIPE / 2, width / 2 - 2 * RAIL, 2e-4), "rgba": [*dark, 1.0], "mass": 0.0}
    for i in range(int(length / PITCH - 1e-9)):
        at = -length / 2 + STRIPE / 2 + i * PITCH
        add_geom(plate, "box", f"belt.stripe-{i}", pos=[at, 0.0, 0.0], **stripe, **UNTOUCHED)
    half = GRID[0] * GRID[1] / 2 + GRID[1]
    shelf = {"size": (half, half, 0.01), "pos": [x, y, SHELF - 0.01], "rgba": [0.0, 0.0, 0.0, 0.0]}
    add_geom(spec.worldbody, "box", "shelf", condim=6, **shelf)


class BeltDrive:
    """Moves the plate, lays fruit on it as its turn comes, and takes off what comes to an end.

    Attributes:
        speed: of the belt now, m/s; settable through `asked`, which overrides what the description asks for.
        here: whether each fruit is in the cell, (fruit,).
    """

    def __init__(self, model: Any, data: Any, belt: Conveyor, fruits: list[SceneFruit]) -> None:
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
        self.asked: float | None = None
        self._waking: list[slice] = []

    def advance(self, held: int | None) -> bool:
        """Advance the belt by a timestep; return whether fruit was laid on it or taken off, but what is `held`."""
        asked = self._belt.asked_speed(self._data.time) if self.asked is None else self.asked
        most = self._belt.acceleration * self._step
        self.speed += min(max(asked - self.speed, -most), most)
        self._way += self.speed * self._step
        self._data.qvel[self._dof] = self.speed
        if abs(self._data.qpos[self._place]) >= PITCH:
            self._data.qpos[self._place] -= copysign(PITCH, self._data.qpos[self._place])
        for dofs in self._waking:
            self._data.qfrc_applied[dofs] = 0.0
        self._waking.clear()
        changed = False
        for number, (way, across) in enumerate(self._comes):
            if not self.here[number] and not self.gone[number] and way <= self._way:
                self._lay(number, self._way - way, across)
                changed = True
            elif self.here[number] and number != held and self._passed(number):
                self._data.qpos[self._places[number]] = self._rest[number]
                self._data.qvel[self._dofs[number]] = 0.0
                self.here[number], self.gone[number], changed = False, True, True
        return changed

    def _lay(self, number: int, onwards: float, across: float) -> None:
        """Lay a fruit on the belt as it rests on the shelf, at the belt's speed."""
        belt, data, rest = self._belt, self._data, self._rest[number]
        x, y = belt.placed(np.array([[onwards - belt.size[0] / 2 + belt.size[1] / 2, across]]))[0]
        data.qpos[self._places[number]] = [x, y, rest[2] - SHELF + belt.height + LAID, *rest[3:]]
        (vx, vy), _ = belt.placed(np.array([[self.speed, 0.0], [0.0, 0.0]])) - np.array(belt.centre)
        data.qvel[self._dofs[number]] = [vx, vy, 0.0, 0.0, 0.0, 0.0]
        data.qfrc_applied[self._dofs[number]] = WAKES
        self._waking.append(self._dofs[number])
        self.here[number] = True

    def _passed(self, number: int) -> bool:
        """Return whether a fruit on the belt has come to one of its ends."""
        x, y = self._data.qpos[self._places[number]][:2]
        along, across = self._belt.from_centre(float(x), float(y))
        if abs(across) > self._belt.size[1] / 2:  # it was taken elsewhere
            return False
        end, begin = self._belt.size[0] / 2, self._belt.size[1] / 2 - self._belt.size[0] / 2
        return bool(along > end - 0.02 or (self.speed < 0.0 and along < begin))
