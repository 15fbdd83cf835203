"""Maps: a result as colour over two things that vary."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from layflat.arrays import Array

if TYPE_CHECKING:
    from matplotlib.axes import Axes

COLOURS = "cividis_r"  # light is little, dark is much: also in black and white

NOTHING = {"facecolor": "#ffffff", "edgecolor": "#bbbbbb", "hatch": "///"}
"""Where there is no number."""


def draw_map(axes: Axes, x: Array, y: Array, z: Array, label: str, *, low: float, high: float) -> None:
    """Draw colours for z (y, x) over points x and y, with a scale above; hatched where z is not a number or infinite.

    Args:
        axes: to draw on.
        x: across; evenly spaced on the axis's scale, or nearly.
        y: upward.
        z: what is shown, (y, x).
        label: of the scale, with unit.
        low: what the scale begins with.
        high: what it ends with; more is drawn alike.
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
