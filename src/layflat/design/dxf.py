"""A sheet as DXF (R2010, mm), with dimensions that CAD programs can edit. ezdxf is an extra: `layflat[drawing]`."""

import io
from math import radians
from typing import TYPE_CHECKING, Any

from layflat import extras
from layflat.design.sheet import Layer, Sheet
from layflat.design.straplines import unit

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
