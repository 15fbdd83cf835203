"""LeRobot data sets, read back by the documented layout and, where it is installed, by LeRobot's own loader."""

from __future__ import annotations

import re
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from layflat.errors import InputError, MissingExtraError, OutputError
from layflat.lerobot import CameraFeature, EpisodeWriter, VectorFeature, layout, rows, video
from tests.lerobot import reading

STATE = VectorFeature(("angle.large", "angle.small"), ("rad", "rad"))
ACTION = VectorFeature(("voltage",), ("V",))
VECTORS = {"observation.state": STATE, "action": ACTION}
EYE = "observation.images.eye"
FPS = 20


def values(frames: int, seed: int) -> dict[str, NDArray[np.float64]]:
    random = np.random.default_rng(seed)
    return {"observation.state": random.normal(size=(frames, 2)), "action": random.normal(size=(frames, 1))}


def moving(count: int, shift: int) -> Iterator[NDArray[np.uint8]]:
    """A red square goes over grey."""
    for k in range(count):
        picture = np.full((90, 120, 3), 140, np.uint8)
        picture[30:60, shift + 2 * k : shift + 2 * k + 30] = 200, 20, 10
        yield picture


LENGTHS, TASKS = (12, 7, 15), ("open", "close", "open")


def write(folder: Path, *, cameras: bool = True) -> None:
    seen = {EYE: CameraFeature(90, 120)} if cameras else {}
    with EpisodeWriter(folder, FPS, "arm", VECTORS, seen) as data:
        for number, (length, task) in enumerate(zip(LENGTHS, TASKS, strict=True)):
            if cameras:
                for picture in moving(length, 10 * number):
                    data.add_picture(EYE, picture)
            data.add_episode(task, values(length, number), {"outcome": f"result {number}"})
    assert (data.summary.episodes, data.summary.frames, data.summary.tasks) == (3, sum(LENGTHS), 2)


def expected(name: str) -> NDArray[np.float32]:
    return np.concatenate([values(length, number)[name] for number, length in enumerate(LENGTHS)]).astype(np.float32)


def test_frames_are_those_that_were_added_on_an_exact_grid(tmp_path: Path) -> None:
    write(tmp_path / "data", cameras=False)
    frames = reading.frames(tmp_path / "data")
    np.testing.assert_array_equal(frames["observation.state"].astype(np.float32), expected("observation.state"))
    np.testing.assert_array_equal(frames["action"].astype(np.float32), expected("action").ravel())
    np.testing.assert_array_equal(frames["index"], np.arange(sum(LENGTHS)))
    np.testing.assert_array_equal(frames["frame_index"], np.concatenate([np.arange(n) for n in LENGTHS]))
    np.testing.assert_array_equal(frames["timestamp"], (frames["frame_index"] / FPS).astype(np.float32))
    np.testing.assert_array_equal(frames["episode_index"], np.repeat(np.arange(3), LENGTHS))
    np.testing.assert_array_equal(frames["task_index"], np.repeat([0, 1, 0], LENGTHS))
    assert reading.tasks(tmp_path / "data") == ["open", "close"]


def test_info_says_what_is_there(tmp_path: Path) -> None:
    write(tmp_path / "data")
    info = reading.info(tmp_path / "data")
    assert (info["codebase_version"], info["fps"], info["robot_type"]) == ("v3.0", FPS, "arm")
    assert (info["total_episodes"], info["total_frames"], info["total_tasks"]) == (3, sum(LENGTHS), 2)
    assert info["splits"] == {"train": "0:3"}
    state = {"dtype": "float32", "shape": [2], "names": ["angle.large", "angle.small"], "units": ["rad", "rad"]}
    assert info["features"]["observation.state"] == state
    assert info["features"][EYE]["shape"] == [90, 120, 3]
    assert info["features"]["timestamp"] == {"dtype": "float32", "shape": [1], "names": None}


