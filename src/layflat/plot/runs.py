"""Figures of runs over time: angles, pressures, voltages; and logs beside their simulations.

The fitted part of a log has a white background, the validated part a grey one.
"""

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
import xarray
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from numpy.typing import NDArray

from layflat.arrays import Array
from layflat.plot.style import GUIDE_STYLE, HEAD_ROOM, SERIES_STYLES, SHADE_COLOUR, series_style, styled_figure

MAX_MARKS = 12  # marked events; more can't be distinguished
NOTE_HEIGHT = 0.17  # of a line of text about an event, inches
LABEL_SPACING = 0.09  # least distance of labels of events, over the run's duration
MIN_SPANS = (1.0, 0.5)  # least range of the axes of an angle (deg) and a voltage (V)
LEGEND_ROOM = 0.2  # above the curves, over their range
NARROW_JOINT_COUNT = 3  # number of joints from which on their axes are narrower
WARNING_LEVEL = 30  # least level of marked events, as in rcl_interfaces/msg/Log


def draw_response(axes: tuple[Axes, Axes], run: xarray.Dataset, label: str, order: int, *, since: float = 0.0) -> None:
    """Draw the response of one joint: angle, and error (angle less demand), in deg.

    Args:
        axes: axes for the angle, and for the error.
        run: run of one joint, with time, demand and angle (rad).
        label: label of the run.
        order: index of the line among the runs, for its style.
        since: time that is drawn as zero, s.
    """
    time, demand, angle = run["time"].to_numpy() - since, np.degrees(run["demand"]), np.degrees(run["angle"])
    axes[0].plot(time, angle, label=label, **series_style(order))
    axes[1].plot(time, angle - demand, label=label, **series_style(order))


def draw_demand(axes: Axes, run: xarray.Dataset, *, since: float = 0.0, named: bool = True) -> None:
    """Draw the demand of one joint.

    Args:
        axes: axes to draw on.
        run: run of one joint, with time and demand (rad).
        since: time that is drawn as zero, s.
        named: whether the legend names it.
    """
    time = run["time"].to_numpy() - since
    axes.plot(time, np.degrees(run["demand"]), label="demand" if named else None, **GUIDE_STYLE)


def set_error_frame(axes: Axes, band: float, shown: float) -> None:
    """Set the y limits and the labels of an error's axes, and shade the settling band about 0.

    Args:
        axes: axes of the error, deg.
        band: half-width of the settling band, rad.
        shown: half-range of the axes, deg.
    """
    wide = np.degrees(band)
    axes.axhspan(-wide, wide, color=SHADE_COLOUR, lw=0, label=f"±{wide:.3g} deg")
    axes.set_ylim(-shown, shown)
    axes.set_ylabel("Error (deg)")
    axes.set_xlabel("Time (s)")


def angle_figure(
    runs: Mapping[str, xarray.Dataset], joint: str, *, since: float = 0.0, band: float | None = None
) -> Figure:
    """Draw the angle of one joint in several runs, with the demand of the first run.

    Args:
        runs: runs by label.
        joint: name.
        since: time that is drawn as zero, s.
        band: half-width of a band around the demand, rad; default: none.
    """
    with styled_figure() as (fig, (axes,)):
        for order, (label, run) in enumerate(runs.items()):
            part = run.sel(joint=joint)
            time = part["time"].to_numpy() - since
            if order == 0:
                draw_demand(axes, part, since=since)
                if band is not None:
                    demand, wide = np.degrees(part["demand"].to_numpy()), np.degrees(band)
                    ends = demand - wide, demand + wide
                    axes.fill_between(time, *ends, color=SHADE_COLOUR, lw=0, label=f"demand ±{wide:.3g} deg")
            axes.plot(time, np.degrees(part["angle"]), label=label, **series_style(order))
        axes.set_xlabel("Time (s)")
        axes.set_ylabel("Angle (deg)")
        axes.legend()
    return fig


