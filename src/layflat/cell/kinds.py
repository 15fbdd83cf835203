"""Kinds of produce as vision detects them, from the cell's description: colours, sizes and shapes.

The colours of a skin are a region of HSV: a set of rectangles in hue (degree, near its skin's own) and saturation, as
light and shade change neither.
"""

import colorsys
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations, groupby, pairwise, product
from math import hypot, remainder, sin
from pathlib import Path
from typing import Self

import numpy as np

from layflat.cell.file.model import Cell, floor_of
from layflat.cell.file.produce import Produce, Skin
from layflat.cell.scene.produce import CAP_HEIGHT_RATIO
from layflat.cell.vision import Colour, ColourDetector, OnnxDetector, ProduceKind

__all__ = ["make_detector"]

Rectangle = tuple[float, float, float, float]  # hue from, to; saturation from, to
REGION_SIGMAS = 3.0  # standard deviations of a skin's colour that its region holds
HUE_MARGIN, SATURATION_MARGIN = (
    5.0,
    0.06,
)  # for tints of lights other than that of the table, and for noise; degree, of 1
SHADED_RATIO = 0.35  # brightness of a fruit's shaded side over that of its top
UNSURE_HUE = 0.035  # saturation below which noise dominates the hue
MAX_HUE_DISTANCE = 90.0  # from a skin's hue to the ends of its region, degree
GREY = 0.14  # saturation up to which a background counts as grey, in shadow of any hue
MIN_BRIGHTNESS_RATIO = 1.15  # brightness of a grey that is no background over that of a grey background
SHARED_DIVISIONS = 4  # number of cells along hue and saturation into which a shared rectangle is divided
MIN_DIVIDED_SIZE = (3.0, 0.02)  # hue (degree) and saturation below which it stays whole
OUTLINE_DEVIATION = 0.05  # of fruit from a spheroid's outline, fraction of its radius


@dataclass
class SkinRegion:
    """Region of a skin's colours in hue and saturation."""

    midpoint: tuple[float, float]  # its hue and saturation
    reach: tuple[float, float]  # half its size in hue and saturation, the unit of distances
    parts: list[Rectangle]  # disjoint
    darkest: float  # HSV value of the shaded side

    @classmethod
    def from_skin(cls, skin: Skin) -> Self:
        """Return the region of colours within `REGION_SIGMAS` standard deviations of a skin's, with margins."""
        hue, saturation, value = rgb_to_hsv(skin.rgb)
        directions = np.array([direction for direction in product((-1.0, 0.0, 1.0), repeat=3) if any(direction)])
        directions *= REGION_SIGMAS * skin.std / 2.0 / np.linalg.norm(directions, axis=1, keepdims=True)
        neighbours = [
            rgb_to_hsv(tuple(np.clip(np.array(skin.rgb) + direction, 0.02, 0.98).tolist())) for direction in directions
        ]
        hue_differences = [remainder(neighbour[0] - hue, 360.0) for neighbour in neighbours]
        saturations = [neighbour[1] for neighbour in neighbours]
        low, high = clip_range(min(saturations) - SATURATION_MARGIN, max(saturations) + SATURATION_MARGIN)
        start, end = (
            max(min(hue_differences) - HUE_MARGIN, -MAX_HUE_DISTANCE),
            min(max(hue_differences) + HUE_MARGIN, MAX_HUE_DISTANCE),
        )
        if low <= UNSURE_HUE:
            start, end = -MAX_HUE_DISTANCE, MAX_HUE_DISTANCE
        darkest = SHADED_RATIO * value * (1.0 - REGION_SIGMAS * skin.std)
        reach = (end - start) / 2, (high - low) / 2
        return cls((hue, saturation), reach, [(hue + start, hue + end, low, high)], darkest)

    def distance(self, hue: float, saturation: float) -> float:
        """Return the distance of a colour from the skin's, in units of `reach`; hues are not wrapped at 360 degrees."""
        return hypot((hue - self.midpoint[0]) / self.reach[0], (saturation - self.midpoint[1]) / self.reach[1])

    def colours(self, backgrounds: Sequence[tuple[float, ...]]) -> list[Colour]:
        """Return the regions of HSV, less those of grey ones among the background's RGB colours (0 to 1)."""
        greys = [colour for colour in map(rgb_to_hsv, backgrounds) if colour[1] < GREY]
        brightest = MIN_BRIGHTNESS_RATIO * max((value for _, _, value in greys), default=0.0)
        regions = []
        for start, end, low, high in self.parts:
            similar_greys = [
                MIN_BRIGHTNESS_RATIO * value
                for hue, saturation, value in greys
                if low < saturation + SATURATION_MARGIN / 2
                and abs(remainder(hue - (start + end) / 2, 360.0)) < (end - start) / 2
            ]
            lowest_value = max(self.darkest, *similar_greys, 0.0)
            if high > UNSURE_HUE and lowest_value < 1.0:
                regions.append(Colour((start, end), (max(low, UNSURE_HUE), high), (lowest_value, 1.0)))
            if low < UNSURE_HUE and brightest < 1.0:
                regions.append(Colour((0.0, 360.0), (0.0, UNSURE_HUE), (max(self.darkest, brightest), 1.0)))
        return regions