def test_episodes_know_their_rows_pictures_and_statistics(tmp_path: Path) -> None:
    write(tmp_path / "data")
    frames, ends = reading.frames(tmp_path / "data"), np.cumsum(LENGTHS)
    for number, episode in enumerate(reading.episodes(tmp_path / "data")):
        first, end = episode["dataset_from_index"], episode["dataset_to_index"]
        assert (first, end) == (ends[number] - LENGTHS[number], ends[number])
        assert (episode["length"], episode["tasks"]) == (LENGTHS[number], [TASKS[number]])
        assert episode["outcome"] == f"result {number}"
        rows = frames["observation.state"][first:end]
        np.testing.assert_allclose(episode["stats/observation.state/mean"], rows.mean(axis=0), rtol=1e-12)
        assert np.shape(episode[f"stats/{EYE}/mean"]) == (3, 1, 1)
        shown = reading.pictures(tmp_path / "data", EYE, episode)
        assert len(shown) == LENGTHS[number]
        for picture, seen in zip(moving(LENGTHS[number], 10 * number), shown, strict=True):
            assert np.abs(picture.astype(int) - seen).mean() < 3.0
    whole = reading.stats(tmp_path / "data")["observation.state"]
    np.testing.assert_allclose(whole["std"], frames["observation.state"].std(axis=0), rtol=1e-12)
    assert whole["count"].tolist() == [sum(LENGTHS)]


def test_lerobots_own_loader_gives_the_same_numbers(tmp_path: Path) -> None:
    write(tmp_path / "data")
    loaded = reading.load(tmp_path / "data", tmp_path / "loaded.npz")
    np.testing.assert_array_equal(loaded["observation.state"], expected("observation.state"))
    np.testing.assert_array_equal(loaded["action"], expected("action").ravel())
    assert loaded["task"].tolist() == np.repeat(TASKS, LENGTHS).tolist()
    assert (int(loaded["fps"]), str(loaded["robot"])) == (FPS, "arm")
    shown = np.concatenate([list(moving(length, 10 * number)) for number, length in enumerate(LENGTHS)])
    assert np.abs(255.0 * loaded[EYE].transpose(0, 2, 3, 1) - shown).mean(axis=(1, 2, 3)).max() < 3.0
    stats = reading.stats(tmp_path / "data")
    np.testing.assert_array_equal(loaded[f"stats/{EYE}/q99"], stats[EYE]["q99"])
    assert loaded["episodes/outcome"].tolist() == ["result 0", "result 1", "result 2"]


def test_the_same_frames_give_the_same_bytes(tmp_path: Path) -> None:
    for name in ("one", "other"):
        write(tmp_path / name)
    for path in (tmp_path / "one").rglob("*.*"):
        if path.is_file():
            assert path.read_bytes() == (tmp_path / "other" / path.relative_to(tmp_path / "one")).read_bytes(), path


