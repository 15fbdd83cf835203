"""Elements of a drawing, and their text in SVG and in DXF. All lengths are in mm, with y upwards.

In SVG, true to scale, dimensions are lines, arrows and text. In DXF (R2010) CAD programs can edit them; ezdxf is an
extra: `layflat[drawing]`.
"""

import io
from dataclasses import dataclass, field
from html import escape
from math import radians
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

import numpy as np

from layflat import extras
from layflat.arrays import Array
from layflat.design.straplines import direction_vector, rotate_quarter

if TYPE_CHECKING:
    from ezdxf.layouts.layout import Modelspace


Point = tuple[float, float] | Array
Layer = Literal["OUTLINE", "CENTRE", "STRAP", "HOSE", "DIMENSIONS", "TEXT"]


class Polyline(NamedTuple):
    """Polyline through points of shape (n, 2)."""

    points: Array
    layer: Layer
    closed: bool = False


class Circle(NamedTuple):
    """Full circle."""

    centre: Point
    radius: float
    layer: Layer


class Distance(NamedTuple):
    """Dimension of the distance between two points along a direction (degrees), drawn through `base`."""

    first: Point
    second: Point
    base: Point
    direction: float
    label: str

    @property
    def ends(self) -> Array:
        """Ends of the dimension line, shape (2, 2)."""
        along = direction_vector(radians(self.direction))
        base = np.array(self.base)
        return np.array([base + ((np.array(point) - base) @ along) * along for point in (self.first, self.second)])


class Diameter(NamedTuple):
    """Dimension of a circle, whose leader runs in a direction (degrees) to `leader_length` from the centre."""

    centre: Point
    radius: float
    direction: float
    label: str
    leader_length: float


class Note(NamedTuple):
    """Line of text that starts at a point; its size is relative to the sheet's text height."""

    at: Point
    text: str
    size: float = 1.0


@dataclass
class Sheet:
    """Drawing of lines, dimensions and notes; `text_height` (mm) also sets the size of arrows and gaps."""

    title: str
    text_height: float
    paths: list[Polyline] = field(default_factory=list)
    circles: list[Circle] = field(default_factory=list)
    distances: list[Distance] = field(default_factory=list)
    diameters: list[Diameter] = field(default_factory=list)
    notes: list[Note] = field(default_factory=list)

    def line(self, first: Point, second: Point, layer: Layer) -> None:
        """Add a straight line.

        Args:
            first: start point, mm.
            second: end point, mm.
            layer: layer of the line.
        """
        self.paths.append(Polyline(np.array([first, second]), layer))

    def cross(self, centre: Point, half: float) -> None:
        """Add the centre lines of a circle, each of length 2 `half`, mm."""
        x, y = centre
        self.line((x - half, y), (x + half, y), "CENTRE")
        self.line((x, y - half), (x, y + half), "CENTRE")


LINE_STYLES: dict[Layer, str] = {  # of lines; text has none
    "OUTLINE": "stroke:#111;stroke-width:{wide}",
    "CENTRE": "stroke:#888;stroke-width:{thin};stroke-dasharray:{long} {thin2} {short} {thin2}",
    "STRAP": "stroke:#b5341c;stroke-width:{medium}",
    "HOSE": "stroke:#2a6f97;stroke-width:{medium}",
    "DIMENSIONS": "stroke:#444;stroke-width:{thin}",
}

ARROW_LENGTH = 0.8  # in text heights, as all below
DIMENSION_GAP = 0.3  # between a point and its extension line
DIMENSION_OVERHANG = 0.5  # of an extension line beyond the dimension line
LETTER_WIDTH = 0.58  # mean width of a letter


def svg_text(sheet: Sheet) -> str:
    """Return the SVG document of a sheet."""
    t = sheet.text_height
    canvas = _Canvas(t)
    for distance in sheet.distances:
        _draw_distance(canvas, distance)
    for diameter in sheet.diameters:
        _draw_diameter(canvas, diameter)
    for path in sheet.paths:
        canvas.path(path.points, path.layer, closed=path.closed)
    for circle in sheet.circles:
        canvas.circle(circle.centre, circle.radius, circle.layer)
    for note in sheet.notes:
        canvas.text(np.array(note.at), note.text, note.size * t, 0.0, "start")
    return canvas.document(sheet.title)


