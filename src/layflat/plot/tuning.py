"""Before and after a tuning: responses, shares of moves that have settled, cost over the search."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from layflat.plot.style import LINES, QUIET, figure

if TYPE_CHECKING:
    import xarray
    from matplotlib.figure import Figure

Array = NDArray[np.float64]


def responses(runs: Mapping[str, xarray.Dataset], *, band: float, since: float) -> Figure:
    """For each joint its angle with the demand in several runs, and its error, enlarged, below; `band` in rad."""
    joints = [str(name) for name in next(iter(runs.values()))["joint"].to_numpy()]
    wide = np.degrees(band)
    with figure(2, len(joints), width=4.2 * len(joints) + 1.0, height=4.8, share_x=True, head=True) as (made, all_axes):
        for column, joint in enumerate(joints):
            angle, close = all_axes[column], all_axes[column + len(joints)]
            for order, (label, run) in enumerate(runs.items()):
                part = run.sel(joint=joint)
                time, demand = part["time"].to_numpy() - since, np.degrees(part["demand"].to_numpy())
                if order == 0:
                    angle.plot(time, demand, label="demand", **QUIET)
                found = np.degrees(part["angle"].to_numpy())
                angle.plot(time, found, label=label, **LINES[order])
                close.plot(time, found - demand, label=label, **LINES[order])
            angle.set_title(f"{joint} joint", loc="left")
            angle.set_ylabel("Angle (deg)")
            close.axhspan(-wide, wide, color="#eeeeee", lw=0)
            close.set_ylim(-5.0 * wide, 5.0 * wide)
            close.set_ylabel("Error (deg)")
            close.set_xlabel("Time (s)")
        all_axes[0].legend(loc="best")
    return made


def settled_shares(settling: Mapping[str, Array], limit: float, window: float) -> Figure:
    """Share of moves that have settled over time (s); what has not by the window's end never does."""
    with figure() as (made, (axes,)):
        for order, (label, times) in enumerate(settling.items()):
            ordered = np.sort(times.ravel())
            ordered = ordered[np.isfinite(ordered)]
            share = 100.0 * np.arange(1, len(ordered) + 1) / times.size
            axes.step(
                np.append(ordered, window),
                np.append(share, share[-1:] if len(share) else 0.0),
                where="post",
                label=label,
                **LINES[order],
            )
        axes.axvline(limit, **QUIET)
        axes.annotate(f"{limit:g} s", (limit, 3.0), xytext=(4, 0), textcoords="offset points")
        axes.set_xlim(0.0, window)
        axes.set_ylim(0.0, 102.0)
        axes.set_xlabel("Time since the move began (s)")
        axes.set_ylabel("Settled (% of moves)")
        axes.legend(loc="lower right", bbox_to_anchor=(0.86, 0.0))
    return made


def cost_history(costs: Sequence[float], parts: Mapping[str, int]) -> Figure:
    """Best cost (s) after each generation; `parts` are its parts, with the generation after which each began."""
    with figure(head=len(parts) > 1) as (made, (axes,)):
        axes.step(np.arange(len(costs)), costs, where="post", **LINES[0])
        for number, begun in enumerate(parts.values()):
            if number > 0:
                axes.axvline(begun, **QUIET)
        if len(parts) > 1:
            for name, begun in parts.items():
                axes.annotate(
                    name, (begun, 1.0), xycoords=("data", "axes fraction"), xytext=(2, 2),
                    textcoords="offset points", va="bottom", fontsize=7.5, color="#555555",
                )  # fmt: skip
        axes.set_ylim(bottom=0.0)
        axes.set_xlabel("Generation (number)")
        axes.set_ylabel("Best cost so far (s)")
    return made
