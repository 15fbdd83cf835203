"""What vision looks for, from the cell's description of produce: colours, sizes and shapes."""

from __future__ import annotations

import colorsys
from dataclasses import dataclass
from itertools import combinations, product
from math import sin

import numpy as np

from layflat.cell.file.model import Cell
from layflat.cell.file.parts import Colour as RGB
from layflat.cell.file.produce import Produce, Skin
from layflat.cell.scene.produce import CAP
from layflat.cell.vision import Colour, ColourDetector, Kind

SIGMAS = 3.0
"""Of a skin's spread that its region of colours holds."""
HUE_MARGIN, SATURATION_MARGIN = 5.0, 0.06
"""For tints of lamps beside that of the table, and for noise; degree and of 1."""
SHADED = 0.35
"""Brightness of the side of a fruit that no lamp lights, share of its top's."""
UNSURE_HUE = 0.035
"""Saturation under which noise decides on the hue."""
GREY = 0.14
"""Saturation up to which a background counts as grey, in shadow of any hue."""
BRIGHTER = 1.15
"""By which a grey that is no background must be brighter than all grey backgrounds."""
ROUND = 0.05
"""How far the outline of fruit is from that of a spheroid, share of its radius."""


def detector_of(cell: Cell) -> ColourDetector:
    """A detector of the cell's produce, in trays and packs on its table."""
    red, green, blue = (255.0 * channel for channel in cell.table.colour)
    floors = [tray.wall for tray in cell.tray.values()]
    return ColourDetector(kinds_of(cell), (red, green, blue), background_of(cell), float(np.mean(floors or [0.0])))


def kinds_of(cell: Cell) -> tuple[Kind, ...]:
    """The kinds of produce that vision is told of.

    Colours in which kinds overlap are divided half way between their skins.
    """
    boxes = [
        _box(name, skin) for name, kind in cell.produce.items() if kind.known for skin in kind.colour.values()
    ]  # fmt: skip
    _divide(boxes)
    grey = max((max(colour) for colour in _backgrounds(cell) if _hsv(colour)[1] < GREY), default=0.0)
    return tuple(
        Kind(
            name,
            tuple(colour for box in boxes if box.kind == name for colour in box.colours(grey)),
            (kind.diameter.least, kind.diameter.most),
            height_ratio=2.0 * kind.flattening.mean * (1.0 if kind.shape == "round" else 2.0 - CAP) / 2.0,
            flattening=_flattening(kind),
            roundness=ROUND + (1.0 - _flattening(kind) ** 2) * sin(kind.tilt) ** 2 / 4.0,
        )
        for name, kind in cell.produce.items()
        if kind.known
    )


def background_of(cell: Cell) -> tuple[Colour, ...]:
    """Colours of table, trays and packs, in shadow too."""
    found = [Colour(value=(0.0, 0.1))]
    for colour in _backgrounds(cell):
        hue, saturation, value = _hsv(colour)
        top = min(1.0, 1.3 * value)
        if saturation < GREY:
            found.append(Colour((0.0, 360.0), (0.0, GREY + SATURATION_MARGIN), (0.0, top)))
        else:
            spread = 0.35 * saturation + SATURATION_MARGIN
            found.append(Colour((hue - 25.0, hue + 25.0), _span(saturation - spread, saturation + spread), (0.0, top)))
    return tuple(found)


@dataclass
class _Box:
    """A skin's colours: hue from its own (degree, from and to), saturation, value."""

    kind: str
    middle: tuple[float, float]
    hue: tuple[float, float]
    saturation: tuple[float, float]
    value: tuple[float, float]

    def colours(self, grey: float) -> list[Colour]:
        """As regions of HSV: what has no sure hue only where it is brighter than all `grey` of the background."""
        hue = (self.middle[0] + self.hue[0], self.middle[0] + self.hue[1])
        found = [Colour(hue, _span(max(self.saturation[0], UNSURE_HUE), self.saturation[1]), self.value)]
        bright = max(self.value[0], BRIGHTER * grey)
        if self.saturation[0] < UNSURE_HUE and bright < 1.0:
            found.append(Colour((0.0, 360.0), (0.0, UNSURE_HUE), (bright, 1.0)))
        return found


def _box(kind: str, skin: Skin) -> _Box:
    """Around all colours that differ from a skin's by up to `SIGMAS` of its spread."""
    hue, saturation, value = _hsv(skin.rgb)
    ways = np.array([way for way in product((-1.0, 0.0, 1.0), repeat=3) if any(way)])
    ways *= SIGMAS * skin.spread / 2.0 / np.linalg.norm(ways, axis=1, keepdims=True)
    near = [_hsv(tuple(np.clip(np.array(skin.rgb) + way, 0.02, 0.98).tolist())) for way in ways]
    away = [(one[0] - hue + 180.0) % 360.0 - 180.0 for one in near]
    widest = 60.0  # as far as a hue still is a neighbour
    return _Box(
        kind,
        (hue, saturation),
        (max(min(away) - HUE_MARGIN, -widest), min(max(away) + HUE_MARGIN, widest)),
        _span(min(one[1] for one in near) - SATURATION_MARGIN, max(one[1] for one in near) + SATURATION_MARGIN),
        (SHADED * value * (1.0 - SIGMAS * skin.spread), 1.0),
    )


def _divide(boxes: list[_Box]) -> None:
    """Cut boxes of different kinds apart, by hue or by saturation: where they overlap less for their size."""
    for one, other in combinations(boxes, 2):
        if one.kind == other.kind:
            continue
        apart = (other.middle[0] - one.middle[0] + 180.0) % 360.0 - 180.0
        first, second = (one, other) if apart >= 0.0 else (other, one)
        between = abs(apart)
        hues = first.hue[1] - second.hue[0]
        if hues <= between:
            continue
        low, high = (one, other) if one.middle[1] <= other.middle[1] else (other, one)
        gap = high.middle[1] - low.middle[1]
        above, below = low.saturation[1] - low.middle[1], high.middle[1] - high.saturation[0]
        if above + below <= gap:
            continue
        if between / hues >= gap / (above + below):
            cut = between * first.hue[1] / hues
            first.hue, second.hue = (first.hue[0], cut), (cut - between, second.hue[1])
        else:
            cut = low.middle[1] + gap * above / (above + below)
            low.saturation, high.saturation = (low.saturation[0], cut), (cut, high.saturation[1])


def _flattening(kind: Produce) -> float:
    """Height by width of what is seen from above: of the cap alone, where there is one."""
    return kind.flattening.mean * (1.0 if kind.shape == "round" else CAP)


def _backgrounds(cell: Cell) -> list[RGB]:
    packs = [pack.layout.colour for pack in cell.pack.values()]
    return [cell.table.colour, *(tray.colour for tray in cell.tray.values()), *packs]


def _hsv(rgb: tuple[float, ...]) -> tuple[float, float, float]:
    """Hue in degree, saturation, value."""
    hue, saturation, value = colorsys.rgb_to_hsv(*rgb)
    return 360.0 * hue, saturation, value


def _span(low: float, high: float) -> tuple[float, float]:
    return max(low, 0.0), min(high, 1.0)
