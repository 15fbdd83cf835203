"""Curves of the experiments: hysteresis, a cam, valve sweeps, settling over inertia, gain of the moving average."""

from collections.abc import Mapping
from math import isfinite
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from layflat.arrays import Array
from layflat.plot.style import (
    GUIDE_STYLE,
    HEAD_ROOM,
    SERIES_STYLES,
    SHADE_COLOUR,
    draw_mark,
    series_style,
    styled_figure,
)

Curve = tuple[Array, Array]
DRAWN_STRAP_LINES = 25  # of a cam


def hysteresis_curves(drawn: Mapping[str, Any]) -> Figure:
    """Draw closed curves of torque against angle, with arrows that show the direction in which they are traversed.

    Args:
        drawn: curves by label, with attributes `angle` (rad from mid-stroke, drawn in deg) and `torque` (N m).
    """
    with styled_figure() as (fig, (axes,)):
        for order, (label, curve) in enumerate(drawn.items()):
            line, half = series_style(order), len(curve.angle) // 2
            angle, torque = np.degrees(curve.angle), curve.torque
            axes.plot(np.append(angle, angle[0]), np.append(torque, torque[0]), label=label, **line)
            arrow = {"arrowstyle": "-|>", "color": line["color"], "lw": 1.2}
            for at in (int(0.55 * half), half + int(0.45 * half)):
                axes.annotate("", (angle[at + 12], torque[at + 12]), (angle[at], torque[at]), arrowprops=arrow)
        axes.set_xlabel("Output angle from mid-stroke (deg)")
        axes.set_ylabel("Torque (N m)")
        axes.set_ylim(0, 1.12 * max(float(curve.torque.max()) for curve in drawn.values()))
        axes.legend()
    return fig


def cam_procedure(cam: Any) -> Figure:
    """Draw strap lines in the frame of a `Cam`, at even angles, and the profile that they envelop: Fig. 6."""
    with styled_figure(width=5.6, height=5.6, above=HEAD_ROOM) as (fig, (axes,)):
        _draw_cam(axes, cam)
    return fig


def design_figure(torques: Mapping[str, Curve], cam: Any = None) -> Figure:
    """Draw torques (N m) over the output angle (rad) from the collapsed hose and, beside them, a `Cam` if given."""
    size = {"width": 5.6, "height": 3.8} if cam is None else {"width": 10.6, "height": 5.2}
    with styled_figure(1, 1 if cam is None else 2, **size, above=HEAD_ROOM) as (fig, (axes, *beside)):
        for order, (label, (angle, torque)) in enumerate(torques.items()):
            axes.plot(np.degrees(angle), torque, label=label, **series_style(order))
        axes.set_ylim(bottom=0.0)
        axes.set_xlabel("Output angle (deg)")
        axes.set_ylabel("Torque (N m)")
        axes.legend(loc="lower left")
        if cam is not None:
            _draw_cam(beside[0], cam)
    return fig


def _draw_cam(axes: Axes, cam: Any) -> None:
    """Draw a cam's profile, the points at which the strap leaves the shell, and strap lines, in the cam's frame, mm."""
    profile, away = 1e3 * cam.profile, 1e3 * (cam.strap_point - np.array(cam.axis))
    c, s = np.cos(cam.angle), np.sin(cam.angle)
    seen = np.stack([away[:, 0] * c + away[:, 1] * s, away[:, 1] * c - away[:, 0] * s], axis=-1)
    for i in np.searchsorted(cam.angle, np.linspace(cam.angle[0], cam.angle[-1], DRAWN_STRAP_LINES)):
        ends = np.array([seen[i], profile[i], profile[i] + 0.25 * (profile[i] - seen[i])])
        axes.plot(ends[:, 0], ends[:, 1], **{**GUIDE_STYLE, "linewidth": 0.6})
    axes.plot(seen[:, 0], seen[:, 1], label="where the strap leaves the shell", **SERIES_STYLES[1])
    axes.plot(profile[:, 0], profile[:, 1], label="cam profile", **{**SERIES_STYLES[0], "linewidth": 2.5})
    axes.plot(0.0, 0.0, "+", color="black", ms=10)
    axes.annotate("output axis", (0, 0), xytext=(0, -8), textcoords="offset points", ha="center", va="top")
    axes.set_aspect("equal")
    axes.set_xlabel("Along the cam (mm)")
    axes.set_ylabel("Across the cam (mm)")
    axes.legend(ncols=2, loc="lower center", bbox_to_anchor=(0.5, 1.0))


