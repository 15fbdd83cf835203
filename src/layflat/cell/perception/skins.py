"""The colours of skins as regions of HSV, and how two skins share what both could be.

A region is a set of rectangles in hue (degree, near its skin's own) and saturation, as light and shade change neither.
"""

import colorsys
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import groupby, pairwise, product
from math import hypot, remainder
from typing import Self

import numpy as np

from layflat.cell.file.produce import Skin
from layflat.cell.vision import Colour

Rectangle = tuple[float, float, float, float]  # hue from, to; saturation from, to
SIGMAS = 3.0  # of a skin's spread that its region holds
HUE_MARGIN, SATURATION_MARGIN = 5.0, 0.06  # for tints of lights beside that of the table, and for noise; degree, of 1
SHADED = 0.35  # brightness of the side of a fruit that no light reaches, share of its top's
UNSURE_HUE = 0.035  # saturation under which noise decides on the hue
WIDEST = 90.0  # from a skin's hue to another that still counts as near, degree
GREY = 0.14  # saturation up to which a background counts as grey, in shadow of any hue
BRIGHTER = 1.15  # by which a grey that is no background must be brighter than a grey background
CELLS = 4  # into so many, each way, is divided what two skins share,
NARROW = (3.0, 0.02)  # unless it is less wide than this, degree, or less high, of 1


@dataclass
class Region:
    """A skin's colours."""

    midpoint: tuple[float, float]  # its hue and saturation
    reach: tuple[float, float]  # how far it reaches from there each way, for distances
    parts: list[Rectangle]  # that do not overlap
    darkest: float  # value of its shaded side

    @classmethod
    def around(cls, skin: Skin) -> Self:
        """Return all colours that differ from a skin's by up to `SIGMAS` of its spread."""
        hue, saturation, value = hsv(skin.rgb)
        ways = np.array([way for way in product((-1.0, 0.0, 1.0), repeat=3) if any(way)])
        ways *= SIGMAS * skin.spread / 2.0 / np.linalg.norm(ways, axis=1, keepdims=True)
        near = [hsv(tuple(np.clip(np.array(skin.rgb) + way, 0.02, 0.98).tolist())) for way in ways]
        away = [remainder(one[0] - hue, 360.0) for one in near]
        saturations = [one[1] for one in near]
        low, high = span(min(saturations) - SATURATION_MARGIN, max(saturations) + SATURATION_MARGIN)
        start, end = max(min(away) - HUE_MARGIN, -WIDEST), min(max(away) + HUE_MARGIN, WIDEST)
        if low <= UNSURE_HUE:
            start, end = -WIDEST, WIDEST
        darkest = SHADED * value * (1.0 - SIGMAS * skin.spread)
        reach = (end - start) / 2, (high - low) / 2
        return cls((hue, saturation), reach, [(hue + start, hue + end, low, high)], darkest)

    def off(self, hue: float, saturation: float) -> float:
        """Return how far a colour is from the skin's, in its reach."""
        return hypot((hue - self.midpoint[0]) / self.reach[0], (saturation - self.midpoint[1]) / self.reach[1])

    def colours(self, backgrounds: Sequence[tuple[float, ...]]) -> list[Colour]:
        """Return regions of HSV; what could be a grey background, or has no sure hue, counts where it is brighter."""
        greys = [colour for colour in map(hsv, backgrounds) if colour[1] < GREY]
        brightest = BRIGHTER * max((value for _, _, value in greys), default=0.0)
        found = []
        for start, end, low, high in self.parts:
            alike = [
                BRIGHTER * value
                for hue, saturation, value in greys
                if low < saturation + SATURATION_MARGIN / 2
                and abs(remainder(hue - (start + end) / 2, 360.0)) < (end - start) / 2
            ]
            least = max(self.darkest, *alike, 0.0)
            if high > UNSURE_HUE and least < 1.0:
                found.append(Colour((start, end), (max(low, UNSURE_HUE), high), (least, 1.0)))
            if low < UNSURE_HUE and brightest < 1.0:
                found.append(Colour((0.0, 360.0), (0.0, UNSURE_HUE), (max(self.darkest, brightest), 1.0)))
        return found


def share(one: Region, other: Region) -> None:
    """Divide what two regions have in common: each colour goes to the skin that it is nearer to."""
    wrap = 360.0 * round((one.midpoint[0] - other.midpoint[0]) / 360.0)
    both = [
        (start, end, low, high)
        for a, b in product(one.parts, other.parts)
        for start, end in [(max(a[0], b[0] + wrap), min(a[1], b[1] + wrap))]
        for low, high in [(max(a[2], b[2]), min(a[3], b[3]))]
        if start < end and low < high
    ]
    for part in both:
        ours, theirs = _split(part, one, other, wrap)
        one.parts = [rest for whole in one.parts for rest in _without(whole, part)] + ours
        away: Rectangle = (part[0] - wrap, part[1] - wrap, part[2], part[3])
        other.parts = [rest for whole in other.parts for rest in _without(whole, away)] + theirs


def _split(part: Rectangle, one: Region, other: Region, wrap: float) -> tuple[list[Rectangle], list[Rectangle]]:
    """Return the cells of a rectangle that are nearer to one skin, and to the other; neighbours in a row as one."""
    ours: list[Rectangle] = []
    theirs: list[Rectangle] = []
    count = CELLS if part[1] - part[0] > NARROW[0] and part[3] - part[2] > NARROW[1] else 1
    hues, levels = np.linspace(*part[:2], count + 1), np.linspace(*part[2:], count + 1)
    for low, high in pairwise(levels):
        middle = float(low + high) / 2
        nearer = [
            one.off(hue, middle) <= other.off(hue - wrap, middle) for hue in ((hues[:-1] + hues[1:]) / 2).tolist()
        ]
        for mine, cells in groupby(range(count), key=lambda cell: nearer[cell]):
            row = list(cells)
            start, end = float(hues[row[0]]), float(hues[row[-1] + 1])
            shift = 0.0 if mine else wrap
            (ours if mine else theirs).append((start - shift, end - shift, float(low), float(high)))
    return ours, theirs


def _without(whole: Rectangle, hole: Rectangle) -> list[Rectangle]:
    """Return a rectangle less another: up to four."""
    start, end, low, high = whole
    a, b, c, d = max(start, hole[0]), min(end, hole[1]), max(low, hole[2]), min(high, hole[3])
    if a >= b or c >= d:
        return [whole]
    rest = [(start, end, low, c), (start, end, d, high), (start, a, c, d), (b, end, c, d)]
    return [part for part in rest if part[0] < part[1] and part[2] < part[3]]


def hsv(rgb: tuple[float, ...]) -> tuple[float, float, float]:
    """Return hue in degree, saturation, value."""
    hue, saturation, value = colorsys.rgb_to_hsv(*rgb)
    return 360.0 * hue, saturation, value


def span(low: float, high: float) -> tuple[float, float]:
    """Return two shares, cut to 0 and 1."""
    return max(low, 0.0), min(high, 1.0)
