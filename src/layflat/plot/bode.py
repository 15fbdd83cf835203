"""Bode plots of a linear model, of the plant that it stands for, and of the loops of a control law."""

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from matplotlib.figure import Figure

from layflat.arrays import Array
from layflat.plot.style import HEAD_ROOM, draw_mark, series_style, styled_figure


class Responses(NamedTuple):
    """Complex responses over frequencies (Hz): a line of the model, points of the plant, or either."""

    line: tuple[Array, Array]
    points: tuple[Array, Array] | None = None


def bode_figure(columns: Mapping[str, Mapping[str, Responses]]) -> Figure:
    """Draw gain and phase, a column of axes for each heading.

    Args:
        columns: responses by their label, by the label of the gain's axis, unit included; a heading that ends in "(1)"
            has a guide line at a gain of 1.
    """
    width = 1.0 + 3.6 * len(columns)
    with styled_figure(2, len(columns), width=max(width, 4.6), height=5.2, above=HEAD_ROOM) as (figure, axes):
        for i, (heading, responses) in enumerate(columns.items()):
            gains, phases = axes[i], axes[len(columns) + i]
            for order, (label, response) in enumerate(responses.items()):
                style = series_style(order)
                f, line = response.line
                gains.loglog(f, np.abs(line), label=label, **style)
                unwrapped = np.degrees(np.unwrap(np.angle(line)))
                phases.semilogx(f, unwrapped, **style)
                if response.points is not None:
                    f_p, points = response.points
                    near = np.interp(f_p, f, unwrapped)
                    angle = np.degrees(np.angle(points))
                    marks = {
                        "color": style["color"],
                        "marker": "o",
                        "linestyle": "",
                        "fillstyle": "none",
                        "markersize": 4,
                    }
                    gains.loglog(f_p, np.abs(points), **marks)
                    phases.semilogx(f_p, angle + 360.0 * np.round((near - angle) / 360.0), **marks)
            if heading.endswith("(1)"):
                draw_mark(gains, 1.0, "")
            gains.set_ylabel(heading)
            gains.legend(loc="lower left")
            phases.set_ylabel("Phase (deg)")
            phases.set_xlabel("Frequency (Hz)")
        figure.text(
            0.5,
            1.0 - 0.12 / figure.get_figheight(),
            "lines: linear model, circles: simulated plant",
            ha="center",
            va="top",
            fontsize=8,
        )
    return figure
