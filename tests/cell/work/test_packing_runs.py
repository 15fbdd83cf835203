"""Whole runs, seen by the camera: from a description to results, film and sheet."""

from __future__ import annotations

import json
from math import isnan
from pathlib import Path
from typing import Any

import av
import numpy as np
import pytest
from PIL import Image

from layflat.cell import Cell
from layflat.cell.plan.order import PickChoice
from layflat.cell.plan.pick import PickOutcome, PickPhase, PickState
from layflat.cell.scene import Scene
from layflat.cell.scene.camera import SimulatedCamera
from layflat.cell.vision import Calibration
from layflat.cell.work.film_and_sheet import FPS, record_film_and_sheet
from layflat.cell.work.observer import Delivery, Observer, Observers, PickCounter
from layflat.cell.work.results import PackingSummary, count_noun, record_runs, save_results
from layflat.cell.work.run import PackingRun, calibrate_cell, run_packing, run_seeds
from layflat.errors import CameraError, CellError, PictureError, RigStoppedError, StoppedError
from layflat.machine import load
from tests.cell.work.changed_cells import cell_with

FEW: dict[str, Any] = {"tray/infeed/count": {"min": 2, "max": 2}, "tray/infeed/produce": ["tomato"]}
RED = {"produce/tomato/colour/orange/fraction": 1e-6, "produce/tomato/diameter/min": "54 mm"}


@pytest.fixture(scope="module")
def cell() -> Cell:
    return cell_with(FEW | RED)


@pytest.fixture(scope="module")
def run(
    cell: Cell, calibration: Calibration, tmp_path_factory: pytest.TempPathFactory
) -> tuple[PackingRun, Path, list[int]]:
    folder, told = tmp_path_factory.mktemp("run"), list[int]()
    with record_film_and_sheet(folder / "film.mp4", folder / "sheet.png", "few, seed 2", calibration) as show:
        return run_packing(cell, 2, 3, calibration, Observers(PickCounter(told.append), show)), folder, told


def test_what_the_camera_sees_is_packed(run: tuple[PackingRun, Path, list[int]]) -> None:
    found, _, told = run
    assert [len(delivery.picks) for delivery in found.deliveries] == [2, 1]
    figures = PackingSummary(found.deliveries)
    assert (figures.picks, figures.correct, figures.collisions, figures.false_detections) == (3, 3, 0, 0)
    assert figures.release_error_worst_mm < 3.5
    assert figures.vision_error_mm < 1.0
    assert figures.diameter_error < 0.03
    assert told == [1, 2, 3]
    assert found.error is None


def test_a_film_and_a_sheet_are_left(run: tuple[PackingRun, Path, list[int]]) -> None:
    found, folder, _ = run
    with av.open(str(folder / "film.mp4")) as film:
        frames = sum(1 for _ in film.decode(video=0))
    time = sum(delivery.time for delivery in found.deliveries)
    assert frames == pytest.approx(FPS * time, abs=2 + len(found.deliveries))
    sheet = np.asarray(Image.open(folder / "sheet.png"))
    assert sheet.shape[2] == 3
    assert sheet.std() > 20.0


def test_results_are_numbers_and_texts(run: tuple[PackingRun, Path, list[int]], tmp_path: Path) -> None:
    found, _, _ = run
    path = save_results(record_runs(found.cell, [found]), tmp_path / "results.json")
    told = json.loads(path.read_text(encoding="utf-8"))
    assert told["summary"]["correct"] == 3
    assert told["runs"][0]["perception"] == "camera"
    picks = [pick for delivery in told["runs"][0]["deliveries"] for pick in delivery["picks"]]
    assert [pick["truth"]["correct"] for pick in picks] == [True] * 3
    assert {pick["outcome"] for pick in picks} == {"placed"}


def test_same_seed_same_run_also_in_a_study_without_a_camera(cell: Cell) -> None:
    alone = run_packing(cell, 7, 1, None, Observer())
    told: list[int] = []
    others = sorted(run_seeds(cell, [7, 8], 1, None, told.append, processes=2), key=lambda run: run.seed)
    assert record_runs(cell, [alone]) == record_runs(cell, others[:1])
    assert others[1].deliveries[0].seed != alone.deliveries[0].seed
    assert told[-1] == 2
    assert record_runs(cell, others)["runs"][1]["perception"] == "scene"


def test_each_seed_packs_with_its_machine(cell: Cell) -> None:
    names = [f"{cell.machine.name}@{number}" for number in (0, 1, 2)]
    (run,) = run_seeds(cell, [7], 1, None, processes=1, machines=names)
    assert run.cell.machine == load(names[1])
    assert run.cell.machine != cell.machine
    assert [pick.outcome for delivery in run.deliveries for pick in delivery.picks] == [PickOutcome.PLACED]


def test_nothing_to_pick_is_told() -> None:
    empty = run_packing(cell_with({"tray/infeed/count": {"min": 0, "max": 0}}), 0, 3, None, Observer())
    assert isinstance(empty.error, CellError)
    assert "there is nothing in the trays" in str(empty.error)
    figures = PackingSummary(empty.deliveries)
    assert figures.picks == 0
    assert isnan(figures.picks_a_minute)
    unripe = {"produce/tomato/colour/red/fraction": 1e-6, "produce/tomato/colour/orange/fraction": 1.0}
    left = run_packing(cell_with(FEW | unripe), 0, 3, None, Observer())
    assert "nothing can be picked: no place takes tomato of grade 'unripe'" in str(left.error)


