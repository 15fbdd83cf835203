from __future__ import annotations

from pathlib import Path

import pytest

from layflat.cell import load
from layflat.cell.kinds import make_detector
from layflat.cell.vision import Calibration, OnnxDetector
from layflat.cell.work.observer import Observer
from layflat.cell.work.results import PackingSummary
from layflat.cell.work.run import run_packing
from layflat.errors import CellError, InputError
from tests.cell.vision.red_network import COLUMNS, ROWS, network

CELL = """\
extends = "packing"
omits = ["clutter.leaves", "clutter.labels", "clutter.sticks"]
name = "learned"

[network]
file = "red.onnx"
rows = {rows}
columns = {columns}

[tray.infeed]
produce = ["tomato"]
count = {{ min = 1, max = 1 }}

[produce.tomato.diameter]
min = "54 mm"

[produce.tomato.colour.orange]
fraction = 0.000001
"""


def test_a_cell_packs_by_what_its_network_finds(tmp_path: Path, calibration: Calibration) -> None:
    """The stand-in calls the red thing number 0, which is the first kind of the cell's file: a tomato."""
    network(tmp_path / "red.onnx")
    path = tmp_path / "learned.toml"
    path.write_text(CELL.format(rows=ROWS, columns=COLUMNS), encoding="utf-8")
    cell = load(path)
    assert isinstance(make_detector(cell), OnnxDetector)
    found = run_packing(cell, 1, 1, calibration, Observer())
    assert PackingSummary(found.deliveries).correct == 1


def test_a_network_that_is_not_there_is_told(tmp_path: Path) -> None:
    path = tmp_path / "learned.toml"
    path.write_text(CELL.format(rows=ROWS, columns=COLUMNS), encoding="utf-8")
    with pytest.raises(CellError, match=r"network\.file: there is no .*red\.onnx"):
        load(path)
    (tmp_path / "red.onnx").write_bytes(b"no network")
    with pytest.raises(InputError, match="is not a network that OpenCV runs"):
        make_detector(load(path))
    path.write_text(CELL.format(rows=1, columns=COLUMNS), encoding="utf-8")
    with pytest.raises(CellError, match=r"network\.rows"):
        load(path)
