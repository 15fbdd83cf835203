"""Bars with names, one result for each of several things, and maps, a result as colour over two things that vary."""

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes

from layflat.arrays import Array
from layflat.plot.style import LINES, QUIET

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