def divide_overlap(first: SkinRegion, second: SkinRegion) -> None:
    """Divide the overlap of two regions between them in place: each colour to the skin that it is nearer to."""
    wrap = 360.0 * round((first.midpoint[0] - second.midpoint[0]) / 360.0)
    shared = [
        (start, end, low, high)
        for a, b in product(first.parts, second.parts)
        for start, end in [(max(a[0], b[0] + wrap), min(a[1], b[1] + wrap))]
        for low, high in [(max(a[2], b[2]), min(a[3], b[3]))]
        if start < end and low < high
    ]
    for part in shared:
        first_parts, second_parts = _split_by_distance(part, first, second, wrap)
        first.parts = [rest for whole in first.parts for rest in _subtract_rectangle(whole, part)] + first_parts
        moved: Rectangle = (part[0] - wrap, part[1] - wrap, part[2], part[3])
        second.parts = [rest for whole in second.parts for rest in _subtract_rectangle(whole, moved)] + second_parts


def _split_by_distance(
    part: Rectangle, first: SkinRegion, second: SkinRegion, wrap: float
) -> tuple[list[Rectangle], list[Rectangle]]:
    """Return the cells of a rectangle that are nearer to the first skin, and to the second; rows are merged.

    The rectangle is in hues of the first skin; the second's cells are in its own, which are less by `wrap` (degree).
    """
    first_cells: list[Rectangle] = []
    second_cells: list[Rectangle] = []
    count = (
        SHARED_DIVISIONS if part[1] - part[0] > MIN_DIVIDED_SIZE[0] and part[3] - part[2] > MIN_DIVIDED_SIZE[1] else 1
    )
    hues, levels = np.linspace(*part[:2], count + 1), np.linspace(*part[2:], count + 1)
    for low, high in pairwise(levels):
        middle = float(low + high) / 2
        nearer = [
            first.distance(hue, middle) <= second.distance(hue - wrap, middle)
            for hue in ((hues[:-1] + hues[1:]) / 2).tolist()
        ]
        for belongs_to_first, cells in groupby(range(count), key=lambda cell: nearer[cell]):
            row = list(cells)
            start, end = float(hues[row[0]]), float(hues[row[-1] + 1])
            shift = 0.0 if belongs_to_first else wrap
            (first_cells if belongs_to_first else second_cells).append(
                (start - shift, end - shift, float(low), float(high))
            )
    return first_cells, second_cells


