"""Views on a sheet, to scale, with lines, dimensions and drilled holes; mm."""

from __future__ import annotations

from dataclasses import dataclass
from math import hypot, pi
from typing import TYPE_CHECKING, Any

from layflat.design.sheet import Distance
from layflat.lazy import numpy as np
from layflat.solids.drawings.dimensions import Labels, draw_distance
from layflat.solids.standard.threads import THREADS

if TYPE_CHECKING:
    from layflat.arrays import Array
    from layflat.solids.drawings.paper import Paper, Pen
    from layflat.solids.shapes import Drilled

CIRCLE_POINTS = 96
CROSS_OVERHANG = 2.0  # of centre lines beyond circles, mm on the paper


@dataclass(frozen=True)
class View:
    """Scale and position of a view on a sheet, whose labels avoid each other."""

    labels: Labels
    scale: float  # mm on the paper per mm
    x: float  # of the view's origin on the paper
    y: float

    @property
    def paper(self) -> Paper:
        """The sheet."""
        return self.labels.paper

    def paper_points(self, points: Any) -> Array:
        """Return points on the paper of points in the view's plane, (..., 2)."""
        place: Array = np.array([self.x, self.y]) + self.scale * np.asarray(points, float)
        return place

    def line(self, points: Any, pen: Pen, *, closed: bool = False) -> None:
        """Draw a line that labels avoid.

        Args:
            points: (n, 2).
            pen: its pen.
            closed: whether the last point is connected with the first.
        """
        line = self.paper_points(points)
        self.paper.line(line, pen, closed=closed)
        self.labels.avoid(np.vstack((line, line[:1])) if closed else line)

    def circle(self, centre: Any, radius: float, pen: Pen, share: float = 1.0) -> None:
        """Draw a circle.

        Args:
            centre: its centre.
            radius: its radius.
            pen: pen of the line.
            share: drawn share of the circle, from the left upwards; below 1 it stays open.
        """
        angles = pi + np.linspace(0.0, 2 * pi * share, CIRCLE_POINTS, endpoint=share < 1)
        self.line(np.asarray(centre, float) + radius * np.stack((np.cos(angles), np.sin(angles)), axis=-1), pen)

    def cross(self, centre: Any, radius: float) -> None:
        """Draw the centre lines of a circle."""
        (x, y), half = self.paper_points(centre), radius * self.scale + CROSS_OVERHANG
        for line in ([(x - half, y), (x + half, y)], [(x, y - half), (x, y + half)]):
            self.paper.line(line, "centre")
            self.labels.avoid(line)

    def distance(self, first: Any, second: Any, offset: float, label: str, *, upright: bool = False) -> None:
        """Dimension the distance of two points along x, or along y if upright.

        Args:
            first: one point.
            second: another point.
            offset: of the dimension line from the first point, mm on the paper.
            label: the text.
            upright: whether the distance is along y.
        """
        one, other = self.paper_points(first), self.paper_points(second)
        base = one + (np.array([offset, 0.0]) if upright else np.array([0.0, offset]))
        draw_distance(self.labels, Distance(one, other, base, 90.0 if upright else 0.0, label))


def nominal_diameter(thread: str) -> float:
    """Return the nominal diameter of a thread such as "M5", mm; 0 without one."""
    return THREADS[thread].diameter * 1e3 if thread in THREADS else 0.0


def draw_drilled(
    view: View, hole: Drilled, axes: tuple[int, int], signs: tuple[int, int] = (1, 1), pen: Pen = "hidden"
) -> None:
    """Draw a drilled hole in a view along a third axis.

    Args:
        view: where.
        hole: the hole.
        axes: of the part that lie along x and y of the view.
        signs: their directions.
        pen: of the hole's walls.
    """
    flip = np.array(signs, float)
    start, along = (np.array([vector[k] for k in axes]) * flip for vector in (hole.start, hole.direction))
    if hypot(*along) < 0.3:
        view.circle(start, hole.diameter / 2, "outline")
        view.cross(start, hole.diameter / 2)
        return
    end = start + hole.depth * along
    unit = along / hypot(*along)
    normal = np.array([-unit[1], unit[0]])
    for diameter, line in ((hole.diameter, pen), (nominal_diameter(hole.thread), "thin")):
        half = diameter / 2 * normal
        if diameter and line == pen:
            view.line([start + half, end + half, end - half, start - half], pen, closed=pen == "outline")
        elif diameter:
            view.line([start + half, end + half], "thin")
            view.line([start - half, end - half], "thin")
    beyond = CROSS_OVERHANG / view.scale * unit
    view.paper.line(view.paper_points([start - beyond, end + beyond]), "centre")
