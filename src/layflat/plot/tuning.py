"""Before and after a tuning: responses, shares of moves that have settled, cost over the search."""

from collections.abc import Mapping, Sequence
from math import ceil

import numpy as np
import xarray
from matplotlib.figure import Figure

from layflat.arrays import Array
from layflat.plot.runs import draw_demand, draw_response, frame_error
from layflat.plot.style import BETWEEN, HEAD, LINES, QUIET, figure, mark

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
