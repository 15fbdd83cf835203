"""Runs through time: angles, pressures, voltages."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import xarray
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from layflat.plot.style import HEAD, LINES, QUIET, SHADE, figure

MOST_MARKS = 12  # events that are marked; more can't be told apart
NOTE = 0.17  # height of a line about an event, inches
CLOSE = 0.09  # share of a run's duration: labels of events that are closer than this would overlap
CALM = (1.0, 0.5)  # an angle (deg) and a voltage (V) that vary by less are shown as calm
LEGEND = 0.2  # room above the curves for a legend, over their range
MANY = 3  # joints from which on their frames are narrower
WARN = 30  # level of an event from which on it is marked, as in rcl_interfaces/msg/Log


def draw_response(axes: tuple[Axes, Axes], run: xarray.Dataset, label: str, order: int, *, since: float = 0.0) -> None:
    """Draw the angle of one joint's run on the first axes, its error on the second; time counts from `since` (s)."""
    time, demand, angle = run["time"].to_numpy() - since, np.degrees(run["demand"]), np.degrees(run["angle"])
    axes[0].plot(time, angle, label=label, **LINES[order])
    axes[1].plot(time, angle - demand, label=label, **LINES[order])


def draw_demand(axes: Axes, run: xarray.Dataset, *, since: float = 0.0, named: bool = True) -> None:
    """Draw the demand of one joint's run; time counts from `since` (s)."""
    time = run["time"].to_numpy() - since
    axes.plot(time, np.degrees(run["demand"]), label="demand" if named else None, **QUIET)


def frame_error(axes: Axes, band: float, shown: float) -> None:
    """Frame an error, `shown` (deg) to both sides, over the band (rad) within which it counts as settled."""
    wide = np.degrees(band)
    axes.axhspan(-wide, wide, color=SHADE, lw=0, label=f"±{wide:.3g} deg")
    axes.set_ylim(-shown, shown)
    axes.set_ylabel("Error (deg)")
    axes.set_xlabel("Time (s)")


def angles(runs: Mapping[str, xarray.Dataset], joint: str, *, since: float = 0.0, band: float | None = None) -> Figure:
    """Draw the angle of one joint in several runs, with the demand and, if given, a band (rad) around it."""
    with figure() as (made, (axes,)):
        for order, (label, run) in enumerate(runs.items()):
            part = run.sel(joint=joint)
            time = part["time"].to_numpy() - since
            if order == 0:
                draw_demand(axes, part, since=since)
                if band is not None:
                    demand, wide = np.degrees(part["demand"].to_numpy()), np.degrees(band)
                    ends = demand - wide, demand + wide
                    axes.fill_between(time, *ends, color=SHADE, lw=0, label=f"demand ±{wide:.3g} deg")
            axes.plot(time, np.degrees(part["angle"]), label=label, **LINES[order % len(LINES)])
        axes.set_xlabel("Time (s)")
        axes.set_ylabel("Angle (deg)")
        axes.legend()
    return made


def run_figure(run: xarray.Dataset) -> Figure:
    """Draw a whole run: for each joint its angle with demand, its pressures, and its control voltage.

    Of a recorded run the pressure is the differential one, as sampled; its faults are shaded, and
    its warnings and errors marked, and listed below by their number among its events.
    """
    joints = [str(name) for name in run["joint"].to_numpy()]
    time = run["time"].to_numpy()
    marked = _marked(run)
    size = {
        "width": (4.6 if len(joints) < MANY else 3.2) * len(joints) + 1.0,
        "height": 6.6 + NOTE * len(marked),
        "below": NOTE * len(marked),
    }
    with figure(3, len(joints), **size, above=HEAD) as (made, all_axes):
        for column, joint in enumerate(joints):
            part = run.sel(joint=joint)
            angle, pressure, voltage = (all_axes[row * len(joints) + column] for row in range(3))
            draw_demand(angle, part)
            angle.plot(time, np.degrees(part["angle"]), label="angle", **LINES[0])
            angle.set_title(f"{joint} joint")
            angle.set_ylabel("Angle (deg)")
            _pressures(pressure, part)
            voltage.plot(time, part["voltage"], **LINES[0], lw=0.9)
            voltage.set_ylabel("Control voltage (V)")
            voltage.set_xlabel("Time (s)")
            _no_closer(angle, CALM[0])
            _no_closer(voltage, CALM[1])
            for axes in (angle, pressure, voltage):
                _mark_faults(axes, run, marked)
            _number(voltage, marked, float(time[-1] - time[0]))
            for axes in (angle, pressure):
                _legend_above(axes)
        for line, (number, text, at) in enumerate(reversed(marked)):
            note = f"{number}: at {at:.2f} s, {text}"
            made.text(0.12 / size["width"], (0.08 + NOTE * line) / size["height"], note, fontsize=8)
    return made


