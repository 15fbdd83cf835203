"""Segmentation by colour: masks of a kind's colours, and candidates of round things in them."""

from collections.abc import Sequence
from functools import lru_cache
from typing import Any

import numpy as np

from layflat.cell.extras import Array, as_rows, opencv
from layflat.cell.vision.detection import Colour

MIN_CORE_RATIO = 0.7  # of a disc's depth to the least radius: discs that are hidden in part are shallower
MIN_PEAK_DISTANCE = 0.3  # of two deepest points, fraction of the distance of touching balls


def colour_mask(hsv: Any, colours: Sequence[Colour]) -> Any:
    """Return the mask, of 0 and 255, of an HSV picture's pixels (hue of 256) in any of the regions of colours."""
    cv2 = opencv()
    bits = np.zeros(hsv.shape[:2], np.uint8)
    for table in _lookup_tables(tuple(colours)):
        hue, saturation, value = cv2.split(cv2.LUT(hsv, table))
        bits |= hue & saturation & value
    return cv2.threshold(bits, 0, 255.0, cv2.THRESH_BINARY)[1]


@lru_cache(maxsize=64)
def _lookup_tables(colours: tuple[Colour, ...]) -> tuple[Any, ...]:
    """Return lookup tables (1, 256, 3) from levels of hue, saturation and value to colours, a bit for each colour."""
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


def clean_mask(mask: Any, background: Any, area: float) -> Any:
    """Return a mask without specks, its holes filled where they are small or show no background (stalks, reflections).

    Args:
        mask: mask of 0 and 255.
        background: mask of the background's colours, of 0 and 255.
        area: area of the smallest thing, px.
    """
    cv2 = opencv()
    square = np.ones((3, 3), np.uint8)
    clean = cv2.morphologyEx(cv2.morphologyEx(mask, cv2.MORPH_OPEN, square), cv2.MORPH_CLOSE, square)
    outlines, tree = cv2.findContours(clean, cv2.RETR_CCOMP, cv2.CHAIN_APPROX_SIMPLE)
    for number in np.flatnonzero(as_rows(tree, 4)[:, 3] >= 0) if len(outlines) else ():
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


def find_discs(mask: Any, min_radius: float) -> Array:
    """Return candidates of round things in a mask of 0 and 255: rows of x, y, depth, px, deepest first.

    `min_radius` is that of the smallest, px. Depth is the distance to the nearest pixel outside: touching discs each
    have a deepest point of their own.
    """
    cv2 = opencv()
    framed = cv2.copyMakeBorder(mask, 1, 1, 1, 1, cv2.BORDER_REPLICATE)
    depth = cv2.distanceTransform(framed, cv2.DIST_L2, 5)[1:-1, 1:-1]
    reach = 2 * max(1, round(0.35 * min_radius)) + 1
    highest = cv2.dilate(depth, np.ones((reach, reach), np.uint8))
    peak = cv2.compare(depth, cv2.max(highest, MIN_CORE_RATIO * min_radius), cv2.CMP_GE)
    pixels = cv2.findNonZero(peak)
    if pixels is None:
        return np.empty((0, 3))
    x, y = as_rows(pixels).T
    peaks = np.column_stack([x, y, depth[y, x]]).astype(float)
    return suppress_neighbours(peaks[np.argsort(-peaks[:, 2], kind="stable")], MIN_PEAK_DISTANCE)


def suppress_neighbours(things: Array, share: float) -> Array:
    """Return the rows x, y, radius, ..., best first, without those that are too near to a better one.

    Touching balls on one plane are 2 sqrt(r r') apart along it; rows nearer than the fraction `share` of that go.
    """
    kept: list[int] = []
    for number, thing in enumerate(things):
        others = things[kept]
        gap = np.hypot(*(others[:, :2] - thing[:2]).T)
        if (gap >= share * 2.0 * np.sqrt(others[:, 2] * thing[2])).all():
            kept.append(number)
    return things[kept]
