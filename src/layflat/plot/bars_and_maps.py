"""Bars with names, maps of a result over two things that vary, and figures of a study made of these."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from layflat.arrays import Array
from layflat.plot.style import HEAD, LINES, QUIET, figure

HATCHES = ("", "///", "...", "xxx")  # kinds of bars, told apart without colour
COLOURS = "cividis_r"  # light is little, dark is much: also in black and white
NOTHING = {"facecolor": "#ffffff", "edgecolor": "#bbbbbb", "hatch": "///"}  # where there is no number


def draw_bars(
    axes: Axes, names: Sequence[str], values: Sequence[float], *,
    ends: Sequence[tuple[float, float]] | None = None, kinds: Sequence[int] | None = None, form: str = "{:.2g}",
) -> None:  # fmt: skip
    """Draw bars to the right, the first on top, each with its value in a format.

    No names are written where `names` is empty; `ends` are those of an interval about each, `kinds` numbers of looks.
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


def draw_map(axes: Axes, x: Array, y: Array, z: Array, label: str, *, low: float, high: float) -> None:
    """Draw colours for z (y, x) over points x and y, with a scale above; hatched where z is not a number or infinite.

    Points are evenly spaced on their axis's scale, or nearly. The scale, with its label and unit, goes from `low` to
    `high`; more is drawn alike.
    """
    axes.patch.set(**NOTHING)
    shown = np.ma.masked_invalid(z)
    mesh = axes.pcolormesh(x, y, shown, cmap=COLOURS, vmin=low, vmax=high, shading="nearest", rasterized=True)
    axes.grid(visible=False)
    place = axes.inset_axes((0.0, 1.03, 1.0, 0.04))
    ticks = np.linspace(low, high, 5)
    bar = axes.figure.colorbar(mesh, cax=place, orientation="horizontal", extend="max", ticks=ticks, format="%.2g")
    place.xaxis.set_ticks_position("top")
    place.xaxis.set_label_position("top")
    bar.set_label(label)


def edges(points: Array, *, log: bool = False) -> tuple[float, float]:
    """Return where the fields of the first and the last point end."""
    own = np.log(points) if log else points
    ends = own[0] - 0.5 * (own[1] - own[0]), own[-1] + 0.5 * (own[-1] - own[-2])
    low, high = np.exp(ends) if log else ends
    return float(low), float(high)


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
