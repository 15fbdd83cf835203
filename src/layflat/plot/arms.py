"""Sized arms: how one looks from the side and from above, and what others for the same task weigh."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle, Polygon

from layflat.arrays import Array
from layflat.plot.style import HEAD, LINES, figure

HIGH = 4.3  # of the arm's views, inches
BODY, TUBE = "#c9d3da", "#eceff1"


class Body(NamedTuple):
    """A cylinder."""

    begin: Array  # middles of its ends, (3,), m
    end: Array
    diameter: float  # m


class Arm(NamedTuple):
    """An arm in one posture, and where its tip goes."""

    joints: Sequence[Body]
    tubes: Sequence[Body]
    tips: Array  # (points, 3), m


def arm_figure(arm: Arm, title: str) -> Figure:
    """Draw an arm from the side and from above, with where the tip is to go."""
    with figure(1, 2, width=9.0, height=HIGH, above=HEAD) as (made, (side, above)):
        for axes, across, upward in ((side, 0, 2), (above, 0, 1)):
            axes.plot(
                arm.tips[:, across], arm.tips[:, upward], ls="", marker="x", ms=4, color=LINES[1]["color"], zorder=0.9
            )
            for body, colour in [*((tube, TUBE) for tube in arm.tubes), *((joint, BODY) for joint in arm.joints)]:
                _draw(axes, body, (across, upward), colour)
            axes.set_aspect("equal", adjustable="datalim")
            axes.margins(0.08)
            axes.set_xlabel("x (m)")
        side.set_ylabel("z (m)")
        above.set_ylabel("y (m)")
        side.set_title(f"{title}, from the side", fontsize=9.5, loc="left")
        above.set_title("from above; crosses: ends of moves", fontsize=9.5, loc="left")
    return made


def _draw(axes: Axes, body: Body, plane: tuple[int, int], colour: str) -> None:
    """Draw a cylinder as it is seen along a third axis: a rectangle, and circles where it is seen from its ends."""
    begin, end = (np.asarray(at)[list(plane)] for at in (body.begin, body.end))
    way, radius = end - begin, 0.5 * body.diameter
    length = float(np.hypot(*way))
    along = float(np.linalg.norm(np.asarray(body.end) - np.asarray(body.begin)))
    look = {"facecolor": colour, "edgecolor": LINES[0]["color"], "lw": 1.0}
    if length < 0.99 * along:
        for at in (begin, end):
            axes.add_patch(Circle((float(at[0]), float(at[1])), radius, **look))
    if length > 0.01 * along:
        side = radius * np.array([-way[1], way[0]]) / length
        axes.add_patch(Polygon(np.array([begin + side, end + side, end - side, begin - side]), closed=True, **look))


class Sizes(NamedTuple):
    """Arms that were sized at one pressure, the quickest first."""

    pressure: float  # gauge, bar
    time: Array  # of a move, s
    mass: Array  # kg; infinite where no arm can do it
    best: Array  # whether no other is as quick and as light, at whatever pressure; 1 or 0


def sizes_figure(sizes: Sequence[Sizes], task: tuple[float, float]) -> Figure:
    """Draw mass over the time of a move, a curve a pressure, and those of the arm itself (s, kg)."""
    with figure(width=6.4, height=4.0) as (made, (axes,)):
        for order, one in enumerate(sizes):
            style, known = LINES[order % len(LINES)], np.isfinite(one.mass)
            axes.plot(one.time[known], one.mass[known], **style, label=f"{one.pressure:g} bar")
            for best, face in ((True, style["color"]), (False, "white")):
                at = known & (one.best.astype(bool) == best)
                axes.plot(one.time[at], one.mass[at], ls="", marker="o", ms=5, mec=style["color"], mfc=face)
        axes.plot(*task, ls="", marker="*", ms=13, mec="black", mfc="white", label="the task")
        axes.plot([], [], ls="", marker="o", ms=5, mec="black", mfc="black", label="none is both quicker and lighter")
        axes.set_ylim(bottom=0.0)
        axes.set_xlabel("Time of a move (s)")
        axes.set_ylabel("Mass of the arm (kg)")
        axes.legend()
    return made
