"""The cell's packs as plans know them."""

from __future__ import annotations

from layflat.cell.eyes import place_of
from layflat.cell.file.checks import places
from layflat.cell.file.model import Cell
from layflat.cell.file.parts import Pack as Described
from layflat.cell.plan.fruit import Fruit
from layflat.cell.plan.packs import Pack, Packing, Place, Spot, Takes


def packing_of(cell: Cell) -> Packing:
    """All packs of a cell, empty; places are named "row-column" from 1, rows along the pack's y axis."""
    return Packing(tuple(_pack(name, pack, cell) for name, pack in cell.pack.items()))


def spot_at(cell: Cell, packing: Packing, fruit: Fruit) -> Spot | None:
    """The free place over which a fruit was seen; None where it is over none, or over one that is taken."""
    found = place_of(cell, fruit.x, fruit.y)
    if found is None:
        return None
    name, number = found
    place = next(pack for pack in packing.packs if pack.name == name).places[number]
    return None if (name, place.name) in packing.contents else Spot(name, place)


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
