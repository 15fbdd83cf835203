"""Curves of the experiments: valve sweeps, settling over inertia, response of the average."""

from __future__ import annotations

from collections.abc import Mapping
from math import isfinite
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from layflat.plot.style import LINES, figure, mark

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Curve = tuple[NDArray[np.float64], NDArray[np.float64]]


def valve_sweeps(sweeps: Mapping[str, tuple[Curve, Curve]]) -> Figure:
    """Draw the mean net opening of a valve against command, on the way up and on the way down."""
    with figure() as (made, (axes,)):
        for order, (label, (up, down)) in enumerate(sweeps.items()):
            axes.plot(100 * up[0], 100 * up[1], label=label, **LINES[order])
            axes.plot(100 * down[0], 100 * down[1], **LINES[order])
        axes.set_xlabel("Command (% of full opening)")
        axes.set_ylabel("Mean net opening (% of full)")
        axes.legend()
    return made


def settling_over_inertia(found: Mapping[str, Mapping[float, float]], limit: float) -> Figure:
    """Draw settling time against inertia per torque; crosses above the limit (s) stand for runs that do not settle."""
    with figure() as (made, (axes,)):
        for order, (label, times) in enumerate(found.items()):
            style = {**LINES[order], "marker": "o", "ms": 3}
            settled = {ratio: time for ratio, time in times.items() if isfinite(time)}
            lost = [ratio for ratio, time in times.items() if not isfinite(time)]
            axes.plot(list(settled), list(settled.values()), label=label, **style)
            axes.plot(lost, [limit * (1.05 + 0.05 * order)] * len(lost), "x", color=LINES[order]["color"], ms=5)
        mark(axes, limit, f"end of the run, {limit:g} s")
        axes.set_xscale("log")
        axes.set_ylim(bottom=0)
        axes.set_xlabel("Inertia per maximum torque (kg m$^2$ per N m)")
        axes.set_ylabel("Time to settle within 0.3 deg (s)")
        axes.legend()
    return made


def average_response(frequency: NDArray[np.float64], response: NDArray[np.float64], marked: float) -> Figure:
    """Draw the gain of the controller's average over frequency, with the dither's frequency marked."""
    with figure() as (made, (axes,)):
        axes.plot(frequency, 20 * np.log10(np.maximum(response, 1e-4)), **LINES[0])
        mark(axes, marked, f"{marked:g} Hz dither", upright=True)
        axes.set_ylim(-80, 3)
        axes.set_xlabel("Frequency (Hz)")
        axes.set_ylabel("Gain (dB)")
    return made
