"""Bars with names, maps of a result over two parameters, and figures of studies."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from layflat.arrays import Array
from layflat.plot.style import GUIDE_STYLE, HEAD_ROOM, SERIES_STYLES, series_style, styled_figure

BAR_HATCHES = ("", "///", "...", "xxx")  # by kind of bar, distinct without colour
LETTER_WIDTH = 0.075  # of a name beside the axes, inches
COLOUR_MAP = "cividis_r"  # from light for low to dark for high values, in black and white too
NO_VALUE_STYLE = {"facecolor": "#ffffff", "edgecolor": "#bbbbbb", "hatch": "///"}  # of fields without a finite value


def draw_bars(
    axes: Axes, names: Sequence[str], values: Sequence[float], *,
    ends: Sequence[tuple[float, float]] | None = None, kinds: Sequence[int] | None = None, form: str = "{:.2g}",
) -> None:  # fmt: skip
    """Draw horizontal bars from 0, the first on top, each labelled with its value, and set both axes to fit them.

    Args:
        axes: axes to draw on.
        names: names of the bars; empty: none are written.
        values: lengths of the bars.
        ends: lower and upper end of an interval about each value.
        kinds: index of each bar's style in `BAR_HATCHES`; default: 0.
        form: format of the values.
    """
    place = np.arange(len(values))
    for i, value in enumerate(values):
        look = 0 if kinds is None else kinds[i]
        colour = SERIES_STYLES[look]["color"]
        axes.barh(i, value, 0.62, facecolor="white" if look else colour, edgecolor=colour, hatch=BAR_HATCHES[look])
        far = value
        if ends is not None:
            low, high = ends[i]
            axes.plot([low, high], [i, i], **GUIDE_STYLE, marker="|")
            far = max(value, high)
        axes.annotate(form.format(value), (far, i), xytext=(3, 0), textcoords="offset points", va="center", fontsize=8)
    axes.set_yticks(place, list(names) if names else [""] * len(place))
    axes.set_ylim(len(place) - 0.5, -0.5)
    axes.set_xlim(0.0, 1.18 * max([*values, *(high for _, high in ends or [])]) or 1.0)
    axes.grid(visible=False, axis="y")
    axes.tick_params(axis="y", length=0)


def move_figure(moves: Sequence[str], metrics: Mapping[str, Array]) -> Figure:
    """Draw metrics of moves as bars, a column for each metric; "never" replaces the bar of an infinite value or NaN.

    Args:
        moves: names of the moves.
        metrics: values, (moves,), by label with unit.
    """
    names = LETTER_WIDTH * max(map(len, moves))
    size = {"width": 1.0 + names + 2.2 * len(metrics), "height": 0.7 + 0.35 * len(moves)}
    with styled_figure(1, len(metrics), **size, beside=names - 0.5, between=0.35) as (fig, all_axes):
        for place, (axes, (label, values)) in enumerate(zip(all_axes, metrics.items(), strict=True)):
            draw_bars(axes, moves if place == 0 else (), np.nan_to_num(values, posinf=0.0).tolist())
            axes.set_xlabel(label)
            for row in np.flatnonzero(~np.isfinite(values)).tolist():
                axes.texts[row].set_text("never")
    return fig


def draw_map(axes: Axes, x: Array, y: Array, z: Array, label: str, *, low: float, high: float) -> None:
    """Draw a colour map of z over x and y, with a colour bar above; fields without a finite value are hatched.

    Args:
        axes: axes to draw on.
        x: points, (x,), about evenly spaced on the axis's scale.
        y: points, (y,), likewise.
        z: values, (y, x).
        label: label of the colour bar, with the unit.
        low: lower end of the colour bar.
        high: upper end of the colour bar; greater values have its colour.
    """
    axes.patch.set(**NO_VALUE_STYLE)
    shown = np.ma.masked_invalid(z)
    mesh = axes.pcolormesh(x, y, shown, cmap=COLOUR_MAP, vmin=low, vmax=high, shading="nearest", rasterized=True)
    axes.grid(visible=False)
    place = axes.inset_axes((0.0, 1.03, 1.0, 0.04))
    ticks = np.linspace(low, high, 5)
    bar = axes.figure.colorbar(mesh, cax=place, orientation="horizontal", extend="max", ticks=ticks, format="%.2g")
    place.xaxis.set_ticks_position("top")
    place.xaxis.set_label_position("top")
    bar.set_label(label)


def cell_edges(points: Array, *, log: bool = False) -> tuple[float, float]:
    """Return lower and upper edge of a map: half a spacing beyond its end points, on a linear or log scale."""
    scaled = np.log(points) if log else points
    ends = scaled[0] - 0.5 * (scaled[1] - scaled[0]), scaled[-1] + 0.5 * (scaled[-1] - scaled[-2])
    low, high = np.exp(ends) if log else ends
    return float(low), float(high)


MAX_BINS, MIN_RUNS_PER_BIN = 12, 8  # for medians over values that differ from run to run


def study_figure(
    varied: Mapping[str, Array], results: Mapping[str, Array], cases: Mapping[str, NDArray[np.bool_]]
) -> Figure:
    """Draw every result over every varied parameter, a dot per run, with a line through the medians of each case.

    A result that is not finite, as that of a run which does not settle, is a cross at the top, and counts as infinite.

    Args:
        varied: values of the parameters, (runs,), by label with unit.
        results: values, (runs,), by label with unit.
        cases: masks of runs, (runs,), by the name of the variant, the scenario, or both.
    """
    rows, columns = len(results), len(varied)
    width, height, above = 0.9 + 2.9 * columns, 0.7 + 2.1 * rows, HEAD_ROOM if len(cases) > 1 else 0.0
    with styled_figure(rows, columns, width=width, height=height, between=0.3, above=above) as (fig, all_axes):
        for place, axes in enumerate(all_axes):
            (label, x), (result, y) = list(varied.items())[place % columns], list(results.items())[place // columns]
            for order, (case, mask) in enumerate(cases.items()):
                _draw_case(axes, x[mask], y[mask], case, order)
            axes.set_xmargin(0.05)
            axes.tick_params(labelleft=place % columns == 0, labelbottom=place // columns == rows - 1)
            axes.set_xlabel(label if place // columns == rows - 1 else "")
            axes.set_ylabel(result if place % columns == 0 else "")
        if len(cases) > 1:
            fig.legend(*all_axes[0].get_legend_handles_labels(), loc="upper left", ncols=len(cases), fontsize=8)
    return fig


def _draw_case(axes: Axes, x: Array, y: Array, case: str, order: int) -> None:
    """Draw results y over x as dots, with medians of bins; those that are not finite are crosses at the top."""
    style = series_style(order)
    dots: dict[str, Any] = {"linestyle": "", "color": style["color"], "alpha": 0.4}
    lost = ~np.isfinite(y)
    axes.plot(x, np.where(lost, np.nan, y), marker="o", ms=2.5, **dots)
    axes.plot(x[lost], np.full(lost.sum(), 0.97), marker="x", ms=4, transform=axes.get_xaxis_transform(), **dots)
    axes.plot(*binned_medians(x, y), **style, label=case)


def binned_medians(x: Array, y: Array) -> tuple[Array, Array]:
    """Return medians of x and of y, ascending in x: at each value of x if there are at most `MAX_BINS`, else in bins.

    Bins have about equally many runs, at least `MIN_RUNS_PER_BIN`. A y that is not finite counts as infinite, the
    median of an even number is the upper one, and bins with an infinite median are left out.
    """
    distinct = np.unique(x)
    bins = max(1, min(MAX_BINS, len(x) // MIN_RUNS_PER_BIN))
    edges = distinct if len(distinct) <= MAX_BINS else np.quantile(x, np.linspace(0.0, 1.0, bins + 1)[:-1])
    which = np.searchsorted(edges, x, side="right")
    worst = np.where(np.isfinite(y), y, np.inf)
    each = np.unique(which)
    across, upward = (np.array([np.quantile(of[which == i], 0.5, method="higher") for i in each]) for of in (x, worst))
    return across[np.isfinite(upward)], upward[np.isfinite(upward)]
