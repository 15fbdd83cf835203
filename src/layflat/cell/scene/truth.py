"""Truth of the scene, for evaluation only, never for vision or plans."""

from dataclasses import dataclass, fields
from math import sqrt
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from layflat.arrays import Array
from layflat.cell.file.model import Cell
from layflat.cell.scene.grip import Grip
from layflat.cell.scene.produce import SceneFruit, Specimen


@dataclass(frozen=True)
class FruitTruth(Specimen):
    """State of a fruit at an instant; peaks are those since the scene began."""

    position: Array  # of its middle in the cell's frame, (3,) m
    orientation: Array  # quaternion, w first, (4,)
    acceleration: float  # of its middle in the last step, m/s^2
    peak_acceleration: float  # m/s^2
    press: float  # greatest force of the cup on it, N
    gripped: bool  # True while the cup holds it
    here: bool  # True while it is in the cell: False before it comes on a belt, and once that carried it away
    place: tuple[str, int] | None  # name of the container and number of the place, None outside of places


class Collision(NamedTuple):
    """A first contact of the arm, its lift or its cup with something that it should not touch."""

    time: float
    part: str
    other: str


class SceneTruth(NamedTuple):
    """State of the whole scene at an instant."""

    time: float
    tip: Array  # position of the cup's lip, (3,) m
    fruits: dict[str, FruitTruth]  # by name
    collisions: tuple[Collision, ...]  # since the scene began


class TruthRecorder:
    """Recorder of a scene's timesteps: accelerations and places of fruit, and collisions."""

    def __init__(self, model: Any, data: Any, cell: Cell, fruits: list[SceneFruit]) -> None:
        """Begin at the present velocities, without collisions."""
        self._model, self._data, self._cell, self._fruits = model, data, cell, fruits
        starts = [int(model.joint(fruit.name).dofadr[0]) for fruit in fruits]
        self._dofs = np.array([[start, start + 1, start + 2] for start in starts], int).reshape(-1, 3)
        self._before = data.qvel[self._dofs]
        # Squares of the changes of velocities, (m/s)^2: in the last timestep, and the greatest.
        self._change, self._greatest = np.zeros(len(fruits)), np.zeros(len(fruits))
        self._collisions: dict[tuple[int, int], Collision] = {}
        self._bodies = [model.body(fruit.name).id for fruit in fruits]
        arm = model.jnt_bodyid[model.joint(next(iter(cell.machine.joints))).id]
        self._arm = model.body_rootid[model.geom_bodyid] == model.body_rootid[arm]
        self._fruit = np.isin(model.geom_bodyid, self._bodies)
        self._cup = model.geom("cup").id

    def record(self) -> None:
        """Record the fruit's acceleration in the last timestep, its greatest so far, and new collisions."""
        velocity = self._data.qvel[self._dofs]
        change = velocity - self._before
        self._before = velocity
        self._change = np.einsum("ij,ij->i", change, change)
        np.maximum(self._greatest, self._change, out=self._greatest)
        if self._data.ncon:
            self._record_collisions()

    def _record_collisions(self) -> None:
        """Record each first contact between the arm and anything else, except that of the cup with fruit."""
        pairs = self._data.contact.geom
        ours = self._arm[pairs]
        for first, second in pairs[ours[:, 0] ^ ours[:, 1]]:
            part, other = (first, second) if self._arm[first] else (second, first)
            key = (int(part), int(other))
            if key not in self._collisions and not (part == self._cup and self._fruit[other]):
                names = (self._model.geom(geom).name for geom in key)
                self._collisions[key] = Collision(float(self._data.time), *names)

    def restart(self) -> None:
        """Restart from the present velocities after fruit was laid down or removed, which is no motion of the scene."""
        self._before = self._data.qvel[self._dofs]

    def truth(self, grip: Grip, here: NDArray[np.bool_] | None) -> SceneTruth:
        """Return the truth of the scene now; `here`: flags of fruit in the cell, (fruit,), None: all of it."""
        data, step, fruits = self._data, self._model.opt.timestep, {}
        for number, (fruit, body) in enumerate(zip(self._fruits, self._bodies, strict=True)):
            held, at = grip.held == number, data.xpos[body].copy()
            fruits[fruit.name] = FruitTruth(
                **{field.name: getattr(fruit, field.name) for field in fields(Specimen)},
                position=at, orientation=data.xquat[body].copy(),
                acceleration=sqrt(self._change[number]) / step, peak_acceleration=sqrt(self._greatest[number]) / step,
                press=float(grip.press[number]), gripped=held, here=here is None or bool(here[number]),
                place=None if held else self._place(at, fruit),
            )  # fmt: skip
        return SceneTruth(float(data.time), data.site("cup").xpos.copy(), fruits, tuple(self._collisions.values()))

    def _place(self, at: Array, fruit: SceneFruit) -> tuple[str, int] | None:
        """Return the place in which a fruit lies: its middle is over the place, and it is not on a rim."""
        if (place := self._cell.place_at(float(at[0]), float(at[1]))) is None:
            return None
        layout = self._cell.container[place[0]].layout
        return place if at[2] < layout.wall + fruit.diameter / 2 + layout.divider / 2 else None
