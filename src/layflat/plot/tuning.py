"""Before and after a tuning or a learning: responses, shares of moves that have settled, cost and errors over time."""

from collections.abc import Mapping, Sequence
from math import ceil
from typing import NamedTuple

import numpy as np
import xarray
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from layflat.arrays import Array
from layflat.plot.runs import draw_demand, draw_response, frame_error
from layflat.plot.style import BETWEEN, HEAD, LINES, QUIET, SHADE, figure, mark

COLUMNS = 2  # joints beside each other
LETTER = 0.06  # width of a letter in the names of a search's parts, inches


def responses(runs: Mapping[str, xarray.Dataset], *, band: float, since: float) -> Figure:
    """Draw for each joint its angle with the demand in several runs, and its error, enlarged, below; `band` in rad."""
    joints = [str(name) for name in next(iter(runs.values()))["joint"].to_numpy()]
    columns = min(len(joints), COLUMNS)
    rows = ceil(len(joints) / columns)
    width, height = 4.2 * columns + 1.0, 4.2 * rows + 0.6
    between = BETWEEN[0], BETWEEN[1] if rows == 1 else HEAD
    with figure(2 * rows, columns, width=width, height=height, between=between, above=HEAD) as (made, all_axes):
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
            frame_error(error, band, 5.0 * np.degrees(band))
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
    return made


def settled_shares(settling: Mapping[str, Array], limit: float | None, window: float) -> Figure:
    """Draw the share of moves that have settled over time (s); what has not by the window's end never does."""
    with figure() as (made, (axes,)):
        for order, (label, times) in enumerate(settling.items()):
            ordered = np.sort(times.ravel())
            ordered = ordered[np.isfinite(ordered)]
            share = 100.0 * np.arange(1, len(ordered) + 1) / times.size
            time, last = np.append(ordered, window), share[-1:] if len(share) else 0.0
            axes.step(time, np.append(share, last), where="post", label=label, **LINES[order])
        if limit is not None:
            mark(axes, limit, f"{limit:.3g} s", upright=True)
        axes.set_xlim(0.0, window)
        axes.set_ylim(0.0, 102.0)
        axes.set_xlabel("Time since the move began (s)")
        axes.set_ylabel("Settled (% of moves)")
        axes.legend(loc="lower right", bbox_to_anchor=(0.86, 0.0))
    return made


def cost_history(costs: Sequence[float], parts: Mapping[str, int]) -> Figure:
    """Draw the best cost (s) after each generation; the first belongs to the gains that the search began with.

    The search's parts, each with the generation after which it began, are named there.
    """
    names = LETTER * max(map(len, parts)) if len(parts) > 1 else 0.0
    with figure(height=3.6 + names, above=names) as (made, (axes,)):
        axes.step(np.arange(len(costs)), costs, where="post", **LINES[0])
        for name, begun in parts.items() if names else ():
            axes.axvline(begun, **QUIET)
            axes.annotate(
                name, (begun, 1.0), xycoords=("data", "axes fraction"), xytext=(0, 2), textcoords="offset points",
                ha="center", va="bottom", rotation=90, fontsize=7.5, color="#555555",
            )  # fmt: skip
        axes.set_ylim(bottom=0.0)
        axes.set_xlabel("Generation (number)")
        axes.set_ylabel("Best cost so far (s)")
    return made


WIDTH, HIGH = 9.6, 3.4  # inches
LINE = 0.2  # of a legend, inches


class Repeats(NamedTuple):
    """Repeats from the first on."""

    rms: Sequence[float]  # distance of the tip along the path, mm
    most: Sequence[float]
    kept: Sequence[bool]  # whether it was the best so far


def learning_figure(
    time: Array, duration: float, tip: Mapping[str, Array], correction: Mapping[str, Array], repeats: Repeats
) -> Figure:
    """Draw errors along the path, the correction, and errors by repeat.

    Args:
        time: instants (s) from the beginning of the motion on; before it, a correction may already act.
        duration: of the motion, s.
        tip: its distance from where it should be, (instants,), mm, by what a repeat is called.
        correction: of the best one, (instants,), mrad, by joint.
        repeats: all of them.
    """
    more = LINE * ((max(len(tip), len(correction)) - 1) // 2)  # of legends with more than two names
    with figure(1, 3, width=WIDTH, height=HIGH + more, above=HEAD + more) as (made, (apart, added, counts)):
        curves = (apart, tip, "Tip from its path (mm)"), (added, correction, "Correction learnt (mrad)")
        for axes, shown, label in curves:
            axes.axvspan(0.0, duration, color=SHADE, zorder=0)
            for (name, values), style in zip(shown.items(), LINES[: len(shown)], strict=True):
                axes.plot(time, values, **style, label=name)
            axes.set_xlim(time[0], time[-1])
            axes.set_xlabel("Time (s); shaded: the motion")
            axes.set_ylabel(label)
            axes.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=2)
        apart.set_ylim(bottom=0.0)
        added.axhline(0.0, **QUIET)
        _draw_repeats(counts, repeats)
    return made


def _draw_repeats(axes: Axes, repeats: Repeats) -> None:
    """Draw rms and greatest errors over repeats; those that were the best so far are filled."""
    number, kept = np.arange(len(repeats.rms)), np.array(repeats.kept, dtype=bool)
    for values, style, marker, label in (
        (repeats.most, LINES[1], "s", "greatest"),
        (repeats.rms, LINES[0], "o", "rms"),
    ):
        of = np.array(values)
        axes.plot(number, of, **style, marker=marker, ms=5, markerfacecolor="white", label=label)
        axes.plot(number[kept], of[kept], marker, color=style["color"], ms=5)
    axes.set_ylim(bottom=0.0)
    axes.set_xticks(number)
    axes.set_xlabel("Repeat (0: first run; filled: best so far)")
    axes.set_ylabel("Tip from its path (mm)")
    axes.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=2)
