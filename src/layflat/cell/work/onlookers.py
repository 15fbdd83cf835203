"""Who looks on while a cell works, as parts to be put together."""

from __future__ import annotations

from collections.abc import Callable

from layflat.cell.camera import Camera
from layflat.cell.plan.order import Choice
from layflat.cell.plan.pick import State
from layflat.cell.scene import Scene
from layflat.cell.work.delivery import Delivery, Onlooker
from layflat.cell.work.eyes import Sight
from layflat.cell.work.packer import Pick


class Nobody(Onlooker):
    """Looks on and does nothing."""


class Tally(Onlooker):
    """Calls with the number of picks that have ended.

    Args:
        told: is called after every pick.
    """

    def __init__(self, told: Callable[[int], object]) -> None:
        self._told, self._picks = told, 0

    def picked(self, pick: Pick) -> None:  # noqa: ARG002  (as all onlookers)
        """One more."""
        self._picks += 1
        self._told(self._picks)


class Several(Onlooker):
    """Onlookers as one, in the order given."""

    def __init__(self, *onlookers: Onlooker) -> None:
        self._onlookers = onlookers

    def begins(self, scene: Scene, camera: Camera | None) -> None:
        """A delivery begins."""
        for onlooker in self._onlookers:
            onlooker.begins(scene, camera)

    def cycle(self, time: float) -> None:
        """A control cycle is over."""
        for onlooker in self._onlookers:
            onlooker.cycle(time)

    def phase(self, choice: Choice, before: State, after: State) -> None:
        """A pick's phase has changed."""
        for onlooker in self._onlookers:
            onlooker.phase(choice, before, after)

    def looked(self, sight: Sight) -> None:
        """A picture was taken."""
        for onlooker in self._onlookers:
            onlooker.looked(sight)

    def picked(self, pick: Pick) -> None:
        """A pick has ended."""
        for onlooker in self._onlookers:
            onlooker.picked(pick)

    def ends(self, delivery: Delivery) -> None:
        """The delivery is over."""
        for onlooker in self._onlookers:
            onlooker.ends(delivery)