class _Canvas:
    """SVG elements and their bounding box, in mm with y upwards."""

    def __init__(self, text_height: float) -> None:
        self.t = text_height
        self.elements: list[str] = []
        self.low = np.full(2, np.inf)
        self.high = np.full(2, -np.inf)

    def _reach(self, points: Array) -> None:
        """Extend the bounding box to points (n, 2), mm."""
        self.low = np.minimum(self.low, points.min(axis=0))
        self.high = np.maximum(self.high, points.max(axis=0))

    def path(self, points: Array, layer: Layer, *, closed: bool = False) -> None:
        """Add a polyline.

        Args:
            points: (n, 2), mm.
            layer: layer of the line.
            closed: whether the last point is connected with the first.
        """
        self._reach(points)
        steps = " L".join(f"{x:.4f},{-y:.4f}" for x, y in points)
        self.elements.append(f'<path class="{layer.lower()}" d="M{steps}{"Z" if closed else ""}"/>')

    def circle(self, centre: Point, radius: float, layer: Layer) -> None:
        """Add a circle.

        Args:
            centre: mm.
            radius: mm.
            layer: layer of the line.
        """
        middle = np.array(centre)
        self._reach(np.array([middle - radius, middle + radius]))
        x, y = centre
        self.elements.append(f'<circle class="{layer.lower()}" cx="{x:.4f}" cy="{-y:.4f}" r="{radius:.4f}"/>')

    def arrow(self, tip: Array, direction: Array) -> None:
        """Add an arrow head with its tip at a point (mm), in a direction (unit vector)."""
        back, across = tip - ARROW_LENGTH * self.t * direction, 0.15 * self.t * rotate_quarter(direction)
        corners = (tip, back + across, back - across)
        points = " ".join(f"{x:.4f},{-y:.4f}" for x, y in corners)
        self.elements.append(f'<polygon class="arrow" points="{points}"/>')

    def text(self, position: Array, text: str, height: float, rotation: float, anchor: str) -> None:
        """Add a line of text.

        Args:
            position: position of the anchor, mm.
            text: the text.
            height: mm.
            rotation: rotation of the baseline, anticlockwise, deg.
            anchor: "start" or "middle" of the text.
        """
        length = LETTER_WIDTH * height * len(text)
        along = direction_vector(radians(rotation))
        first = position - (0.5 * length * along if anchor == "middle" else 0.0)
        self._reach(np.array([first, first + length * along, first + height * rotate_quarter(along)]))
        x, y = position
        self.elements.append(
            f'<text x="{x:.4f}" y="{-y:.4f}" font-size="{height:.4f}" text-anchor="{anchor}" '
            f'transform="rotate({-rotation:.4f} {x:.4f} {-y:.4f})">{escape(text, quote=False)}</text>'
        )

    def document(self, title: str) -> str:
        """Return the SVG of all elements, in mm, with a margin around them."""
        margin = 2 * self.t
        width, height = self.high - self.low + 2 * margin
        left, top = self.low[0] - margin, -self.high[1] - margin
        widths = {"wide": 0.13, "medium": 0.11, "thin": 0.06, "thin2": 0.25, "long": 1.2, "short": 0.25}
        sizes = {name: f"{share * self.t:.4f}" for name, share in widths.items()}
        rules = "".join(
            f".{layer.lower()}{{fill:none;{style.format(**sizes)}}}" for layer, style in LINE_STYLES.items()
        )
        return "\n".join(
            (
                f'<svg xmlns="http://www.w3.org/2000/svg" width="{width:.3f}mm" height="{height:.3f}mm" '
                f'viewBox="{left:.4f} {top:.4f} {width:.4f} {height:.4f}">',
                f"<title>{escape(title, quote=False)}</title>",
                f"<style>{rules}.arrow{{fill:#444}}text{{font-family:sans-serif;fill:#111}}</style>",
                f'<rect x="{left:.4f}" y="{top:.4f}" width="{width:.4f}" height="{height:.4f}" fill="#fff"/>',
                *self.elements,
                "</svg>\n",
            )
        )


