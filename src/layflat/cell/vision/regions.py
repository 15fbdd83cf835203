"""Which pixels have a kind's colour, and where in them round things may be."""

from collections.abc import Sequence
from functools import lru_cache
from typing import Any

import numpy as np

from layflat.cell.extras import opencv, points
from layflat.cell.vision.boards import Array
from layflat.cell.vision.detection import Colour

LEAST_CORE = 0.7  # a disc's depth of the least radius from which it may be one: what is hidden in part is shallower
PEAKS_APART = 0.3  # how far two deepest points are apart at least, as a share of the distance of balls that touch


def in_colours(hsv: Any, colours: Sequence[Colour]) -> Any:
    """Return the pixels of an HSV picture (hue of 256) in any of some regions of colours, as a mask of 0 and 255."""
    cv2 = opencv()
    found = np.zeros(hsv.shape[:2], np.uint8)
    for table in _tables(tuple(colours)):
        hue, saturation, value = cv2.split(cv2.LUT(hsv, table))
        found |= hue & saturation & value
    return cv2.threshold(found, 0, 255.0, cv2.THRESH_BINARY)[1]


@lru_cache(maxsize=64)
def _tables(colours: tuple[Colour, ...]) -> tuple[Any, ...]:
    """Return tables (1, 256, 3) of what colours each level of hue, saturation and value may be, a bit a colour."""
    levels = np.arange(256.0)
    tables = []
    for start in range(0, len(colours), 8):
        table = np.zeros((1, 256, 3), np.uint8)
        for bit, colour in enumerate(colours[start : start + 8]):
            low, high = (edge % 360.0 / 360.0 * 255.0 for edge in colour.hue)
            inside = (levels >= low) & (levels <= high) if low <= high else (levels >= low) | (levels <= high)
            if colour.hue[1] - colour.hue[0] >= 360.0:
                inside[:] = True
            spans = [
                (levels >= 255.0 * low) & (levels <= 255.0 * high) for low, high in (colour.saturation, colour.value)
            ]
            table[0] |= np.stack([inside, *spans], axis=-1).astype(np.uint8) << bit
        tables.append(table)
    return tuple(tables)


def filled(mask: Any, background: Any, area: float) -> Any:
    """Return a mask without specks, its holes filled where they are small or show no background (stalks, reflections).

    Masks are of 0 and 255; `area` is that of the smallest thing, px.
    """
    cv2 = opencv()
    square = np.ones((3, 3), np.uint8)
    clean = cv2.morphologyEx(cv2.morphologyEx(mask, cv2.MORPH_OPEN, square), cv2.MORPH_CLOSE, square)
    outlines, tree = cv2.findContours(clean, cv2.RETR_CCOMP, cv2.CHAIN_APPROX_SIMPLE)
    for number in np.flatnonzero(points(tree, 4)[:, 3] >= 0) if len(outlines) else ():
        x, y, wide, high = cv2.boundingRect(outlines[number])
        if wide * high > 2.0 * area:
            continue
        box = np.s_[y : y + high, x : x + wide]
        hole = cv2.drawContours(np.zeros((high, wide), np.uint8), outlines, int(number), 255, -1, offset=(-x, -y))
        hole &= ~clean[box]
        size = cv2.countNonZero(hole)
        if size < 0.05 * area or cv2.countNonZero(background[box] & hole) < 0.3 * size:
            clean[box] |= hole
    return clean


def discs(mask: Any, least: float) -> Array:
    """Return where round things may be in a mask of 0 and 255: rows of x, y, depth, px, deepest first.

    `least` is the radius of the smallest, px. Depth is the distance to the nearest pixel outside: touching discs each
    have a deepest point of their own.
    """
    cv2 = opencv()
    framed = cv2.copyMakeBorder(mask, 1, 1, 1, 1, cv2.BORDER_REPLICATE)
    depth = cv2.distanceTransform(framed, cv2.DIST_L2, 5)[1:-1, 1:-1]
    reach = 2 * max(1, round(0.35 * least)) + 1
    highest = cv2.dilate(depth, np.ones((reach, reach), np.uint8))
    peak = cv2.compare(depth, cv2.max(highest, LEAST_CORE * least), cv2.CMP_GE)
    at = cv2.findNonZero(peak)
    if at is None:
        return np.empty((0, 3))
    x, y = points(at).T
    found = np.column_stack([x, y, depth[y, x]]).astype(float)
    return apart(found[np.argsort(-found[:, 2], kind="stable")], PEAKS_APART)


def apart(found: Array, share: float) -> Array:
    """Return, of things as rows x, y, radius, ..., best first, those that are not where a better one is.

    Balls on one plane that touch are 2 sqrt(r r') apart along it; nearer ones by less than `share` of that go.
    """
    kept: list[int] = []
    for number, thing in enumerate(found):
        others = found[kept]
        gap = np.hypot(*(others[:, :2] - thing[:2]).T)
        if (gap >= share * 2.0 * np.sqrt(others[:, 2] * thing[2])).all():
            kept.append(number)
    return found[kept]
