"""Who observes a cell at work: one protocol for progress, evaluation, films and sheets."""

from collections.abc import Callable
from functools import partial
from typing import Any

from layflat.cell.perception import Observation
from layflat.cell.plan.containers import Fruit
from layflat.cell.plan.order import Choice
from layflat.cell.plan.pick import State
from layflat.cell.scene import Scene
from layflat.cell.scene.camera import SimulatedCamera
from layflat.cell.work.records import Delivery, Pick


class Observer:
    """Base of all observers, which does nothing."""

    def begins(self, scene: Scene, camera: SimulatedCamera | None) -> None:
        """A delivery begins; there is no camera where no image can be rendered."""

    def cycle(self, time: float) -> None:
        """A control cycle is over, s since the delivery began."""

    def chosen(self, fruit: Fruit, observation: Observation) -> None:
        """A pick begins: of a fruit as it lay in the image by which it was chosen."""

    def phase(self, choice: Choice, before: State, after: State) -> None:
        """A pick's phase has changed."""

    def observed(self, observation: Observation) -> None:
        """An image was taken and could be used."""

    def picked(self, pick: Pick) -> None:
        """A pick has ended."""

    def ends(self, delivery: Delivery) -> None:
        """The delivery is over and evaluated; the scene is still there."""


class Observers(Observer):
    """Observers as one: each event goes to all, in the order given."""

    def __init__(self, *observers: Observer) -> None:
        for event in ("begins", "cycle", "chosen", "phase", "observed", "picked", "ends"):
            setattr(self, event, partial(_tell, [getattr(observer, event) for observer in observers]))


class PickCounter(Observer):
    """Calls `count` with the number of picks that have ended, after every pick."""

    def __init__(self, count: Callable[[int], object]) -> None:
        self._count, self._picks = count, 0

    def picked(self, pick: Pick) -> None:  # noqa: ARG002  (as all observers)
        """Count one more."""
        self._picks += 1
        self._count(self._picks)


def _tell(calls: list[Callable[..., None]], *event: Any) -> None:
    for call in calls:
        call(*event)
