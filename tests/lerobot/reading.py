"""LeRobot data sets read back: by the documented layout, with pyarrow and PyAV, and by LeRobot's own loader."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
from pathlib import Path
from typing import Any

import av
import numpy as np
import pandas as pd
from numpy.typing import NDArray
from pyarrow import parquet

from tests.programs import skip_without

LOADER = """\
import sys
import numpy as np
from lerobot.datasets.lerobot_dataset import LeRobotDataset

folder, out, every = sys.argv[1], sys.argv[2], int(sys.argv[3])
data = LeRobotDataset("local/data", root=folder, video_backend="pyav")
frames = [data[i] for i in range(0, len(data), every)]
arrays = {key: np.stack([np.asarray(frame[key]) for frame in frames]) for key in frames[0]}
stats = {f"stats/{key}/{name}": value for key, of in data.meta.stats.items() for name, value in of.items()}
episodes = {f"episodes/{key}": np.asarray(data.meta.episodes[key]) for key in data.meta.episodes.column_names}
np.savez(out, fps=data.fps, robot=data.meta.robot_type, **arrays, **stats, **episodes)
"""


def info(folder: Path) -> dict[str, Any]:
    content: dict[str, Any] = json.loads((folder / "meta/info.json").read_text(encoding="utf-8"))
    return content


def frames(folder: Path) -> dict[str, NDArray[Any]]:
    """All frames by column, in the order of the files."""
    tables = [parquet.read_table(path) for path in sorted(folder.glob("data/*/*.parquet"))]
    return {
        name: np.array([row for table in tables for row in table[name].to_pylist()]) for name in tables[0].column_names
    }


def episodes(folder: Path) -> list[dict[str, Any]]:
    rows: list[dict[str, Any]] = parquet.read_table(next(folder.glob("meta/episodes/*/*.parquet"))).to_pylist()
    return rows


def stats(folder: Path) -> dict[str, dict[str, NDArray[Any]]]:
    plain = json.loads((folder / "meta/stats.json").read_text(encoding="utf-8"))
    return {key: {name: np.array(value) for name, value in of.items()} for key, of in plain.items()}


def tasks(folder: Path) -> list[str]:
    """Texts of the tasks by number, as the loader looks them up."""
    table = pd.read_parquet(folder / "meta/tasks.parquet")
    assert table["task_index"].tolist() == list(range(len(table)))
    return [str(text) for text in table.index]


def pictures(folder: Path, key: str, episode: dict[str, Any]) -> list[NDArray[np.uint8]]:
    """Pictures of an episode, found in the file by their times alone."""
    place = {name: episode[f"videos/{key}/{name}"] for name in ("chunk_index", "file_index")}
    path = folder / info(folder)["video_path"].format(video_key=key, **place)
    begin, end = episode[f"videos/{key}/from_timestamp"], episode[f"videos/{key}/to_timestamp"]
    with av.open(str(path)) as film:
        return [
            np.asarray(frame.to_ndarray(format="rgb24"), np.uint8)
            for frame in film.decode(video=0)
            if begin - 1e-6 <= float(frame.time or 0.0) < end - 1e-6
        ]


def load(folder: Path, out: Path, every: int = 1) -> dict[str, NDArray[Any]]:
    """Each n-th frame, statistics and episodes by LeRobot's own loader; the test is left out without it."""
    program = shutil.which("lerobot-info")
    if program is None:
        skip_without("lerobot")
    python = Path(program).resolve().parent / "python"
    environment = {**os.environ, "HF_HUB_OFFLINE": "1", "HF_HOME": str(out.parent / "hf"), "PYTHONPATH": ""}
    command = [str(python), "-c", LOADER, str(folder), str(out), str(every)]
    done = subprocess.run(command, capture_output=True, text=True, check=False, env=environment, cwd=out.parent)
    assert done.returncode == 0, done.stderr
    with np.load(out) as stored:
        return dict(stored)
