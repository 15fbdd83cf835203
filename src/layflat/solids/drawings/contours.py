"""Contours of flat parts as DXF files, for laser cutters, mills and benders; needs ezdxf, the extra `drawing`.

Layers: OUTLINE and HOLES are cut, BEND has the edges of bent zones, NOTES the hole table and texts.
"""

from __future__ import annotations

import io
from contextlib import contextmanager
from math import atan2, degrees, hypot, pi, tan
from typing import TYPE_CHECKING, Any

from layflat import extras
from layflat.lazy import numpy as np
from layflat.solids.drawings.table import hole_table
from layflat.solids.loops import ArcSide, CurveSide, HullCircle, StraightSide, arc_centre

if TYPE_CHECKING:
    from collections.abc import Iterator

    from layflat.solids.drawings.flat import FlatPart
    from layflat.solids.loops import Loop, Point

LAYER_STYLES = {
    "OUTLINE": (7, "CONTINUOUS"),
    "HOLES": (5, "CONTINUOUS"),
    "BEND": (1, "DASHED"),
    "NOTES": (8, "CONTINUOUS"),
}
"""Colour index and line type of each layer."""
LARGEST_TEXT, SMALLEST_TEXT = 3.5, 1.0  # height of notes, mm
TEXTS_ACROSS = 30.0  # size of a part over the height of its notes
ROW_HEIGHT = 1.7  # height of a row of notes over that of their text
COLUMN_WIDTH = 7.0  # width of a column of the hole table over the height of its text


def contour_text(part: FlatPart, title: str, notes: tuple[str, ...] = ()) -> str:
    """Return the DXF document of a pattern, in mm.

    Args:
        part: the pattern.
        title: first line of its notes.
        notes: further lines.

    Raises:
        MissingExtraError: ezdxf is not installed.
    """
    ezdxf = extras.import_extra("drawing", "ezdxf", where="DXF drawing")
    with _dateless(ezdxf):
        document = _document(ezdxf, part, (title, *notes))
        stream = io.StringIO()
        document.write(stream)
    return stream.getvalue()


@contextmanager
def _dateless(ezdxf: Any) -> Iterator[None]:
    """Keep ezdxf from writing dates and random identifiers, so that the same part gives the same file."""
    before = ezdxf.options.write_fixed_meta_data_for_testing
    ezdxf.options.write_fixed_meta_data_for_testing = True
    try:
        yield
    finally:
        ezdxf.options.write_fixed_meta_data_for_testing = before


def _document(ezdxf: Any, part: FlatPart, lines: tuple[str, ...]) -> Any:
    """Return ezdxf's document of a pattern with lines of notes."""
    document = ezdxf.new("R2010", setup=True)
    document.units = ezdxf.units.MM
    for name, (colour, line) in LAYER_STYLES.items():
        document.layers.add(name, color=colour, linetype=line)
    space = document.modelspace()
    add_loop(space, part.outline, "OUTLINE")
    for opening in part.openings:
        add_loop(space, opening, "OUTLINE")
    for hole in part.holes:
        space.add_circle(hole.centre, hole.diameter / 2, dxfattribs={"layer": "HOLES"})
    (_, low), (_, high) = part.box
    for x in sorted({x for bend in part.bends for x in (bend.start, bend.end)}):
        space.add_line((x, low), (x, high), dxfattribs={"layer": "BEND"})
    _add_notes(space, part, lines)
    for name in sorted(document.entitydb.dxf_types_in_use()):  # ezdxf adds what is missing in the order of a set
        document.classes.add_class(name)
    return document


