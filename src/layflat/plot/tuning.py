"""Figures of tuning and learning: responses, fractions of settled moves, cost and errors over repeats."""

from collections.abc import Mapping, Sequence
from math import ceil
from typing import NamedTuple

import numpy as np
import xarray
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from layflat.arrays import Array
from layflat.plot.runs import draw_demand, draw_response, set_error_frame
from layflat.plot.style import (
    AXES_GAPS,
    GUIDE_STYLE,
    HEAD_ROOM,
    SERIES_STYLES,
    SHADE_COLOUR,
    draw_mark,
    series_style,
    styled_figure,
)

COLUMNS = 2  # of joints
LETTER_WIDTH = 0.06  # in the names of a search's parts, inches


def response_figure(runs: Mapping[str, xarray.Dataset], *, band: float, since: float) -> Figure:
    """Draw angle with the first run's demand, and error (angle less demand) below, of each joint in several runs.

    Args:
        runs: runs of the same joints, by label.
        band: half-width of the settling band, rad.
        since: time that is drawn as zero, s.
    """
    joints = [str(name) for name in next(iter(runs.values()))["joint"].to_numpy()]
    columns = min(len(joints), COLUMNS)
    rows = ceil(len(joints) / columns)
    width, height = 4.2 * columns + 1.0, 4.2 * rows + 0.6
    between = AXES_GAPS[0], AXES_GAPS[1] if rows == 1 else HEAD_ROOM
    with styled_figure(2 * rows, columns, width=width, height=height, between=between, above=HEAD_ROOM) as (
        fig,
        all_axes,
    ):
        for place, joint in enumerate(joints):
            first = place + place // columns * columns
            angle, error = all_axes[first], all_axes[first + columns]
            for order, (label, run) in enumerate(runs.items()):
                part = run.sel(joint=joint)
                if order == 0:
                    draw_demand(angle, part, since=since)
                draw_response((angle, error), part, label, order, since=since)
            angle.set_title(f"{joint} joint", loc="left")
            angle.set_ylabel("Angle (deg)")
            set_error_frame(error, band, 5.0 * np.degrees(band))
            if place + columns < len(joints):
                error.set_xlabel("")
            else:
                error.tick_params(labelbottom=True)
        for place in range(len(joints), rows * columns):
            first = place + place // columns * columns
            all_axes[first].set_visible(False)
            all_axes[first + columns].set_visible(False)
        all_axes[0].legend(loc="best")
        all_axes[columns].legend(handles=all_axes[columns].patches, loc="lower right")
    return fig


def settled_fraction_figure(settling: Mapping[str, Array], limit: float | None, window: float) -> Figure:
    """Draw the percentage of all moves of each label that have settled, over the time since the move began.

    Args:
        settling: settling times of all moves, s, of any shape, by label; infinite or NaN for moves that do not settle.
        limit: marked time, s; default: none.
        window: duration of a move, s.
    """
    with styled_figure() as (fig, (axes,)):
        for order, (label, times) in enumerate(settling.items()):
            ordered = np.sort(times.ravel())
            ordered = ordered[np.isfinite(ordered)]
            percentage = 100.0 * np.arange(1, len(ordered) + 1) / times.size
            time, last = np.append(ordered, window), percentage[-1:] if len(percentage) else 0.0
            axes.step(time, np.append(percentage, last), where="post", label=label, **series_style(order))
        if limit is not None:
            draw_mark(axes, limit, f"{limit:.3g} s", upright=True)
        axes.set_xlim(0.0, window)
        axes.set_ylim(0.0, 102.0)
        axes.set_xlabel("Time since the move began (s)")
        axes.set_ylabel("Settled (% of moves)")
        axes.legend(loc="lower right", bbox_to_anchor=(0.86, 0.0))
    return fig


