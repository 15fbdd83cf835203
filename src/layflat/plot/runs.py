"""Runs through time: angles, pressures, voltages."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from layflat.plot.style import LINES, QUIET, figure

if TYPE_CHECKING:
    import xarray
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

WARN = 30
"""Level of an event from which on it is marked, as in rcl_interfaces/msg/Log."""


def angles(runs: Mapping[str, xarray.Dataset], joint: str, *, since: float = 0.0, band: float | None = None) -> Figure:
    """The angle of one joint in several runs, with the demand and, if given, a band (rad) around it."""
    with figure() as (made, (axes,)):
        for order, (label, run) in enumerate(runs.items()):
            part = run.sel(joint=joint)
            time = part["time"].to_numpy() - since
            if order == 0:
                demand = np.degrees(part["demand"].to_numpy())
                axes.plot(time, demand, label="demand", **QUIET)
                if band is not None:
                    wide = np.degrees(band)
                    axes.fill_between(time, demand - wide, demand + wide, color="#eeeeee", lw=0)
            axes.plot(time, np.degrees(part["angle"]), label=label, **LINES[order % len(LINES)])
        axes.set_xlabel("Time (s)")
        axes.set_ylabel("Angle (deg)")
        axes.legend()
    return made


def run_figure(run: xarray.Dataset) -> Figure:
    """A whole run: for each joint its angle with demand, its pressures, and its control voltage.

    Of a recorded run the pressure is the differential one, as sampled; its faults are shaded, and
    its warnings and errors marked, and listed below by their number among its events.
    """
    joints = [str(name) for name in run["joint"].to_numpy()]
    time = run["time"].to_numpy()
    marked = _marked(run)
    size = {"width": 4.6 * len(joints) + 1.0, "height": 6.6 + NOTE * len(marked), "below": NOTE * len(marked)}
    with figure(3, len(joints), **size, share_x=True, head=True) as (made, all_axes):
        for column, joint in enumerate(joints):
            part = run.sel(joint=joint)
            angle, pressure, voltage = (all_axes[row * len(joints) + column] for row in range(3))
            angle.plot(time, np.degrees(part["demand"]), label="demand", **QUIET)
            angle.plot(time, np.degrees(part["angle"]), label="angle", **LINES[0])
            angle.set_title(f"{joint} joint")
            angle.set_ylabel("Angle (deg)")
            _pressures(pressure, part)
            voltage.plot(time, part["voltage"], **LINES[0], lw=0.9)
            voltage.set_ylabel("Control voltage (V)")
            voltage.set_xlabel("Time (s)")
            for axes in (angle, pressure, voltage):
                _mark_faults(axes, run, marked)
            _number(voltage, marked)
            for axes in (angle, pressure):
                axes.legend(loc="best")
        for line, (number, text, at) in enumerate(reversed(marked)):
            note = f"{number}: at {at:.2f} s, {text}"
            made.text(0.12 / size["width"], (0.08 + NOTE * line) / size["height"], note, fontsize=8)
    return made


def _pressures(axes: Axes, part: xarray.Dataset) -> None:
    """Pressures of a joint: of both hoses, or what a rig knows of them."""
    time = part["time"].to_numpy()
    if "pressure_a" in part:
        axes.plot(time, part["pressure_a"] / 1e5, label="hose A", **LINES[0])
        axes.plot(time, part["pressure_b"] / 1e5, label="hose B", **LINES[1])
        axes.set_ylabel("Absolute pressure (bar)")
    else:
        axes.plot(time, part["measured_pressure"] / 1e5, label="hose A less hose B", **LINES[0], lw=0.9)
        axes.set_ylabel("Differential pressure (bar)")


MOST_MARKS = 12
"""Events that are marked; more can't be told apart."""

NOTE = 0.17
"""Height of a line about an event, inches."""


def _marked(run: xarray.Dataset) -> list[tuple[int, str, float]]:
    """Number in the list of events, text and time of the events that are marked: warnings and errors."""
    if "event_time" not in run:
        return []
    told = zip(run["event_level"].values, run["event_text"].values, run["event_time"].values, strict=True)
    marked = [(i, str(text), float(at)) for i, (level, text, at) in enumerate(told, 1) if level >= WARN]
    return marked[:MOST_MARKS]


def _mark_faults(axes: Axes, run: xarray.Dataset, marked: Sequence[tuple[int, str, float]]) -> None:
    """Shade where a recorded run was stopped by a fault, and draw a line at each event that is marked."""
    flags = run["mode"].attrs if "mode" in run else {}
    if "flag_meanings" in flags:
        fault = flags["flag_values"][flags["flag_meanings"].split().index("fault")]
        faulty, high = run["mode"].to_numpy() == fault, axes.get_xaxis_transform()
        shade: dict[str, Any] = {"color": "#e6d3d3", "lw": 0, "zorder": 0, "label": "fault" if faulty.any() else None}
        axes.fill_between(run["time"], 0.0, 1.0, where=faulty, step="post", transform=high, **shade)
    for _, _, at in marked:
        axes.axvline(at, color="#555555", lw=0.8, ls=(0, (2, 2)))


def _number(axes: Axes, marked: Sequence[tuple[int, str, float]]) -> None:
    """Write the events' numbers at the top."""
    style: dict[str, Any] = {"fontsize": 8, "ha": "center", "bbox": {"pad": 1.5, "facecolor": "white", "lw": 0}}
    for number, _, at in marked:
        place: dict[str, Any] = {"xycoords": axes.get_xaxis_transform(), "textcoords": "offset points"}
        axes.annotate(str(number), (at, 1.0), (0.0, -8.0), **place, **style)


def arm_steps(run: xarray.Dataset) -> Figure:
    """Angles of all joints in one frame, with their demands, and their errors, enlarged, below."""
    joints = [str(name) for name in run["joint"].to_numpy()]
    time = run["time"].to_numpy()
    with figure(2, 1, height=4.8, share_x=True, head=True) as (made, (angle, close)):
        for order, joint in enumerate(joints):
            part = run.sel(joint=joint)
            angle.plot(time, np.degrees(part["demand"]), label="demand" if order == 0 else None, **QUIET)
            angle.plot(time, np.degrees(part["angle"]), label=f"{joint} joint", **LINES[order])
            error = np.degrees(part["angle"] - part["demand"])
            close.plot(time, error, label=f"{joint} joint", **LINES[order])
        angle.set_ylabel("Angle (deg)")
        angle.legend(ncols=3, loc="lower right", bbox_to_anchor=(1.0, 1.0))
        close.set_ylim(-2.0, 2.0)
        close.axhspan(-0.3, 0.3, color="#eeeeee", lw=0)
        close.set_ylabel("Error (deg)")
        close.set_xlabel("Time (s)")
    return made
