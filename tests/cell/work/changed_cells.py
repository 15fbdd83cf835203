"""Cells that differ from the built-in ones."""

from __future__ import annotations

from copy import deepcopy
from typing import Any

from layflat.cell import Cell
from layflat.cell.file.loader import CELL_LIBRARY, build_cell


def cell_with(changes: dict[str, Any], *, without: tuple[str, ...] = (), of: str = "packing") -> Cell:
    """A built-in cell with values by their paths, such as "tray/infeed/touching_fraction", and without some parts."""
    plain, _ = CELL_LIBRARY.tables(of)
    plain = deepcopy(plain)
    for path in without:
        *above, last = path.split("/")
        del _table(plain, above)[last]
    for path, value in changes.items():
        *above, last = path.split("/")
        _table(plain, above)[last] = value
    return build_cell(plain, {}, "mine.toml")


def _table(plain: dict[str, Any], path: list[str]) -> dict[str, Any]:
    for key in path:
        plain = plain[key]
    return plain
