"""Balloons: numbers of items around a view of an assembly; mm on the paper."""

from __future__ import annotations

from math import hypot
from typing import TYPE_CHECKING

from layflat.lazy import numpy as np
from layflat.solids.drawings.text import text_width

if TYPE_CHECKING:
    from collections.abc import Sequence

    from layflat.arrays import Array
    from layflat.solids.drawings.paper import Paper
    from layflat.solids.drawings.projection import Projection
    from layflat.solids.drawings.views import View

BALLOON_RADIUS = 3.2  # radius of a balloon
BALLOON_SPACING = 7.2  # between middles of balloons, and more where a long text makes them wide
TEXT_MARGIN = 1.2  # of a text in a balloon
BALLOON_GAP = 0.8  # between balloons
BALLOON_INSET = BALLOON_RADIUS + 1.0  # of the first balloon from the end of a view, whose dimensions begin there
BALLOON_DISTANCE = 9.0  # from a view to its balloons


def draw_balloons(placed: View, view: Projection, points: dict[str, Array]) -> None:
    """Draw balloons around a view with leaders to points of their items.

    Args:
        placed: where.
        view: the projection.
        points: a point of each item, (2,).
    """
    (left, low), (right, high) = (placed.paper_points(corner) for corner in view.box)
    at = {item: placed.paper_points(point) for item, point in points.items()}
    room = max(int((high - low - 2 * BALLOON_INSET) / BALLOON_SPACING) + 1, 1)
    sides: dict[str, list[str]] = {"left": [], "right": [], "top": [], "bottom": []}
    for item in sorted(at, key=lambda name: float(at[name][0])):
        sides["left" if at[item][0] < (left + right) / 2 else "right"].append(item)
    for side in ("left", "right"):
        # The items in the middle of a full side move above and below the view.
        order = sorted(sides[side], key=lambda name: abs(float(at[name][0]) - (left if side == "left" else right)))
        for item in order[room:]:
            sides["top" if at[item][1] > (low + high) / 2 else "bottom"].append(item)
        sides[side] = order[:room]
    for side, items in sides.items():
        upright = side in {"left", "right"}
        axis = 1 if upright else 0
        order = sorted(items, key=lambda name: float(at[name][axis]))
        ideal = [float(at[name][axis]) for name in order]
        ends = np.array((low, high) if upright else (left, right)) + BALLOON_INSET * np.array([1.0, -1.0])
        widest = max((2 * _half_width(name, placed.paper.text_height) for name in order), default=0.0)
        spacing = BALLOON_SPACING if upright else max(BALLOON_SPACING, widest + BALLOON_GAP)
        spread = _spread(ideal, spacing, (float(ends[0]), float(ends[1])))
        edge = {
            "left": left - BALLOON_DISTANCE,
            "right": right + BALLOON_DISTANCE,
            "top": high + BALLOON_DISTANCE,
            "bottom": low - BALLOON_DISTANCE,
        }[side]
        for item, value in zip(order, spread, strict=True):
            _draw_balloon(placed.paper, np.array([edge, value] if upright else [value, edge]), at[item], item)


def _spread(ideal: Sequence[float], spacing: float, limits: tuple[float, float]) -> list[float]:
    """Return ascending positions with a spacing, close to ideal ones and, if there is room, within limits."""
    found: list[float] = []
    for value in ideal:
        found.append(max(value, found[-1] + spacing) if found else max(value, limits[0]))
    beyond = found[-1] - limits[1] if found else 0.0
    for k in range(len(found) - 1, -1, -1):
        upper = found[k + 1] - spacing if k + 1 < len(found) else found[k] - max(beyond, 0.0)
        found[k] = min(found[k], upper)
    return found


def _half_width(item: str, height: float) -> float:
    """Return half of the width of a balloon with a text of a height, mm."""
    return max(BALLOON_RADIUS, text_width(item, height) / 2 + TEXT_MARGIN)


def _draw_balloon(paper: Paper, centre: Array, point: Array, item: str) -> None:
    """Draw a balloon with a leader to a point, which ends in a dot."""
    t = paper.text_height
    half = _half_width(item, t)
    way = point - centre
    start = centre + BALLOON_RADIUS / hypot(*way) * way
    paper.line([start, point], "thin")
    angles = np.linspace(0.0, 2 * np.pi, 36, endpoint=False)
    ring = np.stack((np.cos(angles), np.sin(angles)), axis=-1)
    paper.area([point + 0.5 * ring], "none", "black")
    stretch = np.sign(ring[:, :1]) * np.array([half - BALLOON_RADIUS, 0.0])
    paper.area([centre + BALLOON_RADIUS * ring + stretch], "thin", "white")
    paper.text(float(centre[0]), float(centre[1]) - t / 2, item, t, "center")
