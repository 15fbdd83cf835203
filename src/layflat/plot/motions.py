"""Figures of planned motions: the path of the tip in one view or two, and joints over time with their limits."""

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from layflat.arrays import Array
from layflat.plot.style import AXES_GAPS, GUIDE_STYLE, HEAD_ROOM, SERIES_STYLES, SHADE_COLOUR, styled_figure

VIEW_SIZES = {1: 3.95, 2: 2.75}  # of a view of the tip's way, by how many there are, inches
VIEW_LABEL_WIDTH = 0.95  # beside it
COLUMN_WIDTHS = {1: 3.3, 2: 2.7}  # width of a joint's frames, likewise, inches
FIGURE_HEIGHTS = {1: 6.2, 2: 7.9}  # inches
VIEW_GAP = 0.55  # of one view from the other, inches
LIMIT_STYLE: dict[str, Any] = {"color": "#555555", "linestyle": (0, (4, 2)), "linewidth": 1.0}


class LimitedCurve(NamedTuple):
    """Quantity over time, with its lower and upper limit."""

    values: Array
    lower: float
    upper: float


class JointCurves(NamedTuple):
    """Motion of a joint over time."""

    angle: LimitedCurve  # deg
    velocity: LimitedCurve  # deg/s
    torque: LimitedCurve  # N m


class MotionView(NamedTuple):
    """View along one direction, in m."""

    axes: str  # horizontal and vertical axis, such as "xy"
    tip: Array  # (instants, 2)
    reach: Sequence[Array]  # outlines of the tip's reach, (points, 2) each
    arms: Sequence[Array]  # joints and tip at the beginning and at the end, (points, 2) each
    exits: Sequence[Array]  # positions at which targets leave the reach, (2,) each
    outline: str = "reach"  # label of the outlines


def motion_figure(time: Array, begins: Array, views: Sequence[MotionView], joints: Mapping[str, JointCurves]) -> Figure:
    """Draw a motion: views of the tip's path, and angle, velocity and torque of each joint.

    Args:
        time: instants, (instants,), s.
        begins: start times of the segments, s.
        views: one or two.
        joints: curves by joint.
    """
    side, column, high = (sizes[len(views)] for sizes in (VIEW_SIZES, COLUMN_WIDTHS, FIGURE_HEIGHTS))
    beside = side + VIEW_LABEL_WIDTH
    width = beside + AXES_GAPS[0] + column * len(joints)
    with styled_figure(3, len(joints), width=width, height=high, above=HEAD_ROOM, beside=beside) as (fig, all_axes):
        for row, view in enumerate(views):
            below = high - HEAD_ROOM - 0.12 - (row + 1) * side - row * VIEW_GAP
            _draw_view(fig.add_axes((0.75 / width, below / high, side / width, side / high)), time, begins, view)
        _place_legend(fig.axes[-1])
        for column, (name, joint) in enumerate(joints.items()):
            labels = ("Angle (deg)", "Velocity (deg/s)", "Torque of the hoses (N m)")
            for row, (curve, label) in enumerate(zip(joint, labels, strict=True)):
                axes = all_axes[row * len(joints) + column]
                _draw_curve(axes, time, begins, curve)
                if column == 0:
                    axes.set_ylabel(label)
            all_axes[column].set_title(f"{name} joint", pad=16)
            _number_segments(all_axes[column], begins, float(time[-1]))
            all_axes[2 * len(joints) + column].set_xlabel("Time (s)")
    return fig


def _draw_view(axes: Axes, time: Array, begins: Array, view: MotionView) -> None:
    """Draw path of the tip, reach, arm at start and end, and places where a target leaves the reach, in a view (m).

    Segments of the path in which the tip moves carry their numbers; closed outlines of the reach are filled.
    """
    for order, outline in enumerate(view.reach):
        if np.allclose(outline[0], outline[-1]):
            axes.fill(*outline.T, color=SHADE_COLOUR, lw=0)
        axes.plot(*outline.T, **GUIDE_STYLE, label=view.outline if order == 0 else None)
    for arm, style, label in zip(view.arms, ("-", (0, (2, 1))), ("at the start", "at the end"), strict=True):
        axes.plot(*arm.T, color="#9a9a9a", lw=2.5, ls=style, marker="o", ms=5, label=f"arm {label}")
    axes.plot(*view.tip.T, **SERIES_STYLES[0], label="path of the tip")
    ends = np.append(begins[1:], time[-1])
    for number, (begin, end) in enumerate(zip(begins, ends, strict=True), 1):
        part = view.tip[(time >= begin) & (time <= end)]
        if len(part) and np.ptp(part, axis=0).max() > 0.0:
            _draw_number(axes, part[len(part) // 2], str(number))
    for place in view.exits:
        axes.plot(*place, "x", color="black", ms=8, mew=2, label="target leaves the reach")
    axes.plot([], [], **LIMIT_STYLE, label="limit of a joint")
    axes.set_aspect("equal", adjustable="datalim")
    axes.set_xlabel(f"{view.axes[0]} (m)")
    axes.set_ylabel(f"{view.axes[1]} (m)")


def _place_legend(axes: Axes) -> None:
    """Add the legend of a view, in two columns below its axis label."""
    below = -0.12 if axes.get_position().height > 0.5 else -0.17
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, below), ncols=2)


def _draw_number(axes: Axes, place: Array, text: str) -> None:
    """Draw a text in a circle that is centred at a place, (2,), in data coordinates."""
    box = {"boxstyle": "circle,pad=0.2", "facecolor": "white", "edgecolor": SERIES_STYLES[0]["color"], "lw": 0.8}
    axes.annotate(text, tuple(place), ha="center", va="center", fontsize=8, bbox=box)


def _draw_curve(axes: Axes, time: Array, begins: Array, curve: LimitedCurve) -> None:
    """Draw a quantity over time (s) with its limits, and lines where the segments after the first begin."""
    for limit in (curve.lower, curve.upper):
        axes.axhline(limit, **LIMIT_STYLE)
    for begin in begins[1:]:
        axes.axvline(begin, **GUIDE_STYLE)
    axes.plot(time, curve.values, **SERIES_STYLES[0])
    axes.set_xlim(time[0], time[-1])


def _number_segments(axes: Axes, begins: Array, end: float) -> None:
    """Write the number of each segment above its middle; the last segment ends at `end`, s."""
    for number, middle in enumerate((begins + np.append(begins[1:], end)) / 2, 1):
        place: dict[str, Any] = {"xycoords": axes.get_xaxis_transform(), "textcoords": "offset points"}
        axes.annotate(str(number), (middle, 1.0), (0, 3), **place, ha="center", fontsize=8, color="#555555")
