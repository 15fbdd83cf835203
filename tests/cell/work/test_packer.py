"""What a cell does in its scene, whose truth stands in for the camera: images are tested with perception and run."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from layflat.cell import Cell
from layflat.cell.perception import Observation, ScenePerception
from layflat.cell.plan.order import Fruit, PickChoice
from layflat.cell.plan.pick import PickOutcome, PickPhase, PickState
from layflat.cell.scene import Scene
from layflat.cell.work.evaluation import Evaluator
from layflat.cell.work.observer import Observer, Observers, Pick, Verdict
from layflat.cell.work.packer import Packer
from layflat.cell.work.station import CellStation
from layflat.errors import PictureError, RigStoppedError
from tests.cell.work.changed_cells import cell_with

FEW = {
    "tray/infeed/count": {"min": 3, "max": 3},
    "tray/infeed/touching_fraction": 0.0,
    "tray/infeed/produce": ["tomato"],
}
RED = {"produce/tomato/colour/orange/fraction": 1e-6, "produce/tomato/diameter/min": "53 mm"}


class Changing:
    """Perception whose finds are changed before they are told."""

    def __init__(self, scene: Scene) -> None:
        self._perception = ScenePerception(scene)
        self.position: NDArray[np.float64] = self._perception.position
        self.images = 0

    def observe(self, time: float) -> Observation:
        self.images += 1
        observation = self._perception.observe(time)
        return replace(observation, fruits=tuple(self.changed(list(observation.fruits))))

    def changed(self, fruits: list[Fruit]) -> list[Fruit]:
        return fruits


class Work:
    """A cell at work, with its evaluator."""

    def __init__(self, cell: Cell, seed: int = 1, perception: type[Changing] = Changing) -> None:
        self.scene = Scene(cell, seed)
        self.station, self.perception, self.evaluator = (
            CellStation(self.scene, seed),
            perception(self.scene),
            Evaluator(self.scene),
        )
        self.packer = Packer(cell, self.station, self.perception, self.evaluator)
        self.picks: list[Pick] = []

    def run(self, most: int = 99) -> list[Verdict]:
        for pick in self.packer.work(most):
            self.picks.append(pick)
            self.evaluator.on_pick_end(pick)
        return self.evaluator.verdicts(self.picks)


def test_a_tray_is_packed() -> None:
    work = Work(cell_with(FEW | RED))
    verdicts = work.run()
    assert [pick.outcome for pick in work.picks] == [PickOutcome.PLACED] * 3
    assert all(verdict.correct for verdict in verdicts)
    assert max(verdict.release_error for verdict in verdicts) < 3e-3
    assert max(verdict.peak_acceleration for verdict in verdicts) < work.scene.cell.limits.acceleration
    assert work.scene.truth().collisions == ()
    assert work.packer.not_picked == ()
    assert work.evaluator.vision.false == 0
    assert all(1.5 < pick.end - pick.begin < 4.5 for pick in work.picks)
    assert all(3.0 < pick.air < 15.0 for pick in work.picks)


def test_what_slips_off_is_lost_and_the_others_are_packed() -> None:
    """One tomato is as slippery as soap: it goes where it likes, and is seen again where it lies."""
    work = Work(cell_with(FEW | RED | {"cup/friction": 0.02}))
    verdicts = work.run(2)
    lost = [pick for pick in work.picks if pick.outcome is PickOutcome.LOST]
    assert lost
    assert all("vacuum was lost" in pick.trouble for pick in lost)
    assert not any(verdict.correct for verdict, pick in zip(verdicts, work.picks, strict=True) if pick in lost)
    assert work.packer.packing.contents == {}
    assert not any(fruit.gripped for fruit in work.scene.truth().fruits.values())
    assert verdicts[0].word(work.picks[0]) == "lost"


class Haunted(Changing):
    """Sees a fruit at first where there is none."""

    GHOST = Fruit(0.38, 0.40, 0.06, "tomato", "first")

    def changed(self, fruits: list[Fruit]) -> list[Fruit]:
        return [self.GHOST] if self.images == 1 else fruits


def test_where_a_new_picture_shows_nothing_the_pick_is_over() -> None:
    work = Work(cell_with(FEW | RED), perception=Haunted)
    work.run(2)
    assert [pick.outcome for pick in work.picks] == [PickOutcome.GONE, PickOutcome.PLACED]
    assert work.picks[0].tries == 1
    assert work.picks[0].trouble == "no vacuum built up"


class Stubborn(Changing):
    """Goes on seeing it."""

    def changed(self, fruits: list[Fruit]) -> list[Fruit]:  # noqa: ARG002  (as all perceptions)
        return [Haunted.GHOST]


def test_what_is_missed_three_times_is_given_up() -> None:
    work = Work(cell_with(FEW | RED), perception=Stubborn)
    verdicts = work.run()
    assert [(pick.outcome, pick.tries) for pick in work.picks] == [(PickOutcome.MISSED, 3)]
    assert [(verdict.fruit, verdict.correct) for verdict in verdicts] == [("", False)]
    assert [one.reason for one in work.packer.not_picked] == ["was tried too often"]


class Between(Changing):
    """Takes two that touch for one between them."""

    def changed(self, fruits: list[Fruit]) -> list[Fruit]:
        first, second, *_ = sorted(fruits, key=lambda fruit: fruit.x)
        middle = Fruit((first.x + second.x) / 2, (first.y + second.y) / 2, 0.045, "mushroom", "first")
        return [middle] if self.images == 1 else []


def test_two_fruits_in_one_cup_are_let_go_where_they_were() -> None:
    touching = {"tray/infeed/count": {"min": 2, "max": 2}, "tray/infeed/touching_fraction": 1.0}
    work = Work(cell_with(touching | {"tray/infeed/produce": ["mushroom"]}), perception=Between)
    before = {name: fruit.position for name, fruit in work.scene.truth().fruits.items()}
    work.run()
    assert [pick.outcome for pick in work.picks] == [PickOutcome.GONE]
    for name, fruit in work.scene.truth().fruits.items():
        assert fruit.place is None
        assert np.linalg.norm(fruit.position - before[name]) < 0.03


def test_a_full_container_takes_no_more() -> None:
    six = FEW | RED | {"tray/infeed/count": {"min": 8, "max": 8}}
    cell = cell_with(six, without=("container/apples", "container/mushrooms"))
    work = Work(cell)
    verdicts = work.run()
    assert sum(verdict.correct for verdict in verdicts) == 6
    assert work.packer.packing.free == []
    assert [one.reason for one in work.packer.not_picked] == ["every place that takes it is full, in tomatoes"] * 2


def test_an_empty_tray_is_left_alone() -> None:
    work = Work(cell_with({"tray/infeed/count": {"min": 0, "max": 0}}))
    assert work.run() == []
    assert work.packer.not_picked == ()


class Doubtful(Changing):
    """Knows one kind only, and can't reach one place."""

    def changed(self, fruits: list[Fruit]) -> list[Fruit]:
        unknown = replace(fruits[0], kind="unknown", grade="", ungraded_reason="is of no kind that is known here")
        unsure = replace(fruits[1], confidence=0.4)
        return [unknown, unsure, replace(fruits[2], kind="apple", grade="third")]


