"""Dimensions, leaders and labels on a sheet (ISO 129-1); mm on the paper."""

from __future__ import annotations

from dataclasses import dataclass, field
from math import cos, hypot, pi, radians, sin
from typing import TYPE_CHECKING, Any

from layflat.design.sheet import Distance
from layflat.lazy import numpy as np
from layflat.solids.drawings.text import text_width

if TYPE_CHECKING:
    from layflat.arrays import Array
    from layflat.solids.drawings.paper import Paper

ARROW_LENGTH, ARROW_SHARE = 2.5, 0.16  # length of an arrow, half of its width over its length
EXTENSION_GAP, EXTENSION_OVERHANG = 0.8, 1.5  # of an extension line: before it, and beyond the dimension line
TEXT_DISTANCE = 0.9  # between a dimension line and its text
OUTER_LENGTH = 5.0  # length of the line outside of outer arrows
LABEL_DIRECTIONS = 16  # in which a label's place is looked for
REACH_COST = 0.8  # of a label per mm away, in points of lines that it covers
LABEL_GAP = 0.6  # around a label
MIN_SLANT = 0.3  # part of a direction along an axis below which a label stays in the middle
LABEL_DISTANCES = (0.0, 2.0, 4.5, 8.0, 13.0)  # of a label beyond the circle that it belongs to


def draw_arrow(paper: Paper, tip: Any, direction: Any) -> None:
    """Draw an arrow head.

    Args:
        paper: the sheet.
        tip: its tip.
        direction: in which it points, unit vector.
    """
    tip, along = np.asarray(tip, float), np.asarray(direction, float)
    across = np.array([-along[1], along[0]])
    back = tip - ARROW_LENGTH * along
    paper.area(
        [np.array([tip, back + ARROW_SHARE * ARROW_LENGTH * across, back - ARROW_SHARE * ARROW_LENGTH * across])],
        "none",
        "black",
    )


def draw_distance(labels: Labels, dimension: Distance) -> None:
    """Draw the dimension of a distance; arrows and text stand outside where there is no room between its ends."""
    paper, angle = labels.paper, radians(dimension.direction)
    along, ends = np.array([cos(angle), sin(angle)]), dimension.ends
    if (ends[1] - ends[0]) @ along < 0:
        ends = ends[::-1]
    for point, end in zip((dimension.first, dimension.second), dimension.ends, strict=True):
        way = end - np.array(point)
        length = hypot(*way)
        if length > EXTENSION_GAP:
            labels.line([np.array(point) + EXTENSION_GAP / length * way, end + EXTENSION_OVERHANG / length * way])
    length, t = float(hypot(*(ends[1] - ends[0]))), paper.text_height
    wide = text_width(dimension.label, t)
    rotation = 90.0 - (90.0 - dimension.direction) % 180.0  # readable from below or from the right
    upright = np.array([-sin(radians(rotation)), cos(radians(rotation))])
    inside = length > 2 * ARROW_LENGTH + 1.0
    draw_arrow(paper, ends[1], along if inside else -along)
    draw_arrow(paper, ends[0], -along if inside else along)
    if inside and wide + 1.0 < length:
        labels.line(ends)
        x, y = (ends[0] + ends[1]) / 2 + TEXT_DISTANCE * upright
    else:
        out = 0.0 if inside else OUTER_LENGTH
        labels.line([ends[0] - out * along, ends[1] + (out + wide + 1.0) * along])
        x, y = ends[1] + (max(out, 1.0) + wide / 2) * along + TEXT_DISTANCE * upright
    paper.text(x, y, dimension.label, 0.0, "center", rotation)
    half, middle = wide / 2 * np.abs(along), np.array([x, y])
    corners = np.array([middle - half, middle + half, middle - half + t * upright, middle + half + t * upright])
    labels.boxes.append((*corners.min(axis=0), *corners.max(axis=0)))


