"""What tests of figures share: units on axes, texts that cover each other or lines, styles in black and white."""

from __future__ import annotations

from itertools import combinations, pairwise
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from matplotlib.text import Text
from matplotlib.transforms import Bbox
from numpy.typing import NDArray

SLACK = 1.0
"""Boxes may share so much, pixels: boxes of texts hold some empty room."""


def units_of(made: Figure) -> list[str]:
    """Labels of all axes of a figure, without those that name bars or repeat the axis of another row."""
    return [label for axes in made.axes for label in (axes.get_xlabel(), axes.get_ylabel()) if label]


def boxes(made: Figure) -> list[tuple[str, Bbox]]:
    """All texts of a figure with their boxes in pixels."""
    canvas: Any = FigureCanvasAgg(made)
    canvas.draw()
    beyond = _beyond_their_axes(made)
    texts = [text for text in made.findobj(Text) if isinstance(text, Text) and id(text) not in beyond]
    shown = [text for text in texts if text.get_visible() and text.get_text().strip()]
    return [(text.get_text(), text.get_window_extent(canvas.get_renderer())) for text in shown]


def _beyond_their_axes(made: Figure) -> set[int]:
    """The labels of ticks that are not drawn, since they lie beyond the ends of their axis or have no room."""
    hidden = set()
    for axes in made.axes:
        for axis, (low, high) in ((axes.xaxis, sorted(axes.get_xlim())), (axes.yaxis, sorted(axes.get_ylim()))):
            for tick in axis.get_major_ticks() + axis.get_minor_ticks():
                if not low <= tick.get_loc() <= high:
                    hidden |= {id(tick.label1), id(tick.label2)}
    return hidden


def covered(made: Figure) -> list[tuple[str, str]]:
    """Pairs of texts that cover each other."""
    return [(one, other) for (one, a), (other, b) in combinations(boxes(made), 2) if _overlap(a, b)]


def cut_off(made: Figure) -> list[str]:
    """Texts that reach beyond the figure."""
    width, height = made.canvas.get_width_height()
    return [
        text
        for text, box in boxes(made)
        if box.x0 < -SLACK or box.y0 < -SLACK or box.x1 > width + SLACK or box.y1 > height + SLACK
    ]


def _overlap(a: Bbox, b: Bbox) -> bool:
    return bool(min(a.x1, b.x1) - max(a.x0, b.x0) > SLACK and min(a.y1, b.y1) - max(a.y0, b.y0) > SLACK)


def crossed_by_lines(axes: Axes, label: str) -> bool:
    """Whether a line of the axes runs through the text with this label."""
    figure = axes.get_figure()
    assert isinstance(figure, Figure)
    ((_, box),) = [(text, box) for text, box in boxes(figure) if text == label]
    for line in axes.lines:
        points = axes.transData.transform(np.column_stack([np.asarray(line.get_xdata()), np.asarray(line.get_ydata())]))
        for first, last in pairwise(points):
            along = first + np.linspace(0.0, 1.0, 200)[:, None] * (last - first)
            inside = (along > [box.x0, box.y0]) & (along < [box.x1, box.y1])
            if inside.all(axis=1).any():
                return True
    return False


def line_of(axes: Axes, label: str) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """The data of the line with a label."""
    (line,) = [line for line in axes.lines if line.get_label() == label]
    return np.asarray(line.get_xdata(), dtype=float), np.asarray(line.get_ydata(), dtype=float)


def looks(axes: Axes) -> list[tuple[str, float]]:
    """Dash and lightness of each labelled line: what is left of it in black and white."""
    named = [line for line in axes.lines if not str(line.get_label()).startswith("_")]
    return [
        (repr(line.get_linestyle()), round(float(np.dot(to_rgb(line.get_color()), (0.299, 0.587, 0.114))), 2))
        for line in named
    ]
