"""Bars with names: one result for each of several things."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from layflat.plot.style import LINES, QUIET

if TYPE_CHECKING:
    from matplotlib.axes import Axes

HATCHES = ("", "///", "...", "xxx")  # kinds of bars, told apart without colour


def draw_bars(
    axes: Axes,
    names: Sequence[str],
    values: Sequence[float],
    *,
    ends: Sequence[tuple[float, float]] | None = None,
    kinds: Sequence[int] | None = None,
    form: str = "{:.2g}",
) -> None:
    """Draw bars to the right, the first on top, each with its value.

    Args:
        axes: to draw on.
        names: of the bars; none are written where empty.
        values: their lengths.
        ends: of an interval about each.
        kinds: number of the look of each.
        form: of the values.
    """
    place = np.arange(len(values))
    for i, value in enumerate(values):
        look = 0 if kinds is None else kinds[i]
        colour = LINES[look]["color"]
        axes.barh(i, value, 0.62, facecolor="white" if look else colour, edgecolor=colour, hatch=HATCHES[look])
        far = value
        if ends is not None:
            low, high = ends[i]
            axes.plot([low, high], [i, i], **QUIET, marker="|")
            far = max(value, high)
        axes.annotate(form.format(value), (far, i), xytext=(3, 0), textcoords="offset points", va="center", fontsize=8)
    axes.set_yticks(place, list(names) if names else [""] * len(place))
    axes.set_ylim(len(place) - 0.5, -0.5)
    axes.set_xlim(0.0, 1.18 * max([*values, *(high for _, high in ends or [])]) or 1.0)
    axes.grid(visible=False, axis="y")
    axes.tick_params(axis="y", length=0)
