"""Figures of sized arms: views from the side and from above, and masses of the arms for one task."""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle, Polygon

from layflat.arrays import Array
from layflat.plot.style import HEAD_ROOM, SERIES_STYLES, series_style, styled_figure

VIEW_HEIGHT = 4.3  # of the arm's views, inches
BODY_COLOUR, TUBE_COLOUR = "#c9d3da", "#eceff1"


class DrawnCylinder(NamedTuple):
    """Cylinder to draw."""

    begin: Array  # centre of the first end, (3,), m
    end: Array
    diameter: float  # m


class DrawnArm(NamedTuple):
    """Arm in one configuration, and target positions of its tip."""

    joints: Sequence[DrawnCylinder]
    tubes: Sequence[DrawnCylinder]
    tips: Array  # (points, 3), m


def arm_figure(arm: DrawnArm, title: str) -> Figure:
    """Draw an arm from the side (x, z) and from above (x, y), with the target positions of its tip as crosses."""
    with styled_figure(1, 2, width=9.0, height=VIEW_HEIGHT, above=HEAD_ROOM) as (fig, (side, above)):
        for axes, across, upward in ((side, 0, 2), (above, 0, 1)):
            axes.plot(
                arm.tips[:, across],
                arm.tips[:, upward],
                ls="",
                marker="x",
                ms=4,
                color=SERIES_STYLES[1]["color"],
                zorder=0.9,
            )
            for body, colour in [
                *((tube, TUBE_COLOUR) for tube in arm.tubes),
                *((joint, BODY_COLOUR) for joint in arm.joints),
            ]:
                _draw_cylinder(axes, body, (across, upward), colour)
            axes.set_aspect("equal", adjustable="datalim")
            axes.margins(0.08)
            axes.set_xlabel("x (m)")
        side.set_ylabel("z (m)")
        above.set_ylabel("y (m)")
        side.set_title(f"{title}, from the side", fontsize=9.5, loc="left")
        above.set_title("from above; crosses: ends of moves", fontsize=9.5, loc="left")
    return fig


def _draw_cylinder(axes: Axes, body: DrawnCylinder, plane: tuple[int, int], colour: str) -> None:
    """Draw the projection of a cylinder on the plane of two axes, given by their indices: horizontal, vertical.

    It is a rectangle unless the cylinder is normal to the plane, with a circle at each end unless it is parallel to it.
    """
    begin, end = (np.asarray(centre)[list(plane)] for centre in (body.begin, body.end))
    axis, radius = end - begin, 0.5 * body.diameter
    length = float(np.hypot(*axis))
    along = float(np.linalg.norm(np.asarray(body.end) - np.asarray(body.begin)))
    look = {"facecolor": colour, "edgecolor": SERIES_STYLES[0]["color"], "lw": 1.0}
    if length < 0.99 * along:
        for at in (begin, end):
            axes.add_patch(Circle((float(at[0]), float(at[1])), radius, **look))
    if length > 0.01 * along:
        side = radius * np.array([-axis[1], axis[0]]) / length
        axes.add_patch(Polygon(np.array([begin + side, end + side, end - side, begin - side]), closed=True, **look))


def workspace_figure(arms: Mapping[str, Array], tips: Array, views: Sequence[str]) -> Figure:
    """Draw an arm in several configurations, with positions of its tip all over its workspace as dots.

    Args:
        arms: positions of joints and tip, (points, 3), m, by the name of the configuration.
        tips: positions of the tip, (positions, 3), m.
        views: horizontal and vertical axis of each view, such as "xy".
    """
    size = {"width": 0.9 + 4.3 * len(views), "height": 4.6}
    with styled_figure(1, len(views), **size) as (fig, all_axes):
        for axes, view in zip(all_axes, views, strict=True):
            across, upward = ("xyz".index(axis) for axis in view)
            axes.plot(tips[:, across], tips[:, upward], ls="", marker=".", ms=1.5, color="#b0bec5", label="tip")
            for order, (name, points) in enumerate(arms.items()):
                axes.plot(points[:, across], points[:, upward], **series_style(order), marker="o", ms=4, label=name)
            axes.set_aspect("equal", adjustable="datalim")
            axes.set_xlabel(f"{view[0]} (m)")
            axes.set_ylabel(f"{view[1]} (m)")
        all_axes[0].legend(fontsize=8)
    return fig


class SizedArms(NamedTuple):
    """Arms sized at one pressure, the quickest first."""

    pressure: float  # gauge, bar
    time: Array  # of a move, s
    mass: Array  # kg; infinite if no arm is feasible
    best: Array  # 1 for Pareto-optimal arms: none at any pressure is better in all that is drawn; else 0
    cost: Array | None = None  # the same; None or without finite values where costs are not compared


def sizes_figure(sizes: Sequence[SizedArms], task: Sequence[float], *, built: bool = False) -> Figure:
    """Draw mass, and cost if there are costs, over the time of a move, one curve per pressure.

    Markers of Pareto-optimal arms are filled; arms of infinite mass are left out.

    Args:
        sizes: arms of each pressure.
        task: time (s), mass (kg) and, with costs, cost of the task's own arm, which is drawn as a star.
        built: whether masses are those of arms as built.
    """
    priced = any(one.cost is not None and np.isfinite(one.cost).any() for one in sizes)
    labels = ["Mass of the arm as built (kg)" if built else "Mass of the arm (kg)", "Cost of the arm"][: 1 + priced]
    better = "quicker, lighter and cheaper" if priced else "both quicker and lighter"
    with styled_figure(1, len(labels), width=6.4 + 3.2 * priced, height=4.0) as (fig, all_axes):
        for number, (axes, label) in enumerate(zip(all_axes, labels, strict=True), 1):
            for order, one in enumerate(sizes):
                _draw_sizes(axes, one, one.mass if number == 1 else one.cost, order)
            axes.plot(task[0], task[number], ls="", marker="*", ms=13, mec="black", mfc="white", label="the task")
            axes.plot([], [], ls="", marker="o", ms=5, mec="black", mfc="black", label=f"none is {better}")
            axes.set_ylim(0.0, 1.05 * axes.get_ylim()[1])
            axes.set_xlabel("Time of a move (s)")
            axes.set_ylabel(label)
        all_axes[0].legend()
    return fig


def _draw_sizes(axes: Axes, sizes: SizedArms, values: Array | None, order: int) -> None:
    """Draw masses or costs of the arms of one pressure, where they are finite, in the style of the `order`-th one."""
    if values is None:
        return
    style, known = series_style(order), np.isfinite(values)
    axes.plot(sizes.time[known], values[known], **style, label=f"{sizes.pressure:g} bar")
    for best, face in ((True, style["color"]), (False, "white")):
        at = known & (sizes.best.astype(bool) == best)
        axes.plot(sizes.time[at], values[at], ls="", marker="o", ms=5, mec=style["color"], mfc=face)
