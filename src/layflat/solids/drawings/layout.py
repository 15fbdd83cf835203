"""Choice of a sheet's format and scale; mm."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from layflat.solids.drawings.title import Area, free_areas

if TYPE_CHECKING:
    from layflat.solids.drawings.table import HoleTable

STANDARD_SCALES = (10.0, 5.0, 2.0, 1.0, 0.5, 0.2, 0.1, 0.05, 0.02, 0.01)
"""Scales of ISO 5455 that sheets use."""


class Layout(NamedTuple):
    """Format and scale of a sheet, and the size of its views on the part."""

    format: str
    scale: float
    area: Area


def scale_text(scale: float) -> str:
    """Return a scale as drawings state it, such as "1:2"."""
    return f"{scale:g}:1" if scale >= 1 else f"1:{1 / scale:g}"


def fitting_layout(
    needs: list[tuple[float, float, float, float]], table: HoleTable | None = None
) -> tuple[Layout, int]:
    """Return the smallest sheet and the largest scale at which one of several arrangements of views fits, and which.

    A larger sheet is taken only for a scale that is larger and at most 1:1.

    Args:
        needs: of each arrangement: width and height of the views (mm of the part), and of what is around them (mm of
            the paper).
        table: table on the right.
    """
    small, large = ((paper, *_largest_fit(needs, free_areas(paper, table))) for paper in ("A4", "A3"))
    paper, scale, k, area = small if small[1] >= min(1.0, large[1]) else large
    return Layout(paper, scale, area), k


def _largest_fit(needs: list[tuple[float, float, float, float]], areas: list[Area]) -> tuple[float, int, Area]:
    """Return the largest scale at which an arrangement fits into an area, with the arrangement and the area."""
    found = [
        (scale, -k, -n)
        for n, area in enumerate(areas)
        for k, (w, h, around_w, around_h) in enumerate(needs)
        for scale in STANDARD_SCALES
        if scale * w + around_w <= area.width and scale * h + around_h <= area.height
    ]
    scale, k, n = max(found, default=(STANDARD_SCALES[-1], 0, 0))
    return scale, -k, areas[-n]