def _subtract_rectangle(whole: Rectangle, hole: Rectangle) -> list[Rectangle]:
    """Return a rectangle less another, as up to four rectangles."""
    start, end, low, high = whole
    a, b, c, d = max(start, hole[0]), min(end, hole[1]), max(low, hole[2]), min(high, hole[3])
    if a >= b or c >= d:
        return [whole]
    rest = [(start, end, low, c), (start, end, d, high), (start, a, c, d), (b, end, c, d)]
    return [part for part in rest if part[0] < part[1] and part[2] < part[3]]


def rgb_to_hsv(rgb: tuple[float, ...]) -> tuple[float, float, float]:
    """Return hue in degree, saturation and value of an RGB colour, all others 0 to 1."""
    hue, saturation, value = colorsys.rgb_to_hsv(*rgb)
    return 360.0 * hue, saturation, value


def clip_range(low: float, high: float) -> tuple[float, float]:
    """Return a range cut to 0 and 1."""
    return max(low, 0.0), min(high, 1.0)


def make_detector(cell: Cell) -> ColourDetector | OnnxDetector:
    """Return the detector of a cell's produce: its network, or one by colour."""
    red, green, blue = (255.0 * channel for channel in cell.table.colour)
    plane = float(np.mean([floor_of(source) for source in cell.sources.values()]))
    if (network := cell.network) is not None:
        return OnnxDetector(
            Path(network.file), produce_kinds(cell), (red, green, blue), (network.rows, network.columns), plane
        )
    return ColourDetector(produce_kinds(cell), (red, green, blue), background_colours(cell), plane)


def produce_kinds(cell: Cell) -> tuple[ProduceKind, ...]:
    """Return the kinds of produce that vision knows; no colour is in the regions of two kinds."""
    known_kinds = {name: kind for name, kind in cell.produce.items() if kind.recognised}
    regions = [
        (name, SkinRegion.from_skin(skin)) for name, kind in known_kinds.items() for skin in kind.colour.values()
    ]
    for (kind_name, first), (other_name, second) in combinations(regions, 2):
        if kind_name != other_name:
            divide_overlap(first, second)
    backgrounds = _part_colours(cell)
    return tuple(
        ProduceKind(
            name,
            tuple(colour for owner, region in regions if owner == name for colour in region.colours(backgrounds)),
            (kind.diameter.min, kind.diameter.max),
            height_ratio=kind.flattening.mean * (1.0 if kind.shape == "round" else 2.0 - CAP_HEIGHT_RATIO),
            flattening=_flattening(kind),
            roundness=OUTLINE_DEVIATION + (1.0 - _flattening(kind) ** 2) * sin(kind.tilt) ** 2 / 4.0,
        )
        for name, kind in known_kinds.items()
    )


def background_colours(cell: Cell) -> tuple[Colour, ...]:
    """Return the regions of colours of table, trays and containers, also in shadow."""
    regions = [Colour(value=(0.0, 0.1))]
    for colour in _part_colours(cell):
        hue, saturation, value = rgb_to_hsv(colour)
        top = min(1.0, 1.3 * value)
        if saturation < GREY:
            regions.append(Colour((0.0, 360.0), (0.0, GREY + SATURATION_MARGIN), (0.0, top)))
        else:
            half_range = 0.35 * saturation + SATURATION_MARGIN
            regions.append(
                Colour(
                    (hue - 25.0, hue + 25.0), clip_range(saturation - half_range, saturation + half_range), (0.0, top)
                )
            )
    return tuple(regions)


def _flattening(kind: Produce) -> float:
    """Return height over width of the part that is visible from above: the whole fruit, or a mushroom's cap."""
    return kind.flattening.mean * (1.0 if kind.shape == "round" else CAP_HEIGHT_RATIO)


def _part_colours(cell: Cell) -> list[tuple[float, float, float]]:
    """Return the RGB colours, 0 to 1, of table, trays or conveyor, and containers."""
    containers = [container.layout.colour for container in cell.container.values()]
    return [cell.table.colour, *(source.colour for source in cell.sources.values()), *containers]