def test_large_files_are_followed_by_the_next(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(rows, "MAX_DATA_FILE", 0)
    monkeypatch.setattr(video, "MAX_EPISODE_START", 15 / FPS)
    monkeypatch.setattr(layout, "FILES_PER_CHUNK", 2)
    write(tmp_path / "data")
    names = [str(path.relative_to(tmp_path / "data/data")) for path in sorted(tmp_path.glob("data/data/*/*"))]
    assert names == ["chunk-000/file-000.parquet", "chunk-000/file-001.parquet", "chunk-001/file-000.parquet"]
    np.testing.assert_array_equal(reading.frames(tmp_path / "data")["index"], np.arange(sum(LENGTHS)))
    episodes = reading.episodes(tmp_path / "data")
    assert [episode["data/file_index"] for episode in episodes] == [0, 1, 0]
    assert [episode[f"videos/{EYE}/file_index"] for episode in episodes] == [0, 0, 1]
    assert [episode[f"videos/{EYE}/from_timestamp"] for episode in episodes] == [0.0, 12 / FPS, 0.0]
    for number, episode in enumerate(episodes):
        shown = reading.pictures(tmp_path / "data", EYE, episode)
        for picture, seen in zip(moving(LENGTHS[number], 10 * number), shown, strict=True):
            assert np.abs(picture.astype(int) - seen).mean() < 3.0


def test_pictures_of_an_episode_that_was_given_up_are_passed_over(tmp_path: Path) -> None:
    with EpisodeWriter(tmp_path / "data", FPS, "arm", VECTORS, {EYE: CameraFeature(90, 120)}) as data:
        for picture in moving(5, 60):
            data.add_picture(EYE, picture)
        data.start_episode()
        for picture in moving(4, 0):
            data.add_picture(EYE, picture)
        data.add_episode("open", values(4, 0))
    (episode,) = reading.episodes(tmp_path / "data")
    for picture, seen in zip(moving(4, 0), reading.pictures(tmp_path / "data", EYE, episode), strict=True):
        assert np.abs(picture.astype(int) - seen).mean() < 3.0


@pytest.mark.parametrize("error", [KeyboardInterrupt(), ValueError("broken"), InputError("wrong")])
def test_an_error_leaves_nothing(tmp_path: Path, error: BaseException) -> None:
    def begin() -> None:
        with EpisodeWriter(tmp_path / "new" / "data", FPS, "arm", VECTORS) as data:
            data.add_episode("open", values(4, 0))
            raise error

    with pytest.raises(type(error)):
        begin()
    assert list((tmp_path / "new").iterdir()) == []


def test_a_data_set_without_an_episode_is_refused(tmp_path: Path) -> None:
    with pytest.raises(OutputError, match="would have no episode"), EpisodeWriter(tmp_path / "a", FPS, "arm", VECTORS):
        pass
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"task": "  "}, "task: is empty"),
        ({"action": np.zeros((3, 1))}, "episode: action has the shape (3, 1); give finite numbers, (4, 1)"),
        ({"action": np.full((4, 1), np.nan)}, "episode: action has no or missing rows"),
        ({"observation.state": np.zeros((0, 2)), "action": np.zeros((0, 1))}, "has no or missing rows"),
    ],
)
def test_an_episode_that_makes_no_sense_is_refused(tmp_path: Path, change: dict[str, Any], said: str) -> None:
    task = change.pop("task", "open")
    with (
        pytest.raises(InputError, match=re.escape(said)),
        EpisodeWriter(tmp_path / "data", FPS, "arm", VECTORS) as data,
    ):
        data.add_episode(task, {**values(4, 0), **change})


def test_pictures_have_one_size_and_are_as_many_as_frames(tmp_path: Path) -> None:
    camera = {EYE: CameraFeature(90, 120)}
    with (
        pytest.raises(InputError, match=re.escape("has the shape (91, 120, 3), the first picture (90, 120, 3)")),
        EpisodeWriter(tmp_path / "a", FPS, "arm", VECTORS, camera) as data,
    ):
        data.add_picture(EYE, np.zeros((91, 120, 3), np.uint8))
    with EpisodeWriter(tmp_path / "a", FPS, "arm", VECTORS, camera) as data:
        data.add_picture(EYE, np.zeros((90, 120, 3), np.uint8))
        with pytest.raises(InputError, match=re.escape(f"4 frames have {{'{EYE}': 1}} pictures")):
            data.add_episode("open", values(4, 0))
        data.add_episode("open", values(1, 0))


@pytest.mark.parametrize("fps", [0, -5, 2.5, 1001, True])
def test_a_rate_that_is_no_whole_number_in_range_is_refused(tmp_path: Path, fps: Any) -> None:
    with pytest.raises(InputError, match=f"fps: {fps} is no number of frames a second; give a whole number from 1 to"):
        EpisodeWriter(tmp_path / "data", fps, "arm", VECTORS)


def test_missing_packages_are_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "av", None)
    with (
        pytest.raises(MissingExtraError, match="needs av"),
        EpisodeWriter(tmp_path / "data", FPS, "arm", VECTORS, {EYE: CameraFeature(90, 120)}),
    ):
        pass
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    with pytest.raises(MissingExtraError, match="needs pyarrow"):
        EpisodeWriter(tmp_path / "data", FPS, "arm", VECTORS)
    assert list(tmp_path.iterdir()) == []
