"""What a run shows as it goes, without a page; the scene's truth stands in for the camera."""

import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from layflat.arrays import Picture
from layflat.cell import Cell, load
from layflat.cell.perception import Observation
from layflat.cell.scene import Scene
from layflat.cell.work.observer import Observer
from layflat.cell.work.results import Summary, as_dict
from layflat.cell.work.run import Run, packed
from layflat.errors import StoppedError
from layflat.pages.cell.frames import FRAME, MARKED, UNMARKED
from layflat.pages.cell.snapshot import Requests, Snapshot, Stage
from layflat.pages.cell.watcher import Pace, Watcher

SEED, PICKS = 2, 3


class Shown:
    """Keeps all that is shown, and asks for a stop at a given number of picks of a given delivery."""

    def __init__(self, stop: tuple[int, int] | None = None) -> None:
        self.asked, self.shots = Requests(), [Snapshot()]
        self.images: list[str] = []
        self.asked.fast, self._stop = True, stop

    def show(self, **changes: Any) -> None:
        shot = replace(self.shots[-1], **changes)
        self.shots.append(shot)
        if self._stop is not None and (shot.delivery, shot.figures.picks) == self._stop:
            self.asked.stop = True

    def image(self, name: str, jpeg: bytes) -> None:
        assert jpeg
        self.images.append(name)


@pytest.fixture(scope="module")
def cell(few: Path) -> Cell:
    return load(str(few))


@pytest.fixture(scope="module")
def watched(cell: Cell) -> tuple[Run, Shown]:
    shown = Shown()
    return packed(cell, SEED, PICKS, None, Watcher(shown)), shown


def test_the_run_is_that_without_a_page(watched: tuple[Run, Shown], cell: Cell) -> None:
    alone = packed(cell, SEED, PICKS, None, Observer())
    assert as_dict(cell, [watched[0]]) == as_dict(cell, [alone])


def test_figures_grow_to_what_the_results_say(watched: tuple[Run, Shown]) -> None:
    run, shown = watched
    figures, found = [shot.figures for shot in shown.shots], Summary(run.deliveries)
    picks = [one.picks for one in figures]
    assert picks == sorted(picks)
    assert set(picks) == {0, 1, 2, 3}
    assert all(one.results["correct"] == one.picks for one in figures), "known before a delivery is over"
    last = figures[-1]
    assert (last.picks, last.results["correct"], last.collisions) == (found.picks, found.correct, found.collisions)
    assert last.false_detections == found.false_detections
    assert last.air_each == pytest.approx(found.air)
    assert last.picks_a_minute == pytest.approx(found.picks_a_minute)
    times = [shot.time for shot in shown.shots]
    assert times == sorted(times)
    assert times[-1] == pytest.approx(sum(delivery.time for delivery in run.deliveries))


def test_what_the_arm_does_is_said(watched: tuple[Run, Shown]) -> None:
    _, shown = watched
    said = [shot.doing for shot in shown.shots]
    assert "The arm lifts the fruit." in said
    assert not any("has ended" in one for one in said)
    picking = {(shot.delivery, shot.fruit) for shot in shown.shots if shot.fruit}
    assert len(picking) == PICKS
    assert all("tomato, first, " in fruit and " of tomatoes" in fruit for _, fruit in picking)
    assert {shot.stage for shot in shown.shots[1:]} == {Stage.PACKS}
    assert not shown.shots[-1].images
    assert shown.images == []


def test_the_last_picks_stand_first(watched: tuple[Run, Shown]) -> None:
    _, shown = watched
    assert [row[0] for row in shown.shots[-1].rows] == ["2.1", "1.2", "1.1"]
    assert shown.shots[-1].rows[0][1] == "tomato, first"


@pytest.mark.parametrize(("at", "kept"), [((1, 1), [1]), ((2, 2), [2]), ((2, 3), [2, 1])])
def test_a_stop_keeps_what_was_done(cell: Cell, at: tuple[int, int], kept: list[int]) -> None:
    run = packed(cell, SEED, 9, None, Watcher(Shown(stop=at)))
    assert isinstance(run.error, StoppedError)
    assert [len(delivery.picks) for delivery in run.deliveries] == kept
    assert Summary(run.deliveries).correct == sum(kept)


def test_a_stop_before_the_first_pick_leaves_nothing(cell: Cell) -> None:
    with pytest.raises(KeyboardInterrupt):
        packed(cell, SEED, 9, None, Watcher(Shown(stop=(1, 0))))


class Lens:
    """In place of a camera."""

    def picture(self, view: str) -> Picture:
        assert view == "overview"
        return np.zeros((9, 12, 3), np.uint8)


def test_images_are_as_few_as_can_be_seen(cell: Cell) -> None:
    now = 50.0
    shown = Shown()
    shown.asked.fast = False
    watcher = Watcher(shown, Pace(lambda: now, time.sleep))
    scene, lens = Scene(cell, 0), Lens()
    watcher.begins(scene, lens)  # type: ignore[arg-type]  # as a camera does
    observation = Observation(0.0, (), np.zeros((9, 12, 3), np.uint8))
    for _ in range(20):
        watcher.cycle(0.0)
        watcher.observed(observation)
    assert shown.images == ["overview", "camera"]
    now += FRAME
    watcher.cycle(0.0)
    assert shown.images == ["overview", "camera", "overview"]
    now += max(UNMARKED, MARKED)
    watcher.cycle(0.0)
    assert shown.images[3:] == ["overview", "camera"]
    assert shown.shots[-1].seen == "nothing"