def add_loop(space: Any, loop: Loop, layer: str) -> None:
    """Add a loop to a drawing: as a circle, as one closed line of straight and round pieces, or piece by piece.

    Args:
        space: ezdxf's model space.
        loop: the loop; smooth curves become splines through their points.
        layer: of the entities.
    """
    look: dict[str, Any] = {"layer": layer}
    ring = as_circle(loop)
    if ring is not None:
        space.add_circle((ring.x, ring.y), ring.radius, dxfattribs=look)
    elif not any(isinstance(side, CurveSide) for side in loop.sides):
        starts = [loop.start, *(side.end for side in loop.sides[:-1])]
        corners = [(*start, _bulge(start, side)) for start, side in zip(starts, loop.sides, strict=True)]
        space.add_lwpolyline(corners, format="xyb", close=True, dxfattribs=look)
    else:
        _add_pieces(space, loop, look)


def as_circle(loop: Loop) -> HullCircle | None:
    """Return the circle that a loop of two arcs is, or None."""
    match loop.sides:
        case (ArcSide(via, to), ArcSide(via_2, _)):
            (x, y), (x_2, y_2) = arc_centre(loop.start, via, to), arc_centre(to, via_2, loop.start)
            radius = hypot(loop.start[0] - x, loop.start[1] - y)
            return HullCircle(x, y, radius) if hypot(x - x_2, y - y_2) < 1e-9 * radius else None
    return None


def turn_of_arc(start: Point, arc: ArcSide) -> tuple[Point, float]:
    """Return the centre of an arc, and the angle by which it turns, rad; above 0 anticlockwise."""
    x, y = arc_centre(start, arc.via, arc.end)
    first, middle, last = (atan2(p[1] - y, p[0] - x) for p in (start, arc.via, arc.end))
    turn = (last - first) % (2 * pi)
    return (x, y), turn if (middle - first) % (2 * pi) <= turn else turn - 2 * pi


def _bulge(start: Point, side: StraightSide | ArcSide | CurveSide) -> float:
    """Return the bulge of a piece of a line in DXF: the tangent of a quarter of its angle, 0 for a straight one."""
    return tan(turn_of_arc(start, side)[1] / 4) if isinstance(side, ArcSide) else 0.0


def _add_pieces(space: Any, loop: Loop, look: dict[str, Any]) -> None:
    """Add the sides of a loop one by one."""
    start = loop.start
    for side in loop.sides:
        match side:
            case StraightSide(to):
                space.add_line(start, to, dxfattribs=look)
            case ArcSide(_, to):
                (x, y), turn = turn_of_arc(start, side)
                ends = [degrees(atan2(p[1] - y, p[0] - x)) for p in (start, to)]
                space.add_arc(
                    (x, y), hypot(start[0] - x, start[1] - y), *(ends if turn > 0 else ends[::-1]), dxfattribs=look
                )
            case CurveSide(through):
                space.add_spline_control_frame([start, *through], dxfattribs=look)
        start = side.end


def _add_notes(space: Any, part: FlatPart, lines: tuple[str, ...]) -> None:
    """Write notes and the hole table below a pattern, and the number of each hole beside it."""
    (left, low), (right, high) = part.box
    size = float(np.clip(max(right - left, high - low) / TEXTS_ACROSS, SMALLEST_TEXT, LARGEST_TEXT))
    look: dict[str, Any] = {"layer": "NOTES"}

    def write(text: str, x: float, y: float, height: float = size) -> None:
        space.add_text(text, height=height, dxfattribs=look).set_placement((x, y))

    table = hole_table(part)
    bends = [f"bend {x.start:.2f} to {x.end:.2f}: {x}" for x in part.bends]
    y = low - 2 * ROW_HEIGHT * size
    for text in (*lines, *bends):
        write(text, left, y)
        y -= ROW_HEIGHT * size
    for row in (table.head, *table.rows) if table.rows else ():
        for k, text in enumerate(row):
            write(text, left + k * COLUMN_WIDTH * size, y)
        y -= ROW_HEIGHT * size
    for number, hole in enumerate(part.holes, 1):
        (x, y), reach = hole.centre, hole.diameter / 2
        write(str(number), x + 0.8 * reach, y + 0.8 * reach, 0.6 * size)