def cost_figure(costs: Sequence[float], parts: Mapping[str, int]) -> Figure:
    """Draw the best cost (s) after each generation, from the initial values on.

    `parts` are the generations after which the parts of the search began, by name; a single one is not drawn.
    """
    names = LETTER_WIDTH * max(map(len, parts)) if len(parts) > 1 else 0.0
    with styled_figure(height=3.6 + names, above=names) as (fig, (axes,)):
        axes.step(np.arange(len(costs)), costs, where="post", **SERIES_STYLES[0])
        for name, generation in parts.items() if names else ():
            axes.axvline(generation, **GUIDE_STYLE)
            axes.annotate(
                name, (generation, 1.0), xycoords=("data", "axes fraction"), xytext=(0, 2), textcoords="offset points",
                ha="center", va="bottom", rotation=90, fontsize=7.5, color="#555555",
            )  # fmt: skip
        axes.set_ylim(bottom=0.0)
        axes.set_xlabel("Generation (number)")
        axes.set_ylabel("Best cost so far (s)")
    return fig


LEARNING_WIDTH, LEARNING_HEIGHT = 9.6, 3.4  # inches
LEGEND_LINE_HEIGHT = 0.2  # inches


class RepeatErrors(NamedTuple):
    """Errors of the repeats of a motion, from the first on."""

    rms: Sequence[float]  # distance of the tip from its reference along the path, mm
    greatest: Sequence[float]  # likewise
    best_so_far: Sequence[bool]  # whether the repeat was the best so far


def learning_figure(
    time: Array, duration: float, tip: Mapping[str, Array], correction: Mapping[str, Array], repeats: RepeatErrors
) -> Figure:
    """Draw errors along the path, the correction, and errors by repeat.

    Args:
        time: instants (s) from the beginning of the motion on; before it, a correction may already act.
        duration: duration of the motion, s.
        tip: distance from its reference, (instants,), mm, by label of the repeat.
        correction: correction of the best repeat, (instants,), mrad, by joint.
        repeats: errors of all repeats.
    """
    more = LEGEND_LINE_HEIGHT * ((max(len(tip), len(correction)) - 1) // 2)  # of legends with more than two names
    with styled_figure(1, 3, width=LEARNING_WIDTH, height=LEARNING_HEIGHT + more, above=HEAD_ROOM + more) as (
        fig,
        (apart, added, counts),
    ):
        curves = (apart, tip, "Tip from its path (mm)"), (added, correction, "Correction learnt (mrad)")
        for axes, shown, label in curves:
            axes.axvspan(0.0, duration, color=SHADE_COLOUR, zorder=0)
            for order, (name, values) in enumerate(shown.items()):
                axes.plot(time, values, **series_style(order), label=name)
            axes.set_xlim(time[0], time[-1])
            axes.set_xlabel("Time (s); shaded: the motion")
            axes.set_ylabel(label)
            axes.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=2)
        apart.set_ylim(bottom=0.0)
        added.axhline(0.0, **GUIDE_STYLE)
        _draw_repeats(counts, repeats)
    return fig


def _draw_repeats(axes: Axes, repeats: RepeatErrors) -> None:
    """Draw rms and greatest errors over repeats, with filled markers for those that were the best so far."""
    number, kept = np.arange(len(repeats.rms)), np.array(repeats.best_so_far, dtype=bool)
    for values, style, marker, label in (
        (repeats.greatest, SERIES_STYLES[1], "s", "greatest"),
        (repeats.rms, SERIES_STYLES[0], "o", "rms"),
    ):
        errors = np.array(values)
        axes.plot(number, errors, **style, marker=marker, ms=5, markerfacecolor="white", label=label)
        axes.plot(number[kept], errors[kept], marker, color=style["color"], ms=5)
    axes.set_ylim(bottom=0.0)
    axes.set_xticks(number)
    axes.set_xlabel("Repeat (0: first run; filled: best so far)")
    axes.set_ylabel("Tip from its path (mm)")
    axes.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=2)
