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
from layflat.cell.work.results import PackingSummary, record_runs
from layflat.cell.work.run import PackingRun, run_packing
from layflat.errors import StoppedError
from layflat.pages.cell.snapshot import RunRequests, RunSnapshot, RunStage
from layflat.pages.cell.watcher import MARKED_IMAGE_TIME, MIN_FRAME_TIME, UNMARKED_IMAGE_TIME, Pace, Watcher

SEED, PICKS = 2, 3


class Shown:
    """Keeps all that is shown, and asks for a stop at a given number of picks of a given delivery."""

    def __init__(self, stop: tuple[int, int] | None = None) -> None:
        self.requests, self.shots = RunRequests.shared(), [RunSnapshot()]
        self.images: list[str] = []
        self.requests.full_speed, self._stop = True, stop

    def show(self, **changes: Any) -> None:
        shot = replace(self.shots[-1], **changes)
        self.shots.append(shot)
        if self._stop is not None and (shot.delivery, shot.figures.picks) == self._stop:
            self.requests.stop = True

    def image(self, name: str, jpeg: bytes) -> None:
        assert jpeg
        self.images.append(name)


@pytest.fixture(scope="module")
def cell(few: Path) -> Cell:
    return load(str(few))


@pytest.fixture(scope="module")
def watched(cell: Cell) -> tuple[PackingRun, Shown]:
    shown = Shown()
    return run_packing(cell, SEED, PICKS, None, Watcher(shown)), shown


def test_the_run_is_that_without_a_page(watched: tuple[PackingRun, Shown], cell: Cell) -> None:
    alone = run_packing(cell, SEED, PICKS, None, Observer())
    assert record_runs(cell, [watched[0]]) == record_runs(cell, [alone])


def test_figures_grow_to_what_the_results_say(watched: tuple[PackingRun, Shown]) -> None:
    run, shown = watched
    figures, found = [shot.figures for shot in shown.shots], PackingSummary(run.deliveries)
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


def test_what_the_arm_does_is_said(watched: tuple[PackingRun, Shown]) -> None:
    _, shown = watched
    said = [shot.doing for shot in shown.shots]
    assert "The arm lifts the fruit." in said
    assert not any("has ended" in one for one in said)
    picking = {(shot.delivery, shot.fruit) for shot in shown.shots if shot.fruit}
    assert len(picking) == PICKS
    assert all("tomato, first, " in fruit and " of tomatoes" in fruit for _, fruit in picking)
    assert {shot.stage for shot in shown.shots[1:]} == {RunStage.PACKS}
    assert not shown.shots[-1].images
    assert shown.images == []


def test_the_last_picks_stand_first(watched: tuple[PackingRun, Shown]) -> None:
    _, shown = watched
    assert [row[0] for row in shown.shots[-1].rows] == ["2.1", "1.2", "1.1"]
    assert shown.shots[-1].rows[0][1] == "tomato, first"


@pytest.mark.parametrize(("at", "kept"), [((1, 1), [1]), ((2, 2), [2]), ((2, 3), [2, 1])])
def test_a_stop_keeps_what_was_done(cell: Cell, at: tuple[int, int], kept: list[int]) -> None:
    run = run_packing(cell, SEED, 9, None, Watcher(Shown(stop=at)))
    assert isinstance(run.error, StoppedError)
    assert [len(delivery.picks) for delivery in run.deliveries] == kept
    assert PackingSummary(run.deliveries).correct == sum(kept)


def test_a_stop_before_the_first_pick_leaves_nothing(cell: Cell) -> None:
    with pytest.raises(KeyboardInterrupt):
        run_packing(cell, SEED, 9, None, Watcher(Shown(stop=(1, 0))))


class Lens:
    """In place of a camera."""

    def picture(self, view: str) -> Picture:
        assert view == "overview"
        return np.zeros((9, 12, 3), np.uint8)


def test_images_are_as_few_as_can_be_seen(cell: Cell) -> None:
    now = 50.0
    shown = Shown()
    shown.requests.full_speed = False
    watcher = Watcher(shown, Pace(lambda: now, time.sleep))
    scene, lens = Scene(cell, 0), Lens()
    watcher.on_delivery_start(scene, lens)  # type: ignore[arg-type]  # as a camera does
    observation = Observation(0.0, (), np.zeros((9, 12, 3), np.uint8))
    for _ in range(20):
        watcher.on_control_cycle(0.0)
        watcher.on_image(observation)
    assert shown.images == ["overview", "camera"]
    now += MIN_FRAME_TIME
    watcher.on_control_cycle(0.0)
    assert shown.images == ["overview", "camera", "overview"]
    now += max(UNMARKED_IMAGE_TIME, MARKED_IMAGE_TIME)
    watcher.on_control_cycle(0.0)
    assert shown.images[3:] == ["overview", "camera"]
    assert shown.shots[-1].fruit_counts == "nothing"
