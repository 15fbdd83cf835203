"""A study of one's own: what each result does over each thing that varies."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from layflat.arrays import Array
from layflat.plot.style import HEAD, LINES, figure

BINS, IN_BIN = 12, 8  # bins of values that differ from run to run, at most, and runs in each at least


def study_figure(
    varied: Mapping[str, Array], results: Mapping[str, Array], cases: Mapping[str, NDArray[np.bool_]]
) -> Figure:
    """Draw every result over everything that varies, a dot a run, with a line through the medians of each case.

    A result that is not finite, as that of a run which does not settle, is a cross at the top, and counts as infinite.
    Values and results, one a run, go by their labels with units; cases are variants, scenarios, or both, and tell which
    runs are theirs.
    """
    rows, columns = len(results), len(varied)
    width, height, above = 0.9 + 2.9 * columns, 0.7 + 2.1 * rows, HEAD if len(cases) > 1 else 0.0
    with figure(rows, columns, width=width, height=height, between=0.3, above=above) as (made, all_axes):
        for place, axes in enumerate(all_axes):
            (label, x), (result, y) = list(varied.items())[place % columns], list(results.items())[place // columns]
            for order, (case, own) in enumerate(cases.items()):
                _draw(axes, x[own], y[own], case, order)
            axes.set_xmargin(0.05)
            axes.tick_params(labelleft=place % columns == 0, labelbottom=place // columns == rows - 1)
            axes.set_xlabel(label if place // columns == rows - 1 else "")
            axes.set_ylabel(result if place % columns == 0 else "")
        if len(cases) > 1:
            made.legend(*all_axes[0].get_legend_handles_labels(), loc="upper left", ncols=len(cases), fontsize=8)
    return made


def _draw(axes: Axes, x: Array, y: Array, case: str, order: int) -> None:
    style = LINES[order % len(LINES)]
    dots: dict[str, Any] = {"linestyle": "", "color": style["color"], "alpha": 0.4}
    lost = ~np.isfinite(y)
    axes.plot(x, np.where(lost, np.nan, y), marker="o", ms=2.5, **dots)
    axes.plot(x[lost], np.full(lost.sum(), 0.97), marker="x", ms=4, transform=axes.get_xaxis_transform(), **dots)
    axes.plot(*medians(x, y), **style, label=case)


def medians(x: Array, y: Array) -> tuple[Array, Array]:
    """Return the median of y over x: at each value of x, or in bins of many; without infinite ones."""
    known = np.unique(x)
    bins = max(1, min(BINS, len(x) // IN_BIN))
    edges = known if len(known) <= BINS else np.quantile(x, np.linspace(0.0, 1.0, bins + 1)[:-1])
    which = np.searchsorted(edges, x, side="right")
    worst = np.where(np.isfinite(y), y, np.inf)
    each = np.unique(which)
    across, upward = (np.array([np.quantile(of[which == i], 0.5, method="higher") for i in each]) for of in (x, worst))
    return across[np.isfinite(upward)], upward[np.isfinite(upward)]
