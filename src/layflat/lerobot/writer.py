"""Writer of a LeRobot data set, episode by episode; the folder is there once all of it is written."""

import json
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from layflat import extras
from layflat.arrays import Array, Picture
from layflat.errors import InputError, OutputError
from layflat.files import whole_folder
from layflat.lerobot.layout import (
    EPISODES_PATH,
    INFO_PATH,
    STATS_PATH,
    TASKS_PATH,
    TOP_NAMES,
    CameraFeature,
    FileNumber,
    VectorFeature,
    dataset_info,
)
from layflat.lerobot.rows import FrameTable
from layflat.lerobot.statistics import (
    PictureStatistics,
    Statistics,
    combine_statistics,
    flatten_statistics,
    vector_statistics,
)
from layflat.lerobot.video import CameraVideo
from layflat.outputs import check_vacant

MAX_FPS = 1000  # frames a second


@dataclass(frozen=True)
class WrittenDataset:
    """Data set that was written: its folder, and the counts of what it holds."""

    folder: Path
    fps: int
    episodes: int
    frames: int
    tasks: int


def check_fps(fps: object) -> int:
    """Return a number of frames a second; raise InputError unless it is a whole number from 1 to `MAX_FPS`."""
    if not isinstance(fps, (int, np.integer)) or isinstance(fps, bool) or not 1 <= fps <= MAX_FPS:
        right = f"give a whole number from 1 to {MAX_FPS}, as LeRobot's are"
        raise InputError(f"{fps} is no number of frames a second", where="fps", right=right)
    return int(fps)


def check_task(task: str) -> str:
    """Return the text of a task without blanks at its ends; raise InputError if nothing is left."""
    if not task.strip():
        raise InputError("is empty", where="task", right='give what the machine does, such as "move to the target"')
    return task.strip()


def check_target(folder: Path) -> None:
    """Check that a data set can be written to a folder.

    Raises:
        MissingExtraError: pyarrow is not installed.
        OutputError: the folder is not empty.
    """
    extras.require("logs", "pyarrow", where=str(folder))
    check_vacant(folder, TOP_NAMES)


