"""Layout of LeRobot's data sets, version 3.0: paths of files, and the features that `meta/info.json` lists.

The reference is LeRobot's loader (lerobot 0.4.4), which differs from its page on the format in the file of tasks.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple, Self

CODEBASE_VERSION = "v3.0"  # of LeRobot's format
TOP_NAMES = frozenset({"data", "meta", "videos"})  # content of a data set's folder
DATA_PATH = "data/chunk-{chunk_index:03d}/file-{file_index:03d}.parquet"
VIDEO_PATH = "videos/{video_key}/chunk-{chunk_index:03d}/file-{file_index:03d}.mp4"
EPISODES_PATH = "meta/episodes/chunk-{chunk_index:03d}/file-{file_index:03d}.parquet"
TASKS_PATH, INFO_PATH, STATS_PATH = "meta/tasks.parquet", "meta/info.json", "meta/stats.json"
FILES_PER_CHUNK = 1000
MAX_DATA_FILE, MAX_VIDEO_FILE = 100, 200  # sizes above which a new file begins, MiB
BYTES_PER_MIB = 1 << 20

INDEX_COLUMNS = {
    "timestamp": "float32",
    "frame_index": "int64",
    "episode_index": "int64",
    "index": "int64",
    "task_index": "int64",
}
"""Columns of every data set, with their types."""


class FileNumber(NamedTuple):
    """Number of a file: that of its chunk, and its own in it."""

    chunk_index: int = 0
    file_index: int = 0

    def following(self) -> Self:
        """Return the number of the next file."""
        last = self.file_index == FILES_PER_CHUNK - 1
        return type(self)(self.chunk_index + last, 0 if last else self.file_index + 1)


@dataclass(frozen=True)
class VectorFeature:
    """Feature of numbers, a vector a frame."""

    names: tuple[str, ...]  # of its components, such as "angle.elbow"
    units: tuple[str, ...]

    @property
    def entry(self) -> dict[str, Any]:
        """Entry in `meta/info.json`; LeRobot has no place for units, and ignores that key."""
        return {"dtype": "float32", "shape": [len(self.names)], "names": list(self.names), "units": list(self.units)}


@dataclass(frozen=True)
class CameraFeature:
    """Feature of a camera, a picture a frame."""

    height: int  # px
    width: int  # px

    def entry(self, fps: int) -> dict[str, Any]:
        """Return the entry in `meta/info.json` at `fps` frames a second."""
        video = {
            "video.height": self.height, "video.width": self.width, "video.codec": "av1",
            "video.pix_fmt": "yuv420p", "video.is_depth_map": False, "video.fps": fps, "video.channels": 3,
            "has_audio": False,
        }  # fmt: skip
        shape, names = [self.height, self.width, 3], ["height", "width", "channels"]
        return {"dtype": "video", "shape": shape, "names": names, "info": video}


def dataset_info(
    fps: int,
    robot_type: str,
    vectors: Mapping[str, VectorFeature],
    cameras: Mapping[str, CameraFeature],
    totals: Mapping[str, int],
) -> dict[str, Any]:
    """Return the content of `meta/info.json`.

    Args:
        fps: frames a second.
        robot_type: name of the machine.
        vectors: features of numbers by name.
        cameras: features of cameras by name.
        totals: total_episodes, total_frames and total_tasks.
    """
    indices = {name: {"dtype": kind, "shape": [1], "names": None} for name, kind in INDEX_COLUMNS.items()}
    return {
        "codebase_version": CODEBASE_VERSION,
        "robot_type": robot_type,
        **totals,
        "chunks_size": FILES_PER_CHUNK,
        "data_files_size_in_mb": MAX_DATA_FILE,
        "video_files_size_in_mb": MAX_VIDEO_FILE,
        "fps": fps,
        "splits": {"train": f"0:{totals['total_episodes']}"},
        "data_path": DATA_PATH,
        "video_path": VIDEO_PATH if cameras else None,
        "features": {name: vector.entry for name, vector in vectors.items()}
        | {name: camera.entry(fps) for name, camera in cameras.items()}
        | indices,
    }
