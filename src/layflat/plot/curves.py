"""Curves of the experiments: hysteresis, a cam, valve sweeps, settling over inertia, response of the average."""

from collections.abc import Mapping
from math import isfinite
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from layflat.arrays import Array
from layflat.plot.style import HEAD, LINES, QUIET, SHADE, figure, mark

Curve = tuple[Array, Array]
SHOWN = 25  # strap lines of a cam that are drawn


def hysteresis_curves(drawn: Mapping[str, Any]) -> Figure:
    """Draw closed curves of torque (N m) against angle (rad) in one frame, with arrows that show their sense."""
    with figure() as (made, (axes,)):
        for order, (label, curve) in enumerate(drawn.items()):
            line, half = LINES[order % len(LINES)], len(curve.angle) // 2
            angle, torque = np.degrees(curve.angle), curve.torque
            axes.plot(np.append(angle, angle[0]), np.append(torque, torque[0]), label=label, **line)
            arrow = {"arrowstyle": "-|>", "color": line["color"], "lw": 1.2}
            for at in (int(0.55 * half), half + int(0.45 * half)):
                axes.annotate("", (angle[at + 12], torque[at + 12]), (angle[at], torque[at]), arrowprops=arrow)
        axes.set_xlabel("Output angle from mid-stroke (deg)")
        axes.set_ylabel("Torque (N m)")
        axes.set_ylim(0, 1.12 * max(float(curve.torque.max()) for curve in drawn.values()))
        axes.legend()
    return made


def cam_procedure(cam: Any) -> Figure:
    """Draw strap lines in the frame of a `Cam`, at even angles, and the profile that they envelop: Fig. 6."""
    profile, away = 1e3 * cam.profile, 1e3 * (cam.strap_point - np.array(cam.axis))
    c, s = np.cos(cam.angle), np.sin(cam.angle)
    seen = np.stack([away[:, 0] * c + away[:, 1] * s, away[:, 1] * c - away[:, 0] * s], axis=-1)
    with figure(width=5.6, height=5.6, above=HEAD) as (made, (axes,)):
        for i in np.searchsorted(cam.angle, np.linspace(cam.angle[0], cam.angle[-1], SHOWN)):
            ends = np.array([seen[i], profile[i], profile[i] + 0.25 * (profile[i] - seen[i])])
            axes.plot(ends[:, 0], ends[:, 1], **{**QUIET, "linewidth": 0.6})
        axes.plot(seen[:, 0], seen[:, 1], label="where the strap leaves the shell", **LINES[1])
        axes.plot(profile[:, 0], profile[:, 1], label="cam profile", **{**LINES[0], "linewidth": 2.5})
        axes.plot(0.0, 0.0, "+", color="black", ms=10)
        axes.annotate("output axis", (0, 0), xytext=(0, -8), textcoords="offset points", ha="center", va="top")
        axes.set_aspect("equal")
        axes.set_xlabel("Along the cam (mm)")
        axes.set_ylabel("Across the cam (mm)")
        axes.legend(ncols=2, loc="lower center", bbox_to_anchor=(0.5, 1.0))
    return made


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


def ratio_over_window(window: Array, ratio: Array, oscillation: float, wanted: tuple[float, float]) -> Figure:
    """Draw how many times as much one joint carries as another against the time allowed (s), and the wanted range.

    `oscillation` is the same of the inertias at which oscillation is sustained.
    """
    with figure() as (made, (axes,)):
        axes.axhspan(*wanted, color=SHADE)
        axes.plot(window, ratio, label="settled within the time allowed", **LINES[0])
        axes.axhline(oscillation, label="no sustained oscillation", **LINES[1])
        axes.set_ylim(0.0, 1.5 * wanted[1])
        axes.set_xlabel("Time allowed to settle within 0.3 deg (s)")
        axes.set_ylabel("Ratio of the limits (1)")
        axes.legend()
    return made


def average_response(frequency: Array, response: Array, marked: float) -> Figure:
    """Draw the gain of the controller's average over frequency, with the dither's frequency marked."""
    with figure() as (made, (axes,)):
        axes.plot(frequency, 20 * np.log10(np.maximum(response, 1e-4)), **LINES[0])
        mark(axes, marked, f"{marked:g} Hz dither", upright=True)
        axes.set_ylim(-80, 3)
        axes.set_xlabel("Frequency (Hz)")
        axes.set_ylabel("Gain (dB)")
    return made