class EpisodeWriter:
    """Writer of a LeRobot data set, in a `with` block: an episode is its pictures, then its numbers.

    The folder is there once the block ends without an error.

    Args:
        folder: new or empty folder.
        fps: frames a second, a whole number.
        robot_type: name of the machine.
        vectors: features of numbers by name, such as "observation.state" and "action".
        cameras: features of cameras by name, such as "observation.images.overview".

    Raises:
        MissingExtraError: pyarrow is not installed, or PyAV where there are cameras.
        OutputError: the folder is not empty or can't be written, or no episode was added.
    """

    def __init__(
        self,
        folder: Path,
        fps: int,
        robot_type: str,
        vectors: Mapping[str, VectorFeature],
        cameras: Mapping[str, CameraFeature] | None = None,
    ) -> None:
        """Check packages and rate; the `with` block makes the folder."""
        check_target(folder)
        self._target, self.fps, self._robot_type = folder, check_fps(fps), robot_type
        self._vectors, self._cameras = dict(vectors), dict(cameras or {})
        self._tasks: dict[str, int] = {}
        self._episodes: list[dict[str, Any]] = []
        self._statistics: list[dict[str, Statistics]] = []
        self._frames = 0

    def __enter__(self) -> Self:
        self._writing = self._write_folder()
        self._writing.__enter__()
        return self

    def __exit__(self, *raised: Any) -> bool | None:
        return self._writing.__exit__(*raised)

    @contextmanager
    def _write_folder(self) -> Iterator[None]:
        """Open the folder and its files; at the end of the block close them and write what describes them."""
        with whole_folder(self._target, TOP_NAMES) as self._folder:
            self._table = FrameTable(self._folder, self._vectors)
            cameras = self._cameras.items()
            self._videos = {key: CameraVideo(self._folder, key, camera, self.fps) for key, camera in cameras}
            self.start_episode()
            try:
                yield
            finally:
                self._table.close()
                for video in self._videos.values():
                    video.close()
            self._write_meta()

    @property
    def summary(self) -> WrittenDataset:
        """Counts of what was added so far."""
        return WrittenDataset(self._target, self.fps, len(self._episodes), self._frames, len(self._tasks))

    def start_episode(self) -> None:
        """Start an episode; pictures of one that was not added are left out."""
        self._pictures = {key: PictureStatistics() for key in self._videos}
        for video in self._videos.values():
            video.start_episode()

    def add_picture(self, camera: str, picture: Picture) -> None:
        """Add the next picture of a camera to the present episode, (H, W, 3) RGB."""
        self._videos[camera].add(picture)
        self._pictures[camera].add(picture)

    def add_episode(self, task: str, values: Mapping[str, Array], labels: Mapping[str, str] | None = None) -> None:
        """Add an episode with the pictures since the last one, and start the next.

        Args:
            task: what the machine does, in words.
            values: rows of each feature of numbers, (frames, components), finite.
            labels: further columns of the table of episodes.

        Raises:
            InputError: the task is empty, or the rows do not fit the features or the pictures.
        """
        task = check_task(task)
        task_index = self._tasks.get(task, len(self._tasks))
        columns = self._episode_columns(values, task_index)
        frames = len(columns["index"])
        if any(video.episode_pictures != frames for video in self._videos.values()):
            counts = {key: video.episode_pictures for key, video in self._videos.items()}
            raise InputError(f"{frames} frames have {counts} pictures", where="episode", right="give one a frame")
        self._tasks[task] = task_index
        self._table.add(columns)
        statistics = {name: vector_statistics(column) for name, column in columns.items()}
        statistics |= {key: pictures.result() for key, pictures in self._pictures.items()}
        row: dict[str, Any] = {
            "episode_index": len(self._episodes),
            "tasks": [task],
            "length": frames,
            **(labels or {}),
            "data/chunk_index": self._table.number.chunk_index,
            "data/file_index": self._table.number.file_index,
            "dataset_from_index": self._frames,
            "dataset_to_index": self._frames + frames,
        }
        for video in self._videos.values():
            row |= video.episode_place
        row |= flatten_statistics(statistics) | {"meta/episodes/chunk_index": 0, "meta/episodes/file_index": 0}
        self._episodes.append(row)
        self._statistics.append(statistics)
        self._frames += frames
        self.start_episode()

    def _episode_columns(self, values: Mapping[str, Array], task_index: int) -> dict[str, NDArray[np.generic]]:
        """Return the columns of an episode by name; raise InputError for rows that do not fit the features."""
        frames = len(next(iter(values.values())))
        columns: dict[str, NDArray[np.generic]] = {}
        for name, vector in self._vectors.items():
            rows, shape = np.asarray(values[name]), (frames, len(vector.names))
            if rows.shape != shape or not frames or not np.isfinite(rows).all():
                what = f"{name} has the shape {rows.shape}" if rows.shape != shape else f"{name} has no or missing rows"
                raise InputError(what, where="episode", right=f"give finite numbers, ({frames or 1}, {shape[1]})")
            columns[name] = rows.astype(np.float32)
        index = np.arange(frames)
        return columns | {
            "timestamp": (index / self.fps).astype(np.float32),
            "frame_index": index,
            "episode_index": np.full(frames, len(self._episodes)),
            "index": self._frames + index,
            "task_index": np.full(frames, task_index),
        }

    def _write_meta(self) -> None:
        """Write tasks, episodes, statistics and info; raise OutputError if no episode was added."""
        import pandas  # noqa: PLC0415
        import pyarrow as pa  # noqa: PLC0415
        from pyarrow import parquet  # noqa: PLC0415

        if not self._episodes:
            raise OutputError("would have no episode", where=str(self._target), right="add one or more")
        episodes = self._folder / EPISODES_PATH.format(**FileNumber()._asdict())
        episodes.parent.mkdir(parents=True, exist_ok=True)
        parquet.write_table(pa.Table.from_pylist(self._episodes), episodes)
        index = pandas.Index(list(self._tasks), name="task")  # the loader reads texts from the index
        pandas.DataFrame({"task_index": list(self._tasks.values())}, index=index).to_parquet(
            self._folder / TASKS_PATH, engine="pyarrow"
        )
        totals = {"total_episodes": len(self._episodes), "total_frames": self._frames, "total_tasks": len(self._tasks)}
        info = dataset_info(self.fps, self._robot_type, self._vectors, self._cameras, totals)
        combined = {
            feature: {
                name: values.tolist()
                for name, values in combine_statistics([episode[feature] for episode in self._statistics]).items()
            }
            for feature in self._statistics[0]
        }
        for path, content in ((INFO_PATH, info), (STATS_PATH, combined)):
            text = json.dumps(content, indent=4, ensure_ascii=False) + "\n"
            (self._folder / path).write_text(text, encoding="utf-8")
