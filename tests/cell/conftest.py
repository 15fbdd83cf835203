from __future__ import annotations

import pytest

from layflat.cell import Cell, load
from layflat.cell.vision import Calibration
from layflat.cell.work.run import calibrate_cell


@pytest.fixture(scope="session")
def packing() -> Cell:
    return load("packing")


@pytest.fixture(scope="session")
def calibration(packing: Cell, opengl: None) -> Calibration:
    """Of the built-in cell's camera, as all cells have it that differ in other things."""
    shares: list[float] = []
    found = calibrate_cell(packing, shares.append)
    assert shares == sorted(shares)
    assert shares[-1] == 1.0
    return found
