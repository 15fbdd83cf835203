"""The cell's packs as plans know them."""

from __future__ import annotations

from layflat.cell.file.checks import places
from layflat.cell.file.model import Cell
from layflat.cell.file.parts import Pack as Described
from layflat.cell.plan.packs import Pack, Packing, Place, Takes


def packing_of(cell: Cell) -> Packing:
    """All packs of a cell, empty; places are named "row-column" from 1, rows along the pack's y axis."""
    return Packing(tuple(_pack(name, pack, cell) for name, pack in cell.pack.items()))


def _pack(name: str, pack: Described, cell: Cell) -> Pack:
    grade = cell.produce[pack.kind].grade[pack.grade]
    largest = min(grade.most, pack.layout.opening)
    takes = Takes(frozenset({pack.kind}), frozenset({pack.grade}), grade.least, largest)
    columns = pack.layout.columns
    return Pack(
        name,
        tuple(
            Place(f"{i // columns + 1}-{i % columns + 1}", float(x), float(y), pack.layout.wall, takes)
            for i, (x, y) in enumerate(places(pack))
        ),
    )