def _legend_above(axes: Axes) -> None:
    """Put a legend in a row above the curves, where it covers none of them."""
    low, high = axes.get_ylim()
    axes.set_ylim(low, high + LEGEND * (high - low))
    axes.legend(loc="upper center", ncols=len(axes.get_legend_handles_labels()[0]), columnspacing=1.0)


def _no_closer(axes: Axes, span: float) -> None:
    """Show no less than a span across, so that what is at rest looks at rest."""
    low, high = axes.get_ylim()
    if high - low < span:
        axes.set_ylim((low + high - span) / 2.0, (low + high + span) / 2.0)


def _pressures(axes: Axes, part: xarray.Dataset) -> None:
    """Draw the pressures of a joint: of both hoses, or what a rig knows of them."""
    time = part["time"].to_numpy()
    if "pressure_a" in part:
        axes.plot(time, part["pressure_a"] / 1e5, label="hose A", **LINES[0])
        axes.plot(time, part["pressure_b"] / 1e5, label="hose B", **LINES[1])
        axes.set_ylabel("Absolute pressure (bar)")
    else:
        axes.plot(time, part["measured_pressure"] / 1e5, label="hose A less hose B", **LINES[0], lw=0.9)
        axes.set_ylabel("Differential pressure (bar)")


def _marked(run: xarray.Dataset) -> list[tuple[int, str, float]]:
    """Return number in the list of events, text and time of the events that are marked: warnings and errors."""
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


def _number(axes: Axes, marked: Sequence[tuple[int, str, float]], span: float) -> None:
    """Write the events' numbers at the top; those that lie too close together share one label."""
    groups: list[list[tuple[int, str, float]]] = []
    for event in sorted(marked, key=lambda event: event[2]):
        if groups and event[2] - groups[-1][-1][2] < CLOSE * span:
            groups[-1].append(event)
        else:
            groups.append([event])
    style: dict[str, Any] = {"fontsize": 8, "ha": "center", "bbox": {"pad": 1.5, "facecolor": "white", "lw": 0}}
    for group in groups:
        numbers, times = sorted(number for number, _, _ in group), [at for _, _, at in group]
        text = f"{numbers[0]}–{numbers[-1]}" if len(group) > 1 else str(numbers[0])
        place: dict[str, Any] = {"xycoords": axes.get_xaxis_transform(), "textcoords": "offset points"}
        axes.annotate(text, ((times[0] + times[-1]) / 2, 1.0), (0.0, -8.0), **place, **style)


def arm_steps(run: xarray.Dataset, *, band: float) -> Figure:
    """Draw the angles of all joints in one frame, with their demands, and their errors, enlarged, below.

    `band` (rad) is that within which a joint has settled.
    """
    with figure(2, 1, height=4.8, above=HEAD) as (made, (angle, error)):
        for order, joint in enumerate(run["joint"].to_numpy()):
            part = run.sel(joint=joint)
            draw_demand(angle, part, named=order == 0)
            draw_response((angle, error), part, f"{joint} joint", order)
        angle.set_ylabel("Angle (deg)")
        angle.legend(ncols=3, loc="lower right", bbox_to_anchor=(1.0, 1.0))
        frame_error(error, band, 2.0)
        error.legend(handles=error.patches, loc="lower right")
    return made
