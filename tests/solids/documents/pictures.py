"""Texts of a drawing in SVG, and where they stand."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from itertools import combinations

NAMESPACE = "{http://www.w3.org/2000/svg}"
LETTER_WIDTH = 0.5  # of the size of the letters, mean of Arial


class Label:
    """Text with its rectangle, mm; of texts that are not in a moved group."""

    def __init__(self, element: ET.Element) -> None:
        self.text = element.text or ""
        size = float(element.get("font-size", 0.0))
        width, x = LETTER_WIDTH * size * len(self.text), float(element.get("x", 0.0))
        left = x - {"start": 0.0, "middle": 0.5, "end": 1.0}[element.get("text-anchor", "start")] * width
        self.left, self.right = left, left + width
        self.bottom = float(element.get("y", 0.0))
        self.top = self.bottom - 0.72 * size

    def overlaps(self, other: Label) -> bool:
        """Return whether two labels cover each other."""
        beside = self.right <= other.left or other.right <= self.left
        return not (beside or self.bottom <= other.top or other.bottom <= self.top)


def labels(svg: str) -> list[Label]:
    """Return the labels of a drawing."""
    return [Label(element) for element in ET.fromstring(svg).iter(f"{NAMESPACE}text")]


def check_readable(svg: str) -> None:
    """Check that all labels stand on the sheet, none on another one, and nothing has a colour."""
    root = ET.fromstring(svg)
    _, _, width, height = map(float, root.get("viewBox", "").split())
    found = labels(svg)
    for label in found:
        assert 5.0 <= label.left, label.text
        assert label.right <= width - 5.0, label.text
        assert 5.0 <= label.top, label.text
        assert label.bottom <= height - 5.0, label.text
    for one, other in combinations(found, 2):
        assert not one.overlaps(other), (one.text, other.text)
    colours = {
        part.split(":")[1] for part in svg.replace("}", ";").split(";") if part.startswith(("stroke:#", "fill:#"))
    }
    assert colours <= {"#000", "#fff"}
