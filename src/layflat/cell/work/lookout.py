"""What the cell knows of its table: what pictures showed, and what the arm hid meanwhile."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

import numpy as np

from layflat.cell.eyes import place_of
from layflat.cell.file.checks import within
from layflat.cell.file.model import Cell
from layflat.cell.plan.fruit import Fruit
from layflat.cell.plan.reach import Angles, Reach
from layflat.cell.work.eyes import Eyes, Sight
from layflat.cell.work.memory import Shade, remembered
from layflat.errors import PictureError


class Looker(Protocol):
    """Who is told of pictures."""

    def looked(self, sight: Sight) -> None:
        """A picture was taken and could be used."""


class Lookout:
    """Looks at the table and knows what lies there.

    Args:
        cell: its description.
        eyes: its camera.
        reach: of its arm.
        lookers: are told of pictures.

    Attributes:
        known: what lies on the table, as far as was seen.
        seen_in: the last picture that showed it, by what is known.
    """

    def __init__(self, cell: Cell, eyes: Eyes, reach: Reach, lookers: Sequence[Looker] = ()) -> None:
        self._cell, self._eyes, self._reach, self._lookers = cell, eyes, reach, lookers
        self.known: list[Fruit] = []
        self.seen_in: dict[Fruit, Sight] = {}

    @property
    def in_trays(self) -> list[Fruit]:
        """What can be picked, as far as its place goes."""
        trays = self._cell.tray.values()
        return [fruit for fruit in self.known if any(within(tray, fruit.x, fruit.y) for tray in trays)]

    @property
    def astray(self) -> list[Fruit]:
        """What lies neither in a tray nor in a pack."""
        inside = self.in_trays
        return [fruit for fruit in self.known if fruit not in inside and place_of(self._cell, fruit.x, fruit.y) is None]

    def look(self, time: float, arm: Angles | None) -> None:
        """Take a picture.

        Args:
            time: s.
            arm: where it stands, rad; None where it is out of sight.

        Raises:
            PictureError: it can't be used; all that was known is known still.
        """
        sight = self._eyes.look(time)
        self.known = remembered(self.known, sight.fruits, self._shade(arm) if arm is not None else None)
        # What is remembered is the very same fruit as in the picture that showed it.
        self.seen_in = {fruit: self.seen_in.get(fruit, sight) for fruit in self.known}
        for looker in self._lookers:
            looker.looked(sight)

    def tried(self, time: float, arm: Angles | None) -> bool:
        """Take a picture; whether it could be used."""
        try:
            self.look(time, arm)
        except PictureError:
            return False
        return True

    def forget(self, fruit: Fruit) -> None:
        """It was picked up."""
        self.known = [other for other in self.known if other != fruit]

    def _shade(self, arm: Angles) -> Shade:
        joints = self._cell.machine.joints.values()
        return Shade(
            self._eyes.position,
            np.array(self._reach.axes(arm)),
            self._cell.mount.height,
            max(joint.cylinder.diameter for joint in joints) / 2,
            max(joint.body.height for joint in joints) / 2,
        )
