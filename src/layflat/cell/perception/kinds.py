"""What vision looks for, from the cell's description of produce: colours, sizes and shapes."""

from itertools import combinations
from math import sin
from pathlib import Path

import numpy as np

from layflat.cell.file.model import Cell, floor_of
from layflat.cell.file.produce import Produce
from layflat.cell.perception.skins import GREY, SATURATION_MARGIN, Region, hsv, share, span
from layflat.cell.scene.produce import CAP
from layflat.cell.vision import Colour, ColourDetector, Kind, OnnxDetector

ROUND = 0.05  # how far the outline of fruit is from that of a spheroid, share of its radius


def detector_of(cell: Cell) -> ColourDetector | OnnxDetector:
    """Return a detector of the cell's produce, in trays and containers on its table: its network, or one by colour."""
    red, green, blue = (255.0 * channel for channel in cell.table.colour)
    plane = float(np.mean([floor_of(source) for source in cell.sources.values()]))
    if (given := cell.network) is not None:
        return OnnxDetector(Path(given.file), kinds_of(cell), (red, green, blue), (given.rows, given.columns), plane)
    return ColourDetector(kinds_of(cell), (red, green, blue), background_of(cell), plane)


def kinds_of(cell: Cell) -> tuple[Kind, ...]:
    """Return the kinds of produce that vision knows, each with regions of colours of its own."""
    known = {name: kind for name, kind in cell.produce.items() if kind.known}
    regions = [(name, Region.around(skin)) for name, kind in known.items() for skin in kind.colour.values()]
    for (one, first), (other, second) in combinations(regions, 2):
        if one != other:
            share(first, second)
    backgrounds = _backgrounds(cell)
    return tuple(
        Kind(
            name,
            tuple(colour for of, region in regions if of == name for colour in region.colours(backgrounds)),
            (kind.diameter.least, kind.diameter.most),
            height_ratio=kind.flattening.mean * (1.0 if kind.shape == "round" else 2.0 - CAP),
            flattening=_flattening(kind),
            roundness=ROUND + (1.0 - _flattening(kind) ** 2) * sin(kind.tilt) ** 2 / 4.0,
        )
        for name, kind in known.items()
    )


def background_of(cell: Cell) -> tuple[Colour, ...]:
    """Return colours of table, trays and containers, in shadow too."""
    found = [Colour(value=(0.0, 0.1))]
    for colour in _backgrounds(cell):
        hue, saturation, value = hsv(colour)
        top = min(1.0, 1.3 * value)
        if saturation < GREY:
            found.append(Colour((0.0, 360.0), (0.0, GREY + SATURATION_MARGIN), (0.0, top)))
        else:
            spread = 0.35 * saturation + SATURATION_MARGIN
            found.append(Colour((hue - 25.0, hue + 25.0), span(saturation - spread, saturation + spread), (0.0, top)))
    return tuple(found)


def _flattening(kind: Produce) -> float:
    """Return height by width of what is seen from above: of the cap alone, where there is one."""
    return kind.flattening.mean * (1.0 if kind.shape == "round" else CAP)


def _backgrounds(cell: Cell) -> list[tuple[float, float, float]]:
    containers = [container.layout.colour for container in cell.container.values()]
    return [cell.table.colour, *(source.colour for source in cell.sources.values()), *containers]
