"""Texts of a sheet, and the boxes that they take."""

from itertools import combinations

import numpy as np

from layflat.solids.drawings.paper import FORMATS, Paper, Text
from layflat.solids.drawings.text import text_width

SLACK = 0.05  # by which boxes of texts may overlap, mm

Box = tuple[float, float, float, float]


def texts(paper: Paper) -> list[str]:
    """Return the texts of a sheet."""
    return [one.text for one in paper.elements if isinstance(one, Text)]


def text_box(one: Text) -> Box:
    """Return the box of a text: left, low, right, high, mm."""
    wide = text_width(one.text, one.height)
    before = {"left": 0.0, "center": 0.5, "right": 1.0}[one.anchor] * wide
    angle = np.radians(one.rotation)
    along, up = np.array([np.cos(angle), np.sin(angle)]), np.array([-np.sin(angle), np.cos(angle)])
    start = np.array(one.at) - before * along
    corners = np.array([start, start + wide * along, start + one.height * up, start + wide * along + one.height * up])
    (left, low), (right, high) = corners.min(axis=0), corners.max(axis=0)
    return left, low, right, high


def overlapping_texts(paper: Paper) -> list[tuple[str, str]]:
    """Return the pairs of texts of a sheet that cover each other."""
    boxes = [(one.text, text_box(one)) for one in paper.elements if isinstance(one, Text) and one.text]
    return [
        (text, other)
        for (text, a), (other, b) in combinations(boxes, 2)
        if min(a[2], b[2]) - max(a[0], b[0]) > SLACK and min(a[3], b[3]) - max(a[1], b[1]) > SLACK
    ]


def texts_off_the_sheet(paper: Paper) -> list[str]:
    """Return the texts of a sheet that reach beyond 1 mm from its edge."""
    width, height = FORMATS[paper.format]
    found = []
    for one in paper.elements:
        if isinstance(one, Text):
            left, low, right, high = text_box(one)
            if left < 1 or low < 1 or right > width - 1 or high > height - 1:
                found.append(one.text)
    return found
