"""What is not a file is refused at once by all who read files."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from layflat.cell.vision.calibration import load_calibration
from layflat.design import read_characteristic
from layflat.errors import LayflatError
from layflat.identify.benches.loader import load_bench
from layflat.identify.logs.formats import read_table
from layflat.identify.logs.mapping import read_mapping
from layflat.machine import load
from layflat.motion.demand_file import read_demand
from layflat.study.study import read_study

READERS: list[tuple[str, Callable[[Path], Any]]] = [
    ("machine.toml", load),
    ("study.toml", read_study),
    ("mapping.toml", read_mapping),
    ("calibration.toml", load_calibration),
    ("log.csv", read_table),
    ("log.parquet", read_table),
    ("log.mcap", read_table),
    ("log.nc", read_table),
    ("demand.csv", lambda path: read_demand(load("paper-arm"), path, 0.005)),
    ("bench.yml", load_bench),
    ("measured.csv", read_characteristic),
]


@pytest.mark.parametrize(("name", "reader"), READERS, ids=[name for name, _ in READERS])
def test_a_pipe_a_folder_and_nothing_are_refused(name: str, reader: Callable[[Path], Any], tmp_path: Path) -> None:
    pipe, folder = tmp_path / f"pipe-{name}", tmp_path / f"folder-{name}"
    os.mkfifo(pipe)
    folder.mkdir()
    for path, said in ((pipe, "is a pipe or a device"), (folder, "is a folder"), (tmp_path / name, "can't be read")):
        with pytest.raises(LayflatError) as caught:
            reader(path)
        assert said in str(caught.value)
        assert str(path) in str(caught.value)
