"""LeRobot data sets of logs: the numbers of a log's own samples, and what stands in the way."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray

import layflat as lf
from layflat.errors import InputError, OutputError
from layflat.identify.logs import read_table
from layflat.sim.dataset import save_run
from tests.identify.logs.recordings import run as one_joint
from tests.lerobot import reading

MOVES = [
    ("0 s", {"large": "0 deg"}),
    ("0.3 s", {"large": "20 deg"}),
    ("0.9 s", {"small": "-15 deg"}),
    ("1.4 s", {"large": "-5 deg"}),
]


@pytest.fixture(scope="module")
def run() -> xarray.Dataset:
    return lf.rollout("paper-arm", MOVES, duration="2 s")


def sensed(run: xarray.Dataset, *names: str) -> Any:
    return np.concatenate([run[name].to_numpy() for name in names], axis=1).astype(np.float32)


def rows(folder: Path, name: str) -> Any:
    return reading.frames(folder)[name].astype(np.float32)


def test_a_run_at_its_own_rate_keeps_every_number(run: xarray.Dataset, tmp_path: Path) -> None:
    done = lf.write_lerobot(run, tmp_path / "data", task="move", machine="paper-arm")
    assert (done.fps, done.episodes, done.frames) == (200, 1, run.sizes["time"])
    state = sensed(run, "measured_angle", "measured_pressure")
    np.testing.assert_array_equal(rows(tmp_path / "data", "observation.state"), state)
    np.testing.assert_array_equal(rows(tmp_path / "data", "action"), sensed(run, "demand"))
    info = reading.info(tmp_path / "data")
    assert info["robot_type"] == "paper-arm"
    feature = info["features"]["observation.state"]
    assert dict(zip(feature["names"], feature["units"], strict=True)) == {
        "angle.large": "rad", "angle.small": "rad", "measured_pressure.large": "Pa", "measured_pressure.small": "Pa",
    }  # fmt: skip
    assert info["features"]["action"]["units"] == ["rad", "rad"]


def test_lerobots_own_loader_gives_a_runs_numbers(run: xarray.Dataset, tmp_path: Path) -> None:
    lf.write_lerobot([run, run], tmp_path / "data", task=["there", "back"], fps=50, action="voltage")
    loaded = reading.load(tmp_path / "data", tmp_path / "loaded.npz")
    state = sensed(run, "measured_angle", "measured_pressure")[::4]
    np.testing.assert_array_equal(loaded["observation.state"], np.concatenate([state, state]))
    np.testing.assert_array_equal(loaded["action"], np.tile(sensed(run, "voltage")[::4], (2, 1)))
    assert loaded["task"].tolist() == ["there"] * len(state) + ["back"] * len(state)
    np.testing.assert_array_equal(loaded["timestamp"], np.tile((np.arange(len(state)) / 50).astype(np.float32), 2))


def test_a_file_its_table_and_a_data_set_give_the_same(run: xarray.Dataset, tmp_path: Path) -> None:
    path = save_run(run, tmp_path / "run.nc")
    sources: list[Any] = [path, str(path), read_table(path), lf.open_run(path), lambda: read_table(path)]
    done = lf.write_lerobot(sources, tmp_path / "data", task="move", fps=40)
    assert done.episodes == len(sources)
    frames = rows(tmp_path / "data", "observation.state").reshape(len(sources), -1, 4)
    assert all((one == frames[0]).all() for one in frames)


def test_another_rate_interpolates_sensors_and_holds_commands(run: xarray.Dataset, tmp_path: Path) -> None:
    lf.write_lerobot(run, tmp_path / "data", task="move", fps=30)
    grid, time = np.arange(61) / 30, run["time"].to_numpy()
    angle = run["measured_angle"].to_numpy()
    frames = rows(tmp_path / "data", "observation.state")
    for joint in range(2):
        np.testing.assert_allclose(frames[:, joint], np.interp(grid, time, angle[:, joint]), rtol=1e-6, atol=1e-9)
    held = run["demand"].to_numpy()[np.searchsorted(time, grid + 1e-9, side="right") - 1]
    np.testing.assert_allclose(rows(tmp_path / "data", "action"), held, rtol=1e-7)


def test_an_episode_a_move_begins_with_a_change_of_the_demand(run: xarray.Dataset, tmp_path: Path) -> None:
    done = lf.write_lerobot(run, tmp_path / "data", task="move", episodes="move")
    changes = np.flatnonzero(np.any(np.diff(run["demand"].to_numpy(), axis=0) != 0.0, axis=1)) + 1
    assert done.episodes == len(changes) == 3
    lengths = np.diff([*changes, run.sizes["time"]])
    assert [episode["length"] for episode in reading.episodes(tmp_path / "data")] == lengths.tolist()
    frames = rows(tmp_path / "data", "action")
    np.testing.assert_array_equal(frames, sensed(run, "demand")[changes[0] :])
    assert all(reading.frames(tmp_path / "data")["timestamp"][[0, *np.cumsum(lengths)[:-1]]] == 0.0)


def test_a_demand_that_ramps_is_one_move(run: xarray.Dataset, tmp_path: Path) -> None:
    ramp = np.interp(run["time"], [0.2, 0.5, 1.0, 1.3], [0.0, 0.3, 0.3, -0.1])
    ramped = run.assign(demand=run["demand"] * 0.0 + xarray.DataArray(ramp, dims="time"))
    assert lf.write_lerobot(ramped, tmp_path / "data", task="move", episodes="move").episodes == 2


def test_a_gap_divides_a_log(run: xarray.Dataset, tmp_path: Path) -> None:
    cut = run.isel(time=[*range(100), *range(160, 401)])
    done = lf.write_lerobot(cut, tmp_path / "data", task="move", fps=200)
    assert [episode["length"] for episode in reading.episodes(tmp_path / "data")] == [100, 241]
    np.testing.assert_array_equal(rows(tmp_path / "data", "action"), sensed(cut, "demand"))
    assert done.frames == 341


def test_a_bench_log_goes_by_its_mapping(tmp_path: Path) -> None:
    joint = one_joint().sel(joint="small")
    columns: list[Any] = [1e3 * joint["time"], np.degrees(joint["measured_angle"]), joint["voltage"]]
    np.savetxt(tmp_path / "bench.csv", np.stack(columns, 1), delimiter=",", header="t,theta,valve", comments="")
    entries = [("theta", "angle", "deg"), ("valve", "voltage", "V")]
    text = '[time]\ncolumn = "t"\nunit = "ms"\n' + "".join(
        f'[[column]]\nfrom = "{column}"\nsignal = "{signal}"\nunit = "{unit}"\njoint = "small"\n'
        for column, signal, unit in entries
    )
    (tmp_path / "m.toml").write_text(text)
    path, mapping = tmp_path / "bench.csv", tmp_path / "m.toml"
    lf.write_lerobot(path, tmp_path / "data", task="move", mapping=mapping, action="voltage")
    frames = reading.frames(tmp_path / "data")
    np.testing.assert_allclose(frames["observation.state"], joint["measured_angle"], rtol=1e-6, atol=1e-9)
    assert reading.info(tmp_path / "data")["features"]["observation.state"]["shape"] == [1]
    with pytest.raises(InputError, match=r"bench.csv: has no demand, only angle.*; map a column to demand"):
        lf.write_lerobot(path, tmp_path / "more", task="move", mapping=mapping, episodes="move", action="voltage")


def without(run: xarray.Dataset, *names: str) -> xarray.Dataset:
    return run.drop_vars(names)


@pytest.mark.parametrize(
    ("change", "asked", "said"),
    [
        (lambda run: without(run, "demand"), {}, "has no demand, only voltage, angle, measured_pressure"),
        (lambda run: without(run, "measured_angle", "angle"), {}, "has no angle, only pressure_a, pressure_b, "),
        (lambda run: run, {"fps": 201 * 2}, "fps: 402 frames a second are more than the 200 samples a second"),
        (lambda run: run, {"fps": 0}, "fps: 0 is no number of frames a second; give a whole number from 1 to 1000"),
        (lambda run: run, {"fps": 29.97}, "fps: 29.97 is no number of frames a second"),
        (lambda run: run, {"task": " "}, "task: is empty; give what the machine does"),
        (lambda run: run, {"task": ["a", "b"]}, "task: 2 are not as many as 1 logs; give one for all logs"),
        (lambda run: run, {"action": "torque"}, "action: 'torque' is unknown; give 'demand' or 'voltage'"),
        (lambda run: run, {"episodes": "day"}, "episodes: 'day' is unknown; give 'log' or 'move'"),
        (lambda run: run, {"machine": "paper-small-joint"}, "'large' is not a joint of the machine"),
        (lambda run: run.assign(demand=run["demand"].where(run["joint"] == "small")), {}, "has no demand.large"),
        (lambda run: run.assign_coords(time=run["time"] * 45.45), {}, "has 4.4 samples a second, and LeRobot"),
    ],
)
def test_what_makes_no_data_set_is_refused(
    run: xarray.Dataset, tmp_path: Path, change: Any, asked: dict[str, Any], said: str
) -> None:
    with pytest.raises(InputError, match=re.escape(said)):
        lf.write_lerobot(change(run), tmp_path / "data", **{"task": "move", **asked})
    assert not (tmp_path / "data").exists()


def test_a_log_of_another_machine_is_refused_and_nothing_is_left(run: xarray.Dataset, tmp_path: Path) -> None:
    said = "paper-small-joint-fast: lacks angle.large, unlike paper-arm; write logs of one machine with the same"
    with pytest.raises(InputError, match=said):
        lf.write_lerobot([run, one_joint()], tmp_path / "data", task="move")
    with pytest.raises(InputError, match="logs: are none; give one or more"):
        lf.write_lerobot([], tmp_path / "data", task="move")
    assert list(tmp_path.iterdir()) == []


def test_a_folder_that_holds_something_is_left_alone(run: xarray.Dataset, tmp_path: Path) -> None:
    (tmp_path / "data").mkdir()
    (tmp_path / "data" / "mine.txt").write_text("mine")
    with pytest.raises(OutputError, match=r"data: is not empty, it holds 'mine.txt'; give a new folder"):
        lf.write_lerobot(run, tmp_path / "data", task="move")
    with pytest.raises(OutputError, match=r"mine.txt: is no folder"):
        lf.write_lerobot(run, tmp_path / "data" / "mine.txt", task="move")
    (tmp_path / "empty").mkdir()
    assert lf.write_lerobot(run, tmp_path / "empty", task="move").episodes == 1
