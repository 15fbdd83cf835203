from __future__ import annotations

import pytest

from layflat.cell import Cell, load


@pytest.fixture(scope="session")
def packing() -> Cell:
    return load("packing")
