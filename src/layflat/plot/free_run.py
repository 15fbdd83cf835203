"""A regulated joint through logs: set-points, what was measured, and what is predicted from the set-points alone."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from layflat.plot.style import LINES, QUIET, figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Array = NDArray[np.float64]

START = 0.5
"""The frame of the pressures holds what comes after this time, s: chambers that are filled at first would fill it."""


class Shown(NamedTuple):
    """A log in SI, (samples,) each but the last: angle and both pressures as simulated, (samples, 3)."""

    time: Array
    setpoint_a: Array
    setpoint_b: Array
    angle: Array
    pressure_a: Array
    pressure_b: Array
    simulated: Array


def free_runs(logs: Mapping[str, Shown], ambient_pressure: float) -> Figure:
    """Draw set-points, pressures (gauge; from `START` on) and angle of each log: a column a log, by its title."""
    count = len(logs)
    with figure(3, count, width=4.4 * count + 1.0, height=6.6, share_x=True, head=True) as (made, all_axes):
        for column, (title, log) in enumerate(logs.items()):
            asked, pressure, angle = (all_axes[row * count + column] for row in range(3))
            for order, (name, values) in enumerate({"A": log.setpoint_a, "B": log.setpoint_b}.items()):
                line = {**LINES[order], "drawstyle": "steps-post"}
                asked.plot(log.time, 1e-3 * (values - ambient_pressure), label=f"chamber {name}", **line)
            for order, measured in enumerate((log.pressure_a, log.pressure_b)):
                label = "measured" if order == 0 else None
                pressure.plot(log.time, 1e-3 * (measured - ambient_pressure), label=label, **QUIET)
                simulated = 1e-3 * (log.simulated[:, 1 + order] - ambient_pressure)
                pressure.plot(log.time, simulated, label=f"simulated {'AB'[order]}", **LINES[order], lw=1.0)
            _frame(pressure, log, ambient_pressure)
            angle.plot(log.time, np.degrees(log.angle), label="measured", **QUIET)
            angle.plot(log.time, np.degrees(log.simulated[:, 0]), label="simulated", **LINES[0])
            asked.set_title(title)
            asked.set_ylabel("Set-point (kPa gauge)")
            pressure.set_ylabel("Pressure (kPa gauge)")
            angle.set_ylabel("Angle (deg)")
            angle.set_xlabel("Time (s)")
            for axes in (asked, angle):
                axes.legend(loc="best", fontsize=8)
            pressure.legend(loc="upper right", ncols=3, fontsize=8)
    return made


def _frame(axes: Axes, log: Shown, ambient_pressure: float) -> None:
    later = log.time >= min(START, log.time[-1])
    shown = 1e-3 * (np.stack([log.pressure_a, log.pressure_b])[:, later] - ambient_pressure)
    room = 0.15 * (shown.max() - shown.min()) + 1.0
    axes.set_ylim(shown.min() - room, shown.max() + 2.0 * room)
