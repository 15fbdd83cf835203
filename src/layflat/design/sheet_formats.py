"""A sheet as SVG and as DXF.

In SVG, true to scale in mm, dimensions are lines, arrows and text. In DXF (R2010, mm) CAD programs can edit them; ezdxf
is an extra: `layflat[drawing]`.
"""

import io
from html import escape
from math import radians
from typing import TYPE_CHECKING, Any

import numpy as np

from layflat import extras
from layflat.arrays import Array
from layflat.design.sheet import Diameter, Distance, Layer, Point, Sheet
from layflat.design.straplines import turned, unit

STYLES: dict[Layer, str] = {  # of lines; text has none
    "OUTLINE": "stroke:#111;stroke-width:{wide}",
    "CENTRE": "stroke:#888;stroke-width:{thin};stroke-dasharray:{long} {thin2} {short} {thin2}",
    "STRAP": "stroke:#b5341c;stroke-width:{medium}",
    "HOSE": "stroke:#2a6f97;stroke-width:{medium}",
    "DIMENSIONS": "stroke:#444;stroke-width:{thin}",
}

ARROW, GAP, PAST = 0.8, 0.3, 0.5  # length of an arrow, gap at a point, reach past the dimension line, in text heights
LETTER = 0.58  # width of a letter in text heights


def svg_text(sheet: Sheet) -> str:
    """Return the SVG document of a sheet."""
    t = sheet.text_height
    drawn = _Canvas(t)
    for distance in sheet.distances:
        _distance(drawn, distance)
    for diameter in sheet.diameters:
        _diameter(drawn, diameter)
    for path in sheet.paths:
        drawn.path(path.points, path.layer, closed=path.closed)
    for circle in sheet.circles:
        drawn.circle(circle.centre, circle.radius, circle.layer)
    for note in sheet.notes:
        drawn.text(np.array(note.at), note.text, note.size * t, 0.0, "start")
    return drawn.document(sheet.title)


class _Canvas:
    """Collects elements, and how far they reach, in mm with y upwards."""

    def __init__(self, text_height: float) -> None:
        self.t = text_height
        self.elements: list[str] = []
        self.low = np.full(2, np.inf)
        self.high = np.full(2, -np.inf)

    def _reach(self, points: Array) -> None:
        self.low = np.minimum(self.low, points.min(axis=0))
        self.high = np.maximum(self.high, points.max(axis=0))

    def path(self, points: Array, layer: Layer, *, closed: bool = False) -> None:
        self._reach(points)
        steps = " L".join(f"{x:.4f},{-y:.4f}" for x, y in points)
        self.elements.append(f'<path class="{layer.lower()}" d="M{steps}{"Z" if closed else ""}"/>')

    def circle(self, centre: Point, radius: float, layer: Layer) -> None:
        middle = np.array(centre)
        self._reach(np.array([middle - radius, middle + radius]))
        x, y = centre
        self.elements.append(f'<circle class="{layer.lower()}" cx="{x:.4f}" cy="{-y:.4f}" r="{radius:.4f}"/>')

    def arrow(self, tip: Array, direction: Array) -> None:
        back, across = tip - ARROW * self.t * direction, 0.15 * self.t * turned(direction)
        corners = (tip, back + across, back - across)
        points = " ".join(f"{x:.4f},{-y:.4f}" for x, y in corners)
        self.elements.append(f'<polygon class="arrow" points="{points}"/>')

    def text(self, at: Array, text: str, height: float, rotation: float, anchor: str) -> None:
        long = LETTER * height * len(text)
        along = unit(radians(rotation))
        first = at - (0.5 * long * along if anchor == "middle" else 0.0)
        self._reach(np.array([first, first + long * along, first + height * turned(along)]))
        x, y = at
        self.elements.append(
            f'<text x="{x:.4f}" y="{-y:.4f}" font-size="{height:.4f}" text-anchor="{anchor}" '
            f'transform="rotate({-rotation:.4f} {x:.4f} {-y:.4f})">{escape(text, quote=False)}</text>'
        )

    def document(self, title: str) -> str:
        margin = 2 * self.t
        width, height = self.high - self.low + 2 * margin
        left, top = self.low[0] - margin, -self.high[1] - margin
        widths = {"wide": 0.13, "medium": 0.11, "thin": 0.06, "thin2": 0.25, "long": 1.2, "short": 0.25}
        sizes = {name: f"{share * self.t:.4f}" for name, share in widths.items()}
        rules = "".join(f".{layer.lower()}{{fill:none;{style.format(**sizes)}}}" for layer, style in STYLES.items())
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