def run_figure(run: xarray.Dataset) -> Figure:
    """Draw a run: angle with demand, pressures, and control voltage of each joint.

    For a recorded run, the pressure is the sampled differential pressure, faults are shaded, and the first `MAX_MARKS`
    warnings and errors are marked and listed below by their number among the events.
    """
    joints = [str(name) for name in run["joint"].to_numpy()]
    time = run["time"].to_numpy()
    marked = _marked_events(run)
    size = {
        "width": (4.6 if len(joints) < NARROW_JOINT_COUNT else 3.2) * len(joints) + 1.0,
        "height": 6.6 + NOTE_HEIGHT * len(marked),
        "below": NOTE_HEIGHT * len(marked),
    }
    with styled_figure(3, len(joints), **size, above=HEAD_ROOM) as (fig, all_axes):
        for column, joint in enumerate(joints):
            part = run.sel(joint=joint)
            angle, pressure, voltage = (all_axes[row * len(joints) + column] for row in range(3))
            draw_demand(angle, part)
            angle.plot(time, np.degrees(part["angle"]), label="angle", **SERIES_STYLES[0])
            angle.set_title(f"{joint} joint")
            angle.set_ylabel("Angle (deg)")
            _draw_pressures(pressure, part)
            voltage.plot(time, part["voltage"], **SERIES_STYLES[0], lw=0.9)
            voltage.set_ylabel("Control voltage (V)")
            voltage.set_xlabel("Time (s)")
            _widen_limits(angle, MIN_SPANS[0])
            _widen_limits(voltage, MIN_SPANS[1])
            for axes in (angle, pressure, voltage):
                _mark_faults(axes, run, marked)
            _number_events(voltage, marked, float(time[-1] - time[0]))
            for axes in (angle, pressure):
                _legend_above(axes)
        for line, (number, text, at) in enumerate(reversed(marked)):
            note = f"{number}: at {at:.2f} s, {text}"
            fig.text(0.12 / size["width"], (0.08 + NOTE_HEIGHT * line) / size["height"], note, fontsize=8)
    return fig


def _legend_above(axes: Axes) -> None:
    """Add a legend in one row at the top of the axes, and raise their upper limit so that it is above the curves."""
    low, high = axes.get_ylim()
    axes.set_ylim(low, high + LEGEND_ROOM * (high - low))
    axes.legend(loc="upper center", ncols=len(axes.get_legend_handles_labels()[0]), columnspacing=1.0)


def _widen_limits(axes: Axes, span: float) -> None:
    """Widen the vertical limits to at least a span, so that a stationary signal looks stationary."""
    low, high = axes.get_ylim()
    if high - low < span:
        axes.set_ylim((low + high - span) / 2.0, (low + high + span) / 2.0)


def _draw_pressures(axes: Axes, part: xarray.Dataset) -> None:
    """Draw the absolute pressures of both hoses, or the measured differential pressure of a rig, in bar."""
    time = part["time"].to_numpy()
    if "pressure_a" in part:
        axes.plot(time, part["pressure_a"] / 1e5, label="hose A", **SERIES_STYLES[0])
        axes.plot(time, part["pressure_b"] / 1e5, label="hose B", **SERIES_STYLES[1])
        axes.set_ylabel("Absolute pressure (bar)")
    else:
        axes.plot(time, part["measured_pressure"] / 1e5, label="hose A less hose B", **SERIES_STYLES[0], lw=0.9)
        axes.set_ylabel("Differential pressure (bar)")


def _marked_events(run: xarray.Dataset) -> list[tuple[int, str, float]]:
    """Return index among all events (from 1), text and time (s) of the first `MAX_MARKS` warnings and errors."""
    if "event_time" not in run:
        return []
    events = zip(run["event_level"].values, run["event_text"].values, run["event_time"].values, strict=True)
    marked = [(i, str(text), float(time)) for i, (level, text, time) in enumerate(events, 1) if level >= WARNING_LEVEL]
    return marked[:MAX_MARKS]


def _mark_faults(axes: Axes, run: xarray.Dataset, marked: Sequence[tuple[int, str, float]]) -> None:
    """Shade the faults of a recorded run, and draw a line at each marked event."""
    flags = run["mode"].attrs if "mode" in run else {}
    if "flag_meanings" in flags:
        fault = flags["flag_values"][flags["flag_meanings"].split().index("fault")]
        faulty, high = run["mode"].to_numpy() == fault, axes.get_xaxis_transform()
        shade: dict[str, Any] = {"color": "#e6d3d3", "lw": 0, "zorder": 0, "label": "fault" if faulty.any() else None}
        axes.fill_between(run["time"], 0.0, 1.0, where=faulty, step="post", transform=high, **shade)
    for _, _, at in marked:
        axes.axvline(at, color="#555555", lw=0.8, ls=(0, (2, 2)))


