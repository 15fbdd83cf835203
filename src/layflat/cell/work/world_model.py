"""What the cell knows of its table: what images showed, and what the arm hid meanwhile."""

from __future__ import annotations

import numpy as np

from layflat.cell.file.model import Cell
from layflat.cell.perception import Observation, Perception
from layflat.cell.plan.fruit import Fruit
from layflat.cell.reach import Angles, Reach
from layflat.cell.work.observer import Observer
from layflat.cell.work.occlusion import OcclusionModel, remembered
from layflat.errors import PictureError


class WorldModel:
    """Takes images of the table and knows what lies there.

    Args:
        cell: its description.
        perception: its camera.
        reach: of its arm.
        observer: is given the observations.

    Attributes:
        known: what lies on the table, as far as was observed.
        seen_in: the last observation of each fruit that is known.
    """

    def __init__(self, cell: Cell, perception: Perception, reach: Reach, observer: Observer) -> None:
        self._cell, self._perception, self._reach, self._observer = cell, perception, reach, observer
        self.known: list[Fruit] = []
        self.seen_in: dict[Fruit, Observation] = {}

    @property
    def in_trays(self) -> list[Fruit]:
        """What can be picked, as far as its place goes."""
        return [fruit for fruit in self.known if self._cell.tray_at(fruit.x, fruit.y) is not None]

    @property
    def outside(self) -> list[Fruit]:
        """What lies neither in a tray nor in a container."""
        inside = self.in_trays
        return [fruit for fruit in self.known if fruit not in inside and self._cell.place_at(fruit.x, fruit.y) is None]

    def update(self, time: float, arm: Angles | None) -> None:
        """Take an image.

        Args:
            time: s.
            arm: its angles, rad; None where it is out of view.

        Raises:
            PictureError: it can't be used; all that was known is known still.
        """
        observation = self._perception.observe(time)
        occlusion = self._occlusion(arm) if arm is not None else None
        self.known = remembered(self.known, observation.fruits, occlusion)
        # What is remembered is the very same fruit as in the observation that showed it.
        self.seen_in = {fruit: self.seen_in.get(fruit, observation) for fruit in self.known}
        self._observer.observed(observation)

    def updated(self, time: float, arm: Angles | None) -> bool:
        """Take an image; return whether it could be used."""
        try:
            self.update(time, arm)
        except PictureError:
            return False
        return True

    def forget(self, fruit: Fruit) -> None:
        """Drop a fruit that was picked up."""
        self.known = [other for other in self.known if other != fruit]

    def _occlusion(self, arm: Angles) -> OcclusionModel:
        joints = self._cell.machine.joints.values()
        return OcclusionModel(
            self._perception.position,
            np.array(self._reach.axes(arm)),
            self._cell.mount.height,
            max(joint.cylinder.diameter for joint in joints) / 2,
            max(joint.body.height for joint in joints) / 2,
        )
