"""Arrangement of three views on a sheet: in a row, or the third below the first; mm."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from layflat.solids.drawings.layout import STANDARD_SCALES
from layflat.solids.drawings.paper import FORMATS
from layflat.solids.drawings.title import BLOCK_WIDTH, FRAME_MARGIN, Area, free_areas

if TYPE_CHECKING:
    from collections.abc import Sequence

    from layflat.solids.drawings.table import HoleTable

Corner = tuple[float, float]


class Arrangement(NamedTuple):
    """Format and scale of a sheet, and the upper left corner of each of three views on it."""

    format: str
    scale: float
    corners: tuple[Corner, ...]


class Around(NamedTuple):
    """Space around a view, mm on the paper."""

    before: float  # on its left and below it
    after: float  # on its right and above it

    @property
    def both(self) -> float:
        """Space on both sides."""
        return self.before + self.after


def arrange_views(
    sizes: Sequence[Corner], around: Around, table: HoleTable | None = None, formats: Sequence[str] = ("A4", "A3")
) -> Arrangement:
    """Return the arrangement of three views with the largest scale, on the smallest sheet that shows them in full size.

    Args:
        sizes: width and height of each view, mm of the part.
        around: space around each view.
        table: in the upper right corner of the sheet.
        formats: sheets to choose from, smaller ones first.
    """
    found = [_best(paper, sizes, around, table) for paper in formats]
    largest = max(one.scale for one in found)
    return next(one for one in found if one.scale >= min(1.0, largest))


def _best(paper: str, sizes: Sequence[Corner], around: Around, table: HoleTable | None) -> Arrangement:
    """Return the arrangement with the largest scale on a format."""
    for scale in STANDARD_SCALES:
        scaled = [(scale * w, scale * h) for w, h in sizes]
        for area in free_areas(paper, table):
            corners = _row(scaled, around, area) or _square(scaled, around, area, paper if table is None else "")
            if corners is not None:
                return Arrangement(paper, scale, corners)
    area = free_areas(paper, table)[0]
    return Arrangement(paper, STANDARD_SCALES[-1], ((area.left, area.high),) * 3)


def _row(sizes: Sequence[Corner], around: Around, area: Area) -> tuple[Corner, ...] | None:
    """Return the corners of views in a row in the middle of an area, or None if they do not fit."""
    width = sum(w for w, _ in sizes) + 3 * around.both
    height = max(h for _, h in sizes) + around.both
    if width > area.width or height > area.height:
        return None
    top = (area.low + area.high + height) / 2 - around.after
    corners, x = [], (area.left + area.right - width) / 2
    for w, _ in sizes:
        corners.append((x + around.before, top))
        x += w + around.both
    return tuple(corners)


def _square(sizes: Sequence[Corner], around: Around, area: Area, paper: str) -> tuple[Corner, ...] | None:
    """Return the corners of views of which the third is below the first, or None if they do not fit.

    Args:
        sizes: of the views on the paper.
        around: space around each.
        area: that is free.
        paper: format, if the first column may reach down beside the title block; else empty.
    """
    (w, h), (w_2, h_2), (w_3, h_3) = sizes
    first, second = max(w, w_3) + around.both, w_2 + around.both
    upper = max(h, h_2) + around.both
    height = upper + h_3 + around.both
    beside = bool(paper) and first <= FORMATS[paper][0] - FRAME_MARGIN - BLOCK_WIDTH - area.left
    low = FRAME_MARGIN if beside else area.low
    if first + second > area.width or height > area.high - low or upper > area.height:
        return None
    x, top = (area.left + area.right - first - second) / 2 + around.before, area.high - around.after
    if beside:
        x = min(x, FORMATS[paper][0] - FRAME_MARGIN - BLOCK_WIDTH - first + around.before)
    else:
        top = (area.low + area.high + height) / 2 - around.after
    return (x, top), (x + first, top), (x, top - upper)