def _number_events(axes: Axes, marked: Sequence[tuple[int, str, float]], span: float) -> None:
    """Write the events' numbers at the top; events closer than `LABEL_SPACING` of the span (s) share a label."""
    groups: list[list[tuple[int, str, float]]] = []
    for event in sorted(marked, key=lambda event: event[2]):
        if groups and event[2] - groups[-1][-1][2] < LABEL_SPACING * span:
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
    """Draw angles and demands of all joints on one pair of axes, and their errors within 2 deg below.

    `band` is the half-width of the settling band, rad.
    """
    with styled_figure(2, 1, height=4.8, above=HEAD_ROOM) as (fig, (angle, error)):
        for order, joint in enumerate(run["joint"].to_numpy()):
            part = run.sel(joint=joint)
            draw_demand(angle, part, named=order == 0)
            draw_response((angle, error), part, f"{joint} joint", order)
        angle.set_ylabel("Angle (deg)")
        angle.legend(ncols=3, loc="lower right", bbox_to_anchor=(1.0, 1.0))
        set_error_frame(error, band, 2.0)
        error.legend(handles=error.patches, loc="lower right")
    return fig


MEASURED_STYLE = {**GUIDE_STYLE, "linewidth": 2.2, "color": "#b5b5b5"}
MAX_MARKED_SAMPLES = 200  # signals with more have no markers


class ComparedSignal(NamedTuple):
    """Signal of a log beside its simulation, in the unit as shown."""

    name: str
    unit: str
    time: Array  # s
    measured: Array
    simulated: Array
    fitted: NDArray[np.bool_]  # samples that were fitted, not validated


def measured_and_simulated(signals: Sequence[ComparedSignal]) -> Figure:
    """Draw a row per signal: both on the left, the error (simulated less measured) on the right.

    The time from the first to the last sample that was not fitted is grey. Samples without a finite measurement are
    gaps in the lines; a signal of up to `MAX_MARKED_SAMPLES` finite samples has markers, and lines across its gaps.
    """
    rows = len(signals)
    with styled_figure(rows, 2, width=11.0, height=1.9 * rows + 0.9, above=HEAD_ROOM, beside=0.2, between=0.95) as (
        fig,
        axes,
    ):
        for row, signal in enumerate(signals):
            both, error = axes[2 * row], axes[2 * row + 1]
            drawn = np.isfinite(signal.measured)
            few = drawn.sum() <= MAX_MARKED_SAMPLES
            marked = {"marker": "o", "markersize": 3.5} if few else {}
            drawn |= not few  # few samples are joined across gaps, many are not
            time, measured, simulated = signal.time[drawn], signal.measured[drawn], signal.simulated[drawn]
            both.plot(time, measured, label="measured", **{**MEASURED_STYLE, **marked})
            both.plot(time, simulated, label="simulated", **{**SERIES_STYLES[0], "linewidth": 1.0})
            error.axhline(0.0, **{**GUIDE_STYLE, "linewidth": 0.8})
            error.plot(time, simulated - measured, **{**SERIES_STYLES[1], "linestyle": "-", "linewidth": 0.8})
            unit = f" ({signal.unit})" if signal.unit else ""
            both.set_ylabel(f"{signal.name.replace('_', ' ')}\n{unit.strip()}".rstrip())
            error.set_ylabel(f"error{unit}")
            if len(left := np.flatnonzero(~signal.fitted)):
                for panel in (both, error):
                    panel.axvspan(signal.time[left[0]], signal.time[left[-1]], color=SHADE_COLOUR, lw=0, zorder=0)
        handles, labels = axes[0].get_legend_handles_labels()
        if any(not signal.fitted.all() for signal in signals):
            handles.append(Patch(color=SHADE_COLOUR))
            labels.append("not fitted")
        axes[0].legend(handles, labels, loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=3, borderaxespad=0.2)
        fig.align_ylabels(axes[0::2])
        fig.align_ylabels(axes[1::2])
        for panel in axes:
            panel.margins(x=0.01)
        for panel in axes[-2:]:
            panel.set_xlabel("Time (s)")
    return fig