def valve_sweeps(sweeps: Mapping[str, tuple[Curve, Curve]]) -> Figure:
    """Draw the mean net opening of valves against command, in per cent.

    Args:
        sweeps: curves (command, opening) with rising and with falling command, as fractions, by label.
    """
    with styled_figure() as (fig, (axes,)):
        for order, (label, (up, down)) in enumerate(sweeps.items()):
            axes.plot(100 * up[0], 100 * up[1], label=label, **series_style(order))
            axes.plot(100 * down[0], 100 * down[1], **series_style(order))
        axes.set_xlabel("Command (% of full opening)")
        axes.set_ylabel("Mean net opening (% of full)")
        axes.legend()
    return fig


def settling_over_inertia(settling: Mapping[str, Mapping[float, float]], limit: float) -> Figure:
    """Draw settling time against inertia per maximum torque, on a logarithmic axis.

    Args:
        settling: settling time (s) by inertia per torque (kg m2 / (N m)), by label; one that is not finite is a cross
            above the limit.
        limit: marked duration of the runs, s.
    """
    with styled_figure() as (fig, (axes,)):
        for order, (label, times) in enumerate(settling.items()):
            style = {**series_style(order), "marker": "o", "ms": 3}
            settled = {ratio: time for ratio, time in times.items() if isfinite(time)}
            lost = [ratio for ratio, time in times.items() if not isfinite(time)]
            axes.plot(list(settled), list(settled.values()), label=label, **style)
            axes.plot(lost, [limit * (1.05 + 0.05 * order)] * len(lost), "x", color=style["color"], ms=5)
        draw_mark(axes, limit, f"end of the run, {limit:g} s")
        axes.set_xscale("log")
        axes.set_ylim(bottom=0)
        axes.set_xlabel("Inertia per maximum torque (kg m$^2$ per N m)")
        axes.set_ylabel("Time to settle within 0.3 deg (s)")
        axes.legend()
    return fig


def ratio_over_window(window: Array, ratio: Array, oscillation: float, target: tuple[float, float]) -> Figure:
    """Draw the ratio of the inertia limits of two joints over the time allowed to settle.

    Args:
        window: times allowed, (points,), s.
        ratio: ratio of the limits by settling, (points,).
        oscillation: ratio of the inertias at which oscillation is sustained.
        target: range of the ratio that is shaded.
    """
    with styled_figure() as (fig, (axes,)):
        axes.axhspan(*target, color=SHADE_COLOUR)
        axes.plot(window, ratio, label="settled within the time allowed", **SERIES_STYLES[0])
        axes.axhline(oscillation, label="no sustained oscillation", **SERIES_STYLES[1])
        axes.set_ylim(0.0, 1.5 * target[1])
        axes.set_xlabel("Time allowed to settle within 0.3 deg (s)")
        axes.set_ylabel("Ratio of the limits (1)")
        axes.legend()
    return fig


def moving_average_gain(frequency: Array, gain: Array, dither_frequency: float) -> Figure:
    """Draw the gain of the controller's moving average (dB) over frequency (Hz), with the dither frequency marked.

    Args:
        frequency: Hz, (points,).
        gain: amplitude ratio (1, not dB), (points,).
        dither_frequency: frequency of the mark, Hz.
    """
    with styled_figure() as (fig, (axes,)):
        axes.plot(frequency, 20 * np.log10(np.maximum(gain, 1e-4)), **SERIES_STYLES[0])
        draw_mark(axes, dither_frequency, f"{dither_frequency:g} Hz dither", upright=True)
        axes.set_ylim(-80, 3)
        axes.set_xlabel("Frequency (Hz)")
        axes.set_ylabel("Gain (dB)")
    return fig