def _draw_distance(canvas: _Canvas, dimension: Distance) -> None:
    """Draw a distance: extension lines, the line between two arrows, and its label."""
    t, along, ends = canvas.t, direction_vector(radians(dimension.direction)), dimension.ends
    for point, end in zip(np.array((dimension.first, dimension.second)), ends, strict=True):
        extension = end - point
        length = float(np.hypot(*extension))
        if length > DIMENSION_GAP * t:
            extension /= length
            line = np.array([point + DIMENSION_GAP * t * extension, end + DIMENSION_OVERHANG * t * extension])
            canvas.path(line, "DIMENSIONS")
    canvas.path(ends, "DIMENSIONS")
    canvas.arrow(ends[1], along)
    canvas.arrow(ends[0], -along)
    rotation = 90.0 - (90.0 - dimension.direction) % 180.0  # readable from below or the right
    upright = rotate_quarter(direction_vector(radians(rotation)))
    canvas.text((ends[0] + ends[1]) / 2 + 0.35 * t * upright, dimension.label, t, rotation, "middle")


def _draw_diameter(canvas: _Canvas, dimension: Diameter) -> None:
    """Draw a diameter: a leader from the rim to its label."""
    t, out = canvas.t, direction_vector(radians(dimension.direction))
    rim, knee = (np.array(dimension.centre) + reach * out for reach in (dimension.radius, dimension.leader_length))
    side = 1.0 if out[0] >= 0 else -1.0
    length = LETTER_WIDTH * t * (len(dimension.label) + 1)
    shelf = knee + np.array([side * length, 0.0])
    canvas.path(np.array([rim, knee, shelf]), "DIMENSIONS")
    canvas.arrow(rim, -out)
    start = knee if side > 0 else shelf
    canvas.text(start + np.array([0.3 * t, 0.3 * t]), dimension.label, t, 0.0, "start")


LAYER_STYLES: dict[Layer, tuple[int, str]] = {
    "OUTLINE": (7, "CONTINUOUS"),
    "CENTRE": (8, "CENTER"),
    "STRAP": (1, "CONTINUOUS"),
    "HOSE": (5, "CONTINUOUS"),
    "DIMENSIONS": (8, "CONTINUOUS"),
    "TEXT": (7, "CONTINUOUS"),
}
"""Colour index and line type of each layer; only OUTLINE is to be cut."""


def dxf_text(sheet: Sheet) -> str:
    """Return the DXF document of a sheet; raise MissingExtraError if ezdxf is not installed."""
    ezdxf = extras.import_extra("drawing", "ezdxf", where="DXF drawing")
    document = ezdxf.new("R2010", setup=True)
    document.units = ezdxf.units.MM
    for name, (colour, line) in LAYER_STYLES.items():
        document.layers.add(name, color=colour, linetype=line)
    space = document.modelspace()
    for path in sheet.paths:
        space.add_lwpolyline(path.points.tolist(), close=path.closed, dxfattribs={"layer": path.layer})
    for circle in sheet.circles:
        space.add_circle(circle.centre, circle.radius, dxfattribs={"layer": circle.layer})
    for note in sheet.notes:
        text = space.add_text(note.text, height=note.size * sheet.text_height, dxfattribs={"layer": "TEXT"})
        text.set_placement(note.at)
    _add_dimensions(space, sheet)
    stream = io.StringIO()
    document.write(stream)
    return stream.getvalue()


def _add_dimensions(space: "Modelspace", sheet: Sheet) -> None:
    """Add all dimensions of a sheet to a DXF drawing, as entities that CAD programs can edit."""
    t = sheet.text_height
    style: dict[str, Any] = {
        "dimtxt": t, "dimasz": 0.8 * t, "dimexo": 0.3 * t, "dimexe": 0.5 * t, "dimgap": 0.3 * t, "dimlfac": 1.0,
        "dimscale": 1.0, "dimdec": 3, "dimzin": 0, "dimtad": 1, "dimtsz": 0.0, "dimblk": "", "dimtmove": 1,
    }  # fmt: skip
    look: dict[str, Any] = {"override": style, "dxfattribs": {"layer": "DIMENSIONS"}}
    for distance in sheet.distances:
        points = distance.base, distance.first, distance.second
        space.add_linear_dim(*points, angle=distance.direction, text=distance.label, **look).render()
    for circle in sheet.diameters:
        location = circle.centre + circle.leader_length * direction_vector(radians(circle.direction))
        geometry: dict[str, Any] = {"radius": circle.radius, "angle": circle.direction, "location": location}
        space.add_diameter_dim(circle.centre, **geometry, text=circle.label, **look).render()
