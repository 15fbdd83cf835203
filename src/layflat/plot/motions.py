"""Planned motions: the way of the tip, seen from one side or two, and joints through time with their limits."""

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from layflat.arrays import Array
from layflat.plot.style import BETWEEN, HEAD, LINES, QUIET, SHADE, figure

SIDE = {1: 3.95, 2: 2.75}  # of a view of the tip's way, by how many there are, inches
LABELS = 0.95  # beside it
COLUMN = {1: 3.3, 2: 2.7}  # width of a joint's frames, likewise, inches
HIGH = {1: 6.2, 2: 7.9}  # inches
APART = 0.55  # of one view from the other, inches
LIMIT: dict[str, Any] = {"color": "#555555", "linestyle": (0, (4, 2)), "linewidth": 1.0}


class Curve(NamedTuple):
    """A quantity over time, and the limits within which it has to stay."""

    values: Array
    least: float
    most: float


class Joint(NamedTuple):
    """What a joint does."""

    angle: Curve  # deg
    velocity: Curve  # deg/s
    torque: Curve  # N m


class View(NamedTuple):
    """What is seen along one direction, in m."""

    axes: str  # what is across and what is upright, such as "xy"
    tip: Array  # (instants, 2)
    reach: Sequence[Array]  # outlines of where the tip can go, (points, 2) each
    arms: Sequence[Array]  # joints and tip at the beginning and at the end, (points, 2) each
    left: Sequence[Array]  # where targets leave the reach, (2,) each
    outline: str = "reach"  # what the outlines are


def motion_figure(time: Array, begins: Array, views: Sequence[View], joints: Mapping[str, Joint]) -> Figure:
    """Draw a motion, seen from one side or two: times of its instants, and when its segments begin, in s."""
    side, column, high = (of[len(views)] for of in (SIDE, COLUMN, HIGH))
    beside = side + LABELS
    width = beside + BETWEEN[0] + column * len(joints)
    with figure(3, len(joints), width=width, height=high, above=HEAD, beside=beside) as (made, all_axes):
        for row, view in enumerate(views):
            below = high - HEAD - 0.12 - (row + 1) * side - row * APART
            _draw_view(made.add_axes((0.75 / width, below / high, side / width, side / high)), time, begins, view)
        _legend(made.axes[-1])
        for column, (name, joint) in enumerate(joints.items()):
            labels = ("Angle (deg)", "Velocity (deg/s)", "Torque of the hoses (N m)")
            for row, (curve, label) in enumerate(zip(joint, labels, strict=True)):
                axes = all_axes[row * len(joints) + column]
                _draw_curve(axes, time, begins, curve)
                if column == 0:
                    axes.set_ylabel(label)
            all_axes[column].set_title(f"{name} joint", pad=16)
            _number(all_axes[column], begins, float(time[-1]))
            all_axes[2 * len(joints) + column].set_xlabel("Time (s)")
    return made


def _draw_view(axes: Axes, time: Array, begins: Array, view: View) -> None:
    for order, outline in enumerate(view.reach):
        if np.allclose(outline[0], outline[-1]):
            axes.fill(*outline.T, color=SHADE, lw=0)
        axes.plot(*outline.T, **QUIET, label=view.outline if order == 0 else None)
    for arm, style, label in zip(view.arms, ("-", (0, (2, 1))), ("at the start", "at the end"), strict=True):
        axes.plot(*arm.T, color="#9a9a9a", lw=2.5, ls=style, marker="o", ms=5, label=f"arm {label}")
    axes.plot(*view.tip.T, **LINES[0], label="path of the tip")
    ends = np.append(begins[1:], time[-1])
    for number, (begin, end) in enumerate(zip(begins, ends, strict=True), 1):
        part = view.tip[(time >= begin) & (time <= end)]
        if len(part) and np.ptp(part, axis=0).max() > 0.0:
            _tag(axes, part[len(part) // 2], str(number))
    for place in view.left:
        axes.plot(*place, "x", color="black", ms=8, mew=2, label="target leaves the reach")
    axes.plot([], [], **LIMIT, label="limit of a joint")
    axes.set_aspect("equal", adjustable="datalim")
    axes.set_xlabel(f"{view.axes[0]} (m)")
    axes.set_ylabel(f"{view.axes[1]} (m)")


def _legend(axes: Axes) -> None:
    below = -0.12 if axes.get_position().height > 0.5 else -0.17
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, below), ncols=2)


def _tag(axes: Axes, place: Array, text: str) -> None:
    box = {"boxstyle": "circle,pad=0.2", "facecolor": "white", "edgecolor": LINES[0]["color"], "lw": 0.8}
    axes.annotate(text, tuple(place), ha="center", va="center", fontsize=8, bbox=box)


def _draw_curve(axes: Axes, time: Array, begins: Array, curve: Curve) -> None:
    for limit in (curve.least, curve.most):
        axes.axhline(limit, **LIMIT)
    for begin in begins[1:]:
        axes.axvline(begin, **QUIET)
    axes.plot(time, curve.values, **LINES[0])
    axes.set_xlim(time[0], time[-1])


def _number(axes: Axes, begins: Array, end: float) -> None:
    """Write the numbers of the segments above a frame."""
    for number, middle in enumerate((begins + np.append(begins[1:], end)) / 2, 1):
        place: dict[str, Any] = {"xycoords": axes.get_xaxis_transform(), "textcoords": "offset points"}
        axes.annotate(str(number), (middle, 1.0), (0, 3), **place, ha="center", fontsize=8, color="#555555")
