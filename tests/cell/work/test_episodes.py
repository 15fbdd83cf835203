"""Picks as episodes of a LeRobot data set: the numbers of the control loop, the pictures of the scene."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from layflat.arrays import Array, Picture
from layflat.cell import Cell
from layflat.cell.perception import Observation
from layflat.cell.plan.order import Fruit
from layflat.cell.scene import Scene
from layflat.cell.scene.camera import SimulatedCamera
from layflat.cell.vision import Calibration
from layflat.cell.work.episodes import ACTION_KEY, STATE_KEY, cycles_per_frame, record_episodes
from layflat.cell.work.observer import Observer, Observers, Pick
from layflat.cell.work.results import record_runs
from layflat.cell.work.run import run_packing
from layflat.errors import CellError, InputError, RigStoppedError
from layflat.rig.record import RowLayout
from tests.cell.work.changed_cells import cell_with
from tests.cell.work.test_packing_runs import FEW, RED, Jamming
from tests.lerobot import reading

FPS = 5
OVERVIEW = "observation.images.overview"


@pytest.fixture(scope="module")
def cell() -> Cell:
    return cell_with(FEW | RED)


class Watching(Observer):
    """Keeps what the control loop recorded in every fortieth cycle of each pick, and an image of its first one."""

    def __init__(self) -> None:
        self.rows: list[list[Array]] = []
        self.first_views: list[Picture] = []
        self.picks: list[Pick] = []
        self._cycles: int | None = None

    def on_delivery_start(self, scene: Scene, camera: SimulatedCamera | None) -> None:
        self._scene, self._camera = scene, camera

    def on_pick_start(self, fruit: Fruit, observation: Observation) -> None:  # noqa: ARG002
        self.rows.append([])
        self._cycles = 0

    def on_cycle_record(self, layout: RowLayout, row: Array) -> None:
        self.layout = layout
        if self._cycles is None:
            return
        if self._cycles == 0 and self._camera is not None:
            self.first_views.append(self._camera.picture("overview"))
        if self._cycles % 40 == 0:
            lift = self._scene.cell.lift.clearance - np.array([self._scene.stroke, self._scene.lift.demand])
            cup = self._scene.cup
            self.rows[-1].append(np.concatenate([row, [lift[0], cup.vacuum, lift[1], cup.on]]))
        self._cycles += 1

    def on_pick_end(self, pick: Pick) -> None:
        self.picks.append(pick)
        self._cycles = None


def check_numbers(folder: Path, watching: Watching) -> None:
    frames, layout, rows = reading.frames(folder), watching.layout, np.concatenate(watching.rows)
    own, (height, vacuum, lift, suction) = rows[:, : layout.width], rows[:, layout.width :].T
    state = [layout.named(own, "measured_angle"), layout.named(own, "measured_pressure")]
    expected = np.concatenate([*state, height[:, None], vacuum[:, None]], axis=1)
    np.testing.assert_array_equal(frames[STATE_KEY].astype(np.float32), expected.astype(np.float32))
    command = np.concatenate([layout.named(own, "demand"), lift[:, None], suction[:, None]], axis=1)
    np.testing.assert_array_equal(frames[ACTION_KEY].astype(np.float32), command.astype(np.float32))
    assert set(command[:, -1]) == {0.0, 1.0}


def test_picks_are_episodes_and_the_run_is_the_same(cell: Cell, calibration: Calibration, tmp_path: Path) -> None:
    watching, folder = Watching(), tmp_path / "data"
    with record_episodes(folder, cell, FPS, pictures=True) as recorder:
        found = run_packing(cell, 2, 2, calibration, Observers(watching, recorder))
    assert record_runs(cell, [found]) == record_runs(cell, [run_packing(cell, 2, 2, calibration, Observer())])
    check_numbers(folder, watching)
    episodes = reading.episodes(folder)
    assert [episode["outcome"] for episode in episodes] == ["placed"] * 2
    for episode, pick, view in zip(episodes, watching.picks, watching.first_views, strict=True):
        assert episode["length"] == pytest.approx(FPS * (pick.end - pick.begin), abs=2.0)
        place = pick.choice.place
        task = f"pack the tomato of grade {pick.choice.fruit.grade} into place {place.name} of {place.container}"
        assert episode["tasks"] == [task]
        shown = reading.pictures(folder, OVERVIEW, episode)
        assert len(shown) == episode["length"]
        assert np.abs(shown[0].astype(int) - view).mean() < 3.0
    features = reading.info(folder)["features"]
    assert features["observation.images.camera"]["shape"] == [cell.camera.height, cell.camera.width, 3]
    assert features[STATE_KEY]["names"][-2:] == ["lift.height", "cup.vacuum"]
    assert features[STATE_KEY]["units"] == ["rad", "rad", "Pa", "Pa", "m", "Pa"]
    loaded = reading.load(folder, tmp_path / "loaded.npz", every=5)
    frames = reading.frames(folder)
    np.testing.assert_array_equal(loaded[STATE_KEY], frames[STATE_KEY][::5].astype(np.float32))
    assert loaded[OVERVIEW].shape[1:] == (3, cell.overview.height, cell.overview.width)


def test_without_images_there_are_the_numbers(cell: Cell, tmp_path: Path) -> None:
    watching = Watching()
    with record_episodes(tmp_path / "data", cell, FPS, pictures=False) as recorder:
        run_packing(cell, 2, 2, None, Observers(watching, recorder))
    check_numbers(tmp_path / "data", watching)
    assert reading.info(tmp_path / "data")["video_path"] is None
    assert not (tmp_path / "data" / "videos").exists()


def test_of_a_run_that_ends_early_the_whole_picks_are_kept(cell: Cell, tmp_path: Path) -> None:
    with record_episodes(tmp_path / "data", cell, FPS, pictures=False) as recorder:
        found = run_packing(cell, 2, 5, None, Observers(Jamming(), recorder))
    assert isinstance(found.error, RigStoppedError)
    assert len(reading.episodes(tmp_path / "data")) == 1


class Interrupting(Observer):
    def on_pick_start(self, fruit: Fruit, observation: Observation) -> None:  # noqa: ARG002
        raise KeyboardInterrupt


def test_ctrl_c_before_the_end_of_a_pick_leaves_nothing(cell: Cell, tmp_path: Path) -> None:
    def begin() -> None:
        with record_episodes(tmp_path / "data", cell, FPS, pictures=False) as recorder:
            run_packing(cell, 2, 5, None, Observers(recorder, Interrupting()))

    with pytest.raises(KeyboardInterrupt):
        begin()
    assert list(tmp_path.iterdir()) == []


def test_a_run_without_a_pick_leaves_no_data_set(tmp_path: Path) -> None:
    plums = cell_with(FEW | {"tray/infeed/produce": ["plum"]})
    with record_episodes(tmp_path / "data", plums, FPS, pictures=False) as recorder:
        found = run_packing(plums, 0, 1, None, recorder)
    assert isinstance(found.error, CellError)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("fps", "said"),
    [
        (30, r"fps: 30 frames a second fall between control cycles of 5 ms; give 1, 2, 4, 5, 8, 10, .*, 100, 200$"),
        (400, "fps: 400 frames a second fall between control cycles of 5 ms"),
        (0, "fps: 0 is no number of frames a second"),
    ],
)
def test_frames_that_fall_between_control_cycles_are_refused(fps: Any, said: str) -> None:
    with pytest.raises(InputError, match=said):
        cycles_per_frame(5e-3, fps)


@pytest.mark.parametrize(("cycle", "fps", "cycles"), [(5e-3, 200, 1), (2e-3, 20, 25), (4e-3, 25, 10)])
def test_a_frame_is_a_whole_number_of_cycles(cycle: float, fps: int, cycles: int) -> None:
    assert cycles_per_frame(cycle, fps) == cycles


def test_a_cycle_that_fits_no_rate_is_told() -> None:
    with pytest.raises(InputError, match=r"between control cycles of 3 ms; give a machine with another cycle"):
        cycles_per_frame(3e-3, 10)