def test_a_camera_that_was_moved_does_not_start(calibration: Calibration) -> None:
    moved = cell_with(
        FEW | {"camera/position": ["305 mm", "370 mm", "1500 mm"], "camera/looks_at": ["305 mm", "370 mm", "0 mm"]}
    )
    with pytest.raises(CameraError, match="base markers are off by"):
        run_packing(moved, 0, 1, calibration, Observer())


@pytest.mark.parametrize(("fault", "said"), [({"camera/blur": 6.0}, "blurred"), ({"camera/exposure": 0.02}, "black")])
def test_a_blurred_or_black_picture_is_refused(fault: dict[str, float], said: str, calibration: Calibration) -> None:
    spoilt = cell_with(FEW | fault)
    with pytest.raises(PictureError, match=said):
        calibrate_cell(spoilt)
    with pytest.raises(PictureError, match=said):
        run_packing(spoilt, 0, 1, calibration, Observer())


def test_an_unknown_object_is_left_and_the_others_are_packed(calibration: Calibration) -> None:
    mixed = cell_with(
        FEW | RED | {"tray/infeed/produce": ["tomato", "plum"], "tray/infeed/count": {"min": 4, "max": 4}}
    )
    found = run_packing(mixed, 1, 1, calibration, Observer())
    kinds = {pick.choice.fruit.kind for delivery in found.deliveries for pick in delivery.picks}
    assert kinds == {"tomato"}
    assert all(pick.outcome is PickOutcome.PLACED for delivery in found.deliveries for pick in delivery.picks)
    assert "is of no kind that is known here" in {one.reason for one in found.deliveries[0].not_picked}


class Jamming(Observer):
    """Jams the base of the arm when the second fruit is carried."""

    def __init__(self) -> None:
        self.carried = 0

    def on_delivery_start(self, scene: Scene, camera: SimulatedCamera | None) -> None:  # noqa: ARG002  (as all observers)
        self.scene = scene

    def on_phase_change(self, choice: PickChoice, before: PickState, after: PickState) -> None:  # noqa: ARG002  (as all observers)
        self.carried += after.phase is PickPhase.CARRY
        if self.carried == 2:
            self.scene.model.dof_frictionloss[self.scene.model.joint("large").dofadr[0]] = 1e4


def test_a_rig_that_stops_ends_the_run_and_what_was_done_is_kept(cell: Cell) -> None:
    found = run_packing(cell, 2, 5, None, Jamming())
    assert isinstance(found.error, RigStoppedError)
    assert [len(delivery.picks) for delivery in found.deliveries] == [1]
    assert PackingSummary(found.deliveries).correct == 1
    assert record_runs(cell, [found])["runs"][0]["error"] == str(found.error)


class Counting(Observer):
    """Knows whether a delivery is over."""

    over = False

    def on_delivery_end(self, delivery: Delivery) -> None:  # noqa: ARG002  (as all observers)
        self.over = True


def test_a_delivery_that_can_t_begin_ends_the_run_and_those_before_are_kept(
    cell: Cell, calibration: Calibration, monkeypatch: pytest.MonkeyPatch
) -> None:
    observer, see = Counting(), SimulatedCamera.picture  # a cap comes on the lens after the first delivery
    monkeypatch.setattr(
        SimulatedCamera, "picture", lambda self, *view: see(self, *view) // (50 if observer.over else 1)
    )
    found = run_packing(cell, 3, 4, calibration, observer)
    assert isinstance(found.error, PictureError)
    assert len(found.deliveries) == 1
    assert len(found.deliveries[0].picks) == 2
    assert all(pick.observation.picture is None for pick in found.deliveries[0].picks)


class Impatient(Observer):
    """Presses Ctrl-C when so many fruit have been carried, or are."""

    def __init__(self, most: int) -> None:
        self.carried, self.most = 0, most

    def on_phase_change(self, choice: PickChoice, before: PickState, after: PickState) -> None:  # noqa: ARG002  (as all observers)
        self.carried += after.phase is PickPhase.CARRY
        if self.carried == self.most:
            raise KeyboardInterrupt


def test_what_was_done_before_ctrl_c_is_kept(cell: Cell) -> None:
    for most, kept in ((2, [1]), (3, [2])):  # also in a delivery of which nothing was done yet
        found = run_packing(cell, 2, 5, None, Impatient(most))
        assert isinstance(found.error, StoppedError)
        assert [len(delivery.picks) for delivery in found.deliveries] == kept
        assert PackingSummary(found.deliveries).correct == sum(kept)
    with pytest.raises(KeyboardInterrupt):
        run_packing(cell, 2, 5, None, Impatient(1))


def test_one_is_not_counted_in_the_plural() -> None:
    assert [count_noun(number, "pick") for number in (0, 1, 2)] == ["0 picks", "1 pick", "2 picks"]
    assert [count_noun(number, "try", "tries") for number in (1, 3)] == ["1 try", "3 tries"]
