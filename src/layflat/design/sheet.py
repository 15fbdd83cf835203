"""What a drawing shows, apart from the format that it is written in. Everything in mm, y upwards."""

from dataclasses import dataclass, field
from math import radians
from typing import Literal, NamedTuple

import numpy as np

from layflat.arrays import Array
from layflat.design.straplines import unit

Point = tuple[float, float] | Array
Layer = Literal["OUTLINE", "CENTRE", "STRAP", "HOSE", "DIMENSIONS", "TEXT"]


class Path(NamedTuple):
    """A polyline through points of shape (n, 2)."""

    points: Array
    layer: Layer
    closed: bool = False


class Circle(NamedTuple):
    """A full circle."""

    centre: Point
    radius: float
    layer: Layer


class Distance(NamedTuple):
    """A dimension of the distance between two points along a direction (degrees), drawn through `base`."""

    first: Point
    second: Point
    base: Point
    direction: float
    label: str

    @property
    def ends(self) -> Array:
        """Both ends of the dimension line, shape (2, 2)."""
        along = unit(radians(self.direction))
        base = np.array(self.base)
        return np.array([base + ((np.array(point) - base) @ along) * along for point in (self.first, self.second)])


class Diameter(NamedTuple):
    """A dimension of a circle, led out from the circle in a direction (degrees)."""

    centre: Point
    radius: float
    direction: float
    label: str
    lead: float


class Note(NamedTuple):
    """A line of text that starts at a point."""

    at: Point
    text: str
    size: float = 1.0


@dataclass
class Sheet:
    """A drawing: lines, dimensions and notes. `text_height` (mm) also sets arrows and gaps."""

    title: str
    text_height: float
    paths: list[Path] = field(default_factory=list)
    circles: list[Circle] = field(default_factory=list)
    distances: list[Distance] = field(default_factory=list)
    diameters: list[Diameter] = field(default_factory=list)
    notes: list[Note] = field(default_factory=list)

    def line(self, first: Point, second: Point, layer: Layer) -> None:
        """Add a straight line."""
        self.paths.append(Path(np.array([first, second]), layer))

    def cross(self, centre: Point, half: float) -> None:
        """Add the centre lines of a circle."""
        x, y = centre
        self.line((x - half, y), (x + half, y), "CENTRE")
        self.line((x, y - half), (x, y + half), "CENTRE")