def test_what_can_t_be_picked_is_left_with_its_reason() -> None:
    work = Work(cell_with(FEW | RED), perception=Doubtful)
    assert work.run() == []
    assert sorted(one.reason for one in work.packer.not_picked) == [
        "is not sure enough: 0.40 is below 0.70",
        "is of no kind that is known here",
        "no place takes apple of grade 'third'",
    ]


class Blinking(Changing):
    """Gives no picture that can be used, from the second on, for a while or for good."""

    until = 3

    def observe(self, time: float) -> Observation:
        self.images += 1
        if 1 < self.images <= self.until:
            raise PictureError("is black", where="picture", right="check the light")
        self.images -= 1
        return super().observe(time)


class Blind(Blinking):
    until = 99


def test_a_picture_that_can_t_be_used_is_taken_again() -> None:
    work = Work(cell_with(FEW | RED), perception=Blinking)
    work.run()
    assert [pick.outcome for pick in work.picks] == [PickOutcome.PLACED] * 3


def test_a_camera_that_fails_ends_the_work_but_not_the_pick() -> None:
    work = Work(cell_with(FEW | RED), perception=Blind)
    with pytest.raises(PictureError):
        work.run()
    assert work.picks
    assert all(pick.outcome is PickOutcome.PLACED for pick in work.picks)


class Gripping(Observer):
    """Holds the base as soon as the second fruit is carried."""

    def __init__(self, work: Work) -> None:
        self.work, self.carried = work, 0

    def on_phase_change(self, choice: PickChoice, before: PickState, after: PickState) -> None:  # noqa: ARG002  (as all observers)
        self.carried += after.phase is PickPhase.CARRY
        if self.carried == 2:
            self.work.station._plant.grip(0, 500.0)


def test_an_arm_that_is_held_stops_the_rig_with_the_fruit_in_its_cup() -> None:
    work = Work(cell_with(FEW | RED))
    work.packer._observer = Observers(work.evaluator, Gripping(work))
    with pytest.raises(RigStoppedError, match="the rig stopped: "):
        work.run()
    assert [pick.outcome for pick in work.picks] == [PickOutcome.PLACED]
    assert sum(fruit.gripped for fruit in work.scene.truth().fruits.values()) == 1


def test_an_arm_that_holds_something_is_not_sent_home() -> None:
    work = Work(cell_with(FEW | RED))
    steps: list[PickPhase] = []

    class Stopping(Gripping):
        def on_phase_change(self, choice: PickChoice, before: PickState, after: PickState) -> None:  # noqa: ARG002  (as all observers)
            steps.append(after.phase)
            if after.phase is PickPhase.CARRY:
                work.packer._rules = replace(work.packer._rules, settle_time=0.05)

    work.packer._observer = Observers(work.evaluator, Stopping(work))
    work.run()
    assert [pick.outcome for pick in work.picks] == [PickOutcome.STUCK]
    work.packer.finish()
    assert steps[-1] is PickPhase.DONE
    assert sum(fruit.gripped for fruit in work.scene.truth().fruits.values()) == 1