def _distance(drawn: _Canvas, dimension: Distance) -> None:
    t, along, ends = drawn.t, unit(radians(dimension.direction)), dimension.ends
    for point, end in zip(np.array((dimension.first, dimension.second)), ends, strict=True):
        away = end - point
        far = float(np.hypot(*away))
        if far > GAP * t:
            away /= far
            drawn.path(np.array([point + GAP * t * away, end + PAST * t * away]), "DIMENSIONS")
    drawn.path(ends, "DIMENSIONS")
    drawn.arrow(ends[1], along)
    drawn.arrow(ends[0], -along)
    rotation = 90.0 - (90.0 - dimension.direction) % 180.0  # readable from below or the right
    upright = turned(unit(radians(rotation)))
    drawn.text((ends[0] + ends[1]) / 2 + 0.35 * t * upright, dimension.label, t, rotation, "middle")


def _diameter(drawn: _Canvas, dimension: Diameter) -> None:
    t, out = drawn.t, unit(radians(dimension.direction))
    rim, knee = (np.array(dimension.centre) + reach * out for reach in (dimension.radius, dimension.lead))
    side = 1.0 if out[0] >= 0 else -1.0
    long = LETTER * t * (len(dimension.label) + 1)
    shelf = knee + np.array([side * long, 0.0])
    drawn.path(np.array([rim, knee, shelf]), "DIMENSIONS")
    drawn.arrow(rim, -out)
    start = knee if side > 0 else shelf
    drawn.text(start + np.array([0.3 * t, 0.3 * t]), dimension.label, t, 0.0, "start")


if TYPE_CHECKING:
    from ezdxf.layouts.layout import Modelspace

LAYERS: dict[Layer, tuple[int, str]] = {
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
    ezdxf = extras.module("drawing", "ezdxf", where="DXF drawing")
    document = ezdxf.new("R2010", setup=True)
    document.units = ezdxf.units.MM
    for name, (colour, line) in LAYERS.items():
        document.layers.add(name, color=colour, linetype=line)
    space = document.modelspace()
    for path in sheet.paths:
        space.add_lwpolyline(path.points.tolist(), close=path.closed, dxfattribs={"layer": path.layer})
    for circle in sheet.circles:
        space.add_circle(circle.centre, circle.radius, dxfattribs={"layer": circle.layer})
    for note in sheet.notes:
        text = space.add_text(note.text, height=note.size * sheet.text_height, dxfattribs={"layer": "TEXT"})
        text.set_placement(note.at)
    _dimensions(space, sheet)
    stream = io.StringIO()
    document.write(stream)
    return stream.getvalue()


def _dimensions(space: "Modelspace", sheet: Sheet) -> None:
    t = sheet.text_height
    style: dict[str, Any] = {
        "dimtxt": t, "dimasz": 0.8 * t, "dimexo": 0.3 * t, "dimexe": 0.5 * t, "dimgap": 0.3 * t, "dimlfac": 1.0,
        "dimscale": 1.0, "dimdec": 3, "dimzin": 0, "dimtad": 1, "dimtsz": 0.0, "dimblk": "", "dimtmove": 1,
    }  # fmt: skip
    look: dict[str, Any] = {"override": style, "dxfattribs": {"layer": "DIMENSIONS"}}
    for one in sheet.distances:
        space.add_linear_dim(one.base, one.first, one.second, angle=one.direction, text=one.label, **look).render()
    for circle in sheet.diameters:
        at = circle.centre + circle.lead * unit(radians(circle.direction))
        where: dict[str, Any] = {"radius": circle.radius, "angle": circle.direction, "location": at}
        space.add_diameter_dim(circle.centre, **where, text=circle.label, **look).render()