@dataclass
class Labels:
    """Labels of a sheet, each placed where it covers as little as possible."""

    paper: Paper
    points: Array = field(default_factory=lambda: np.empty((2, 0)))  # of lines that labels should not cover, (2, n)
    boxes: list[tuple[float, float, float, float]] = field(default_factory=list)  # of other labels

    def avoid(self, points: Any) -> None:
        """Keep labels off a line (n, 2): points along it are remembered."""
        line = np.asarray(points, float)
        steps = np.diff(line, axis=0)
        counts = np.maximum(np.hypot(*steps.T).astype(int), 1)
        spots = [start + step * np.arange(n)[:, None] / n for start, step, n in zip(line, steps, counts, strict=False)]
        self.points = np.hstack((self.points, *(spot.T for spot in spots), line[-1:].T))

    def line(self, points: Any) -> None:
        """Draw a thin line (n, 2) that labels avoid."""
        self.paper.line(points, "thin")
        self.avoid(points)

    def cost(self, box: tuple[float, float, float, float]) -> float:
        """Return how much a box (left, low, right, high) covers: points of lines, and much more for other labels."""
        left, low, right, high = box
        x, y = self.points
        covered = np.count_nonzero((x > left) & (x < right) & (y > low) & (y < high))
        overlaps = sum(left < r and right > x and low < h and high > y for x, y, r, h in self.boxes)
        return covered + 50.0 * overlaps

    def place(self, centre: Any, radius: float, label: str, height: float = 0.0) -> None:
        """Write a label beside a circle.

        Args:
            centre: of the circle.
            radius: of the circle.
            label: the text.
            height: of capital letters, by default that of ordinary text.
        """
        t = height or self.paper.text_height
        wide = text_width(label, t)
        best: tuple[float, tuple[float, float, float, float]] | None = None
        for reach in LABEL_DISTANCES:
            if best is not None and best[0] <= REACH_COST * reach:
                break  # no label that is further away costs less
            for k in range(LABEL_DIRECTIONS):
                # From the upper right on: there a label is expected.
                angle = pi / 4 + 2 * pi * k / LABEL_DIRECTIONS
                out = radius + 1.0 + reach
                # The label's nearest corner, or the middle of its side, lies in that direction.
                x, y = (
                    float(middle + out * part + half * np.sign(part) * (abs(part) > MIN_SLANT))
                    for middle, part, half in zip(centre, (cos(angle), sin(angle)), (wide / 2, t / 2), strict=True)
                )
                box = (x - wide / 2 - LABEL_GAP, y - t / 2 - LABEL_GAP, x + wide / 2 + LABEL_GAP, y + t / 2 + LABEL_GAP)
                cost = self.cost(box) + REACH_COST * reach
                if best is None or cost < best[0]:
                    best = cost, box
        assert best is not None
        left, low, right, _ = best[1]
        self.boxes.append(best[1])
        self.paper.text((left + right) / 2, low + LABEL_GAP, label, t, "center")

    def leader(self, tip: Any, outward: Any, label: str) -> None:
        """Write a label at the end of a leader whose arrow points at a line.

        Args:
            tip: point of the line.
            outward: direction of the leader, unit vector.
            label: the text.
        """
        t, tip, out = self.paper.text_height, np.asarray(tip, float), np.asarray(outward, float)
        wide = text_width(label, t)
        side = 1.0 if out[0] >= 0 else -1.0
        best: tuple[float, Array, tuple[float, float, float, float]] | None = None
        for reach in (5.0, 8.0, 11.0, 15.0):
            for tilt in (0.0, 0.4, -0.4, 0.8, -0.8):
                turned = np.array([cos(tilt) * out[0] - sin(tilt) * out[1], sin(tilt) * out[0] + cos(tilt) * out[1]])
                knee = tip + reach * turned
                left = knee[0] if side > 0 else knee[0] - wide - 1.0
                box = (left, knee[1] - 0.3, left + wide + 1.0, knee[1] + t + 1.3)
                cost = self.cost(box) + 0.2 * reach + 3 * abs(tilt)
                if best is None or cost < best[0]:
                    best = cost, knee, box
        assert best is not None
        _, knee, box = best
        self.boxes.append(box)
        self.line([tip, knee, (knee[0] + side * (wide + 1.0), knee[1])])
        draw_arrow(self.paper, tip, (tip - knee) / hypot(*(tip - knee)))
        self.paper.text(box[0] + 0.5, knee[1] + TEXT_DISTANCE, label)
