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
from layflat.cell.plan.order import Choice
from layflat.cell.plan.pick import Outcome, Phase, State
from layflat.cell.scene import Scene
from layflat.cell.scene.camera import SimulatedCamera
from layflat.cell.vision import Calibration
from layflat.cell.work.film_and_sheet import FPS, film_and_sheet
from layflat.cell.work.observer import Observer, Observers, PickCounter
from layflat.cell.work.records import Delivery
from layflat.cell.work.results import Summary, as_dict, counted, save
from layflat.cell.work.run import Run, calibrated, packed, repeated
from layflat.errors import CameraError, CellError, PictureError, RigStoppedError, StoppedError
from layflat.machine import load
from tests.cell.work.changed_cells import cell_with

FEW: dict[str, Any] = {"tray/infeed/count": {"least": 2, "most": 2}, "tray/infeed/produce": ["tomato"]}
RED = {"produce/tomato/colour/orange/share": 1e-6, "produce/tomato/diameter/least": "54 mm"}


@pytest.fixture(scope="module")
def cell() -> Cell:
    return cell_with(FEW | RED)


@pytest.fixture(scope="module")
def run(cell: Cell, calibration: Calibration, tmp_path_factory: pytest.TempPathFactory) -> tuple[Run, Path, list[int]]:
    folder, told = tmp_path_factory.mktemp("run"), list[int]()
    with film_and_sheet(folder / "film.mp4", folder / "sheet.png", "few, seed 2", calibration) as show:
        return packed(cell, 2, 3, calibration, Observers(PickCounter(told.append), show)), folder, told


def test_what_the_camera_sees_is_packed(run: tuple[Run, Path, list[int]]) -> None:
    found, _, told = run
    assert [len(delivery.picks) for delivery in found.deliveries] == [2, 1]
    figures = Summary(found.deliveries)
    assert (figures.picks, figures.correct, figures.collisions, figures.false_detections) == (3, 3, 0, 0)
    assert figures.release_error_worst_mm < 3.5
    assert figures.vision_error_mm < 1.0
    assert figures.diameter_error < 0.03
    assert told == [1, 2, 3]
    assert found.error is None


def test_a_film_and_a_sheet_are_left(run: tuple[Run, Path, list[int]]) -> None:
    found, folder, _ = run
    with av.open(str(folder / "film.mp4")) as film:
        frames = sum(1 for _ in film.decode(video=0))
    time = sum(delivery.time for delivery in found.deliveries)
    assert frames == pytest.approx(FPS * time, abs=2 + len(found.deliveries))
    sheet = np.asarray(Image.open(folder / "sheet.png"))
    assert sheet.shape[2] == 3
    assert sheet.std() > 20.0


def test_results_are_numbers_and_texts(run: tuple[Run, Path, list[int]], tmp_path: Path) -> None:
    found, _, _ = run
    path = save(as_dict(found.cell, [found]), tmp_path / "results.json")
    told = json.loads(path.read_text(encoding="utf-8"))
    assert told["summary"]["correct"] == 3
    assert told["runs"][0]["perception"] == "camera"
    picks = [pick for delivery in told["runs"][0]["deliveries"] for pick in delivery["picks"]]
    assert [pick["truth"]["correct"] for pick in picks] == [True] * 3
    assert {pick["outcome"] for pick in picks} == {"placed"}


def test_same_seed_same_run_also_in_a_study_without_a_camera(cell: Cell) -> None:
    alone = packed(cell, 7, 1, None, Observer())
    told: list[int] = []
    others = sorted(repeated(cell, [7, 8], 1, None, told.append, processes=2), key=lambda run: run.seed)
    assert as_dict(cell, [alone]) == as_dict(cell, others[:1])
    assert others[1].deliveries[0].seed != alone.deliveries[0].seed
    assert told[-1] == 2
    assert as_dict(cell, others)["runs"][1]["perception"] == "scene"


def test_each_seed_packs_with_its_machine(cell: Cell) -> None:
    names = [f"{cell.machine.name}@{number}" for number in (0, 1, 2)]
    (run,) = repeated(cell, [7], 1, None, processes=1, machines=names)
    assert run.cell.machine == load(names[1])
    assert run.cell.machine != cell.machine
    assert [pick.outcome for delivery in run.deliveries for pick in delivery.picks] == [Outcome.PLACED]


def test_nothing_to_pick_is_told() -> None:
    empty = packed(cell_with({"tray/infeed/count": {"least": 0, "most": 0}}), 0, 3, None, Observer())
    assert isinstance(empty.error, CellError)
    assert "there is nothing in the trays" in str(empty.error)
    figures = Summary(empty.deliveries)
    assert figures.picks == 0
    assert isnan(figures.picks_a_minute)
    unripe = {"produce/tomato/colour/red/share": 1e-6, "produce/tomato/colour/orange/share": 1.0}
    left = packed(cell_with(FEW | unripe), 0, 3, None, Observer())
    assert "nothing can be picked: no place takes tomato of grade 'unripe'" in str(left.error)


