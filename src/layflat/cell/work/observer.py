"""Records of a cell's work, and its observers: one protocol for progress, evaluation, films and sheets."""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import partial
from math import nan
from typing import Any, Self

from layflat.arrays import Array
from layflat.cell.perception import Observation
from layflat.cell.plan.order import Fruit, NotPicked, PickChoice
from layflat.cell.plan.pick import PickOutcome, PickState
from layflat.cell.scene import Scene
from layflat.cell.scene.camera import SimulatedCamera
from layflat.cell.scene.truth import Collision
from layflat.errors import LayflatError
from layflat.rig.record import RowLayout


@dataclass(frozen=True)
class Pick:
    """Record of one pick, by the cell's own sensors."""

    number: int  # from 1
    choice: PickChoice  # fruit and place
    outcome: PickOutcome
    trouble: str  # last failure, as one clause; empty where there was none
    tries: int  # number of attempts to lower the cup on it
    begin: float  # s
    end: float  # s
    air: float  # normal litres
    observation: Observation  # last one with the fruit before the pick


@dataclass(frozen=True)
class Verdict:
    """Truth about a pick, known once its delivery is over."""

    fruit: str = ""  # name of the carried fruit; empty where none was carried
    kind: str = ""
    grade: str | None = None  # None where it is of none
    correct: bool = False  # True if it is in the chosen place, and of the kind and grade of that place
    release_error: float = nan  # from its middle to that of its place when it was released, m; nan if it never was
    peak_acceleration: float = nan  # greatest since the scene began, m/s^2
    press: float = nan  # greatest force of the cup on it, N

    def word(self, pick: Pick) -> str:
        """Return the result of a pick: "correct", "wrong" (placed all the same), or its outcome, such as "missed"."""
        if self.correct:
            return "correct"
        return "wrong" if pick.outcome is PickOutcome.PLACED else pick.outcome.name.lower()


@dataclass
class VisionErrors:
    """Sure detections in the trays against the fruit in them, over all images of a delivery."""

    positions: list[float] = field(default_factory=list)  # errors on the table, m
    diameters: list[float] = field(default_factory=list)  # relative errors
    false: int = 0  # detections of a known kind where no fruit of that kind is


@dataclass(frozen=True, eq=False)
class Delivery:
    """Result of a delivery."""

    seed: int  # of its scene
    picks: tuple[Pick, ...]
    verdicts: tuple[Verdict, ...]  # of each pick
    not_picked: tuple[NotPicked, ...]  # and why
    collisions: tuple[Collision, ...]  # of arm, lift or cup, except contacts of the cup with fruit
    time: float  # from the first image to the last, s
    vision: VisionErrors  # of fruit in trays
    overlooked: int | None = None  # fruit that could have been packed in trays that were worked off; else None
    error: LayflatError | None = None  # error that ended it early

    @property
    def without_pictures(self) -> Self:
        """Copy without pictures and detections, which take half a GB for a hundred picks."""
        bare = (replace(pick.observation, picture=None, detections=()) for pick in self.picks)
        picks = (replace(pick, observation=observation) for pick, observation in zip(self.picks, bare, strict=True))
        return replace(self, picks=tuple(picks))


class Observer:
    """Base of all observers: a method for each event, called when it occurs; here they do nothing."""

    def on_delivery_start(self, scene: Scene, camera: SimulatedCamera | None) -> None:
        """Handle the start of a delivery; `camera` is None where no image can be rendered."""

    def on_cycle_record(self, layout: RowLayout, row: Array) -> None:
        """Handle the record of a control cycle, as a rig's, before `on_control_cycle`.

        Args:
            layout: layout of the row.
            row: numbers of the cycle, (width,); overwritten in the next.
        """

    def on_control_cycle(self, time: float) -> None:
        """Handle the end of a control cycle; `time` is counted from the start of the delivery, s."""

    def on_pick_start(self, fruit: Fruit, observation: Observation) -> None:
        """Handle the start of a pick: the fruit, as it lay in the observation by which it was chosen."""

    def on_phase_change(self, choice: PickChoice, before: PickState, after: PickState) -> None:
        """Handle the change of a pick's phase.

        Args:
            choice: fruit and place of the pick.
            before: state in its last phase.
            after: state in its new phase.
        """

    def on_image(self, observation: Observation) -> None:
        """Handle an image that was taken and could be used."""

    def on_pick_end(self, pick: Pick) -> None:
        """Handle the end of a pick."""

    def on_delivery_end(self, delivery: Delivery) -> None:
        """Handle the end of a delivery, which is evaluated; the scene still exists."""


class Observers(Observer):
    """Composite of observers: each event is passed to all, in their order."""

    def __init__(self, *observers: Observer) -> None:
        for event in [name for name in vars(Observer) if name.startswith("on_")]:
            setattr(self, event, partial(_notify, [getattr(observer, event) for observer in observers]))


class PickCounter(Observer):
    """Observer that calls `count` with the number of picks that have ended, after every pick."""

    def __init__(self, count: Callable[[int], object]) -> None:
        self._count, self._picks = count, 0

    def on_pick_end(self, pick: Pick) -> None:  # noqa: ARG002  (as all observers)
        """Count the pick, and call `count` with the number so far."""
        self._picks += 1
        self._count(self._picks)


def _notify(calls: list[Callable[..., None]], *event: Any) -> None:
    for call in calls:
        call(*event)