def test_a_camera_that_was_moved_does_not_start(calibration: Calibration) -> None:
    moved = cell_with(
        FEW | {"camera/position": ["305 mm", "370 mm", "1500 mm"], "camera/looks_at": ["305 mm", "370 mm", "0 mm"]}
    )
    with pytest.raises(CameraError, match="base markers are off by"):
        packed(moved, 0, 1, calibration, Observer())


@pytest.mark.parametrize(("fault", "said"), [({"camera/blur": 6.0}, "blurred"), ({"camera/exposure": 0.02}, "black")])
def test_a_blurred_or_black_picture_is_refused(fault: dict[str, float], said: str, calibration: Calibration) -> None:
    spoilt = cell_with(FEW | fault)
    with pytest.raises(PictureError, match=said):
        calibrated(spoilt)
    with pytest.raises(PictureError, match=said):
        packed(spoilt, 0, 1, calibration, Observer())


def test_an_unknown_object_is_left_and_the_others_are_packed(calibration: Calibration) -> None:
    mixed = cell_with(
        FEW | RED | {"tray/infeed/produce": ["tomato", "plum"], "tray/infeed/count": {"least": 4, "most": 4}}
    )
    found = packed(mixed, 1, 1, calibration, Observer())
    kinds = {pick.choice.fruit.kind for delivery in found.deliveries for pick in delivery.picks}
    assert kinds == {"tomato"}
    assert all(pick.outcome is Outcome.PLACED for delivery in found.deliveries for pick in delivery.picks)
    assert "is of no kind that is known here" in {one.reason for one in found.deliveries[0].not_picked}


class Jamming(Observer):
    """Jams the base of the arm when the second fruit is carried."""

    def __init__(self) -> None:
        self.carried = 0

    def begins(self, scene: Scene, camera: SimulatedCamera | None) -> None:  # noqa: ARG002  (as all observers)
        self.scene = scene

    def phase(self, choice: Choice, before: State, after: State) -> None:  # noqa: ARG002  (as all observers)
        self.carried += after.phase is Phase.CARRY
        if self.carried == 2:
            self.scene.model.dof_frictionloss[self.scene.model.joint("large").dofadr[0]] = 1e4


def test_a_rig_that_stops_ends_the_run_and_what_was_done_is_kept(cell: Cell) -> None:
    found = packed(cell, 2, 5, None, Jamming())
    assert isinstance(found.error, RigStoppedError)
    assert [len(delivery.picks) for delivery in found.deliveries] == [1]
    assert Summary(found.deliveries).correct == 1
    assert as_dict(cell, [found])["runs"][0]["error"] == str(found.error)


class Counting(Observer):
    """Knows whether a delivery is over."""

    over = False

    def ends(self, delivery: Delivery) -> None:  # noqa: ARG002  (as all observers)
        self.over = True


def test_a_delivery_that_can_t_begin_ends_the_run_and_those_before_are_kept(
    cell: Cell, calibration: Calibration, monkeypatch: pytest.MonkeyPatch
) -> None:
    observer, see = Counting(), SimulatedCamera.picture  # a cap comes on the lens after the first delivery
    monkeypatch.setattr(
        SimulatedCamera, "picture", lambda self, *view: see(self, *view) // (50 if observer.over else 1)
    )
    found = packed(cell, 3, 4, calibration, observer)
    assert isinstance(found.error, PictureError)
    assert len(found.deliveries) == 1
    assert len(found.deliveries[0].picks) == 2
    assert all(pick.observation.picture is None for pick in found.deliveries[0].picks)


class Impatient(Observer):
    """Presses Ctrl-C when so many fruit have been carried, or are."""

    def __init__(self, most: int) -> None:
        self.carried, self.most = 0, most

    def phase(self, choice: Choice, before: State, after: State) -> None:  # noqa: ARG002  (as all observers)
        self.carried += after.phase is Phase.CARRY
        if self.carried == self.most:
            raise KeyboardInterrupt


def test_what_was_done_before_ctrl_c_is_kept(cell: Cell) -> None:
    for most, kept in ((2, [1]), (3, [2])):  # also in a delivery of which nothing was done yet
        found = packed(cell, 2, 5, None, Impatient(most))
        assert isinstance(found.error, StoppedError)
        assert [len(delivery.picks) for delivery in found.deliveries] == kept
        assert Summary(found.deliveries).correct == sum(kept)
    with pytest.raises(KeyboardInterrupt):
        packed(cell, 2, 5, None, Impatient(1))


def test_one_is_not_counted_in_the_plural() -> None:
    assert [counted(number, "pick") for number in (0, 1, 2)] == ["0 picks", "1 pick", "2 picks"]
    assert [counted(number, "try", "tries") for number in (1, 3)] == ["1 try", "3 tries"]
