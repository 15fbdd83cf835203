"""Drawing sheets of single parts: pattern, side view or section, sizes, hole table, title block; mm."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from layflat.lazy import numpy as np
from layflat.solids.drawings.arrangement import Around, arrange_views
from layflat.solids.drawings.dimensions import Labels
from layflat.solids.drawings.edge import draw_side
from layflat.solids.drawings.flat import FlatPart, cut_by_contour, cut_length, flat_part
from layflat.solids.drawings.joined import draw_joined, joined_views, piece_note
from layflat.solids.drawings.layout import Layout, fitting_layout, scale_text
from layflat.solids.drawings.paper import Paper
from layflat.solids.drawings.plan import draw_plan
from layflat.solids.drawings.pockets import pocket_notes
from layflat.solids.drawings.table import HoleTable, drilled_table, hole_table, number_text
from layflat.solids.drawings.title import TitleBlock, draw_frame, draw_notes, draw_table, draw_title_block, free_areas
from layflat.solids.drawings.turned import CHAIN_STEP, FIRST_OFFSET, draw_sizes, draw_turned, faces, sides_of
from layflat.solids.drawings.views import View
from layflat.solids.loops import CurveSide
from layflat.solids.shapes import Joined, Turned
from layflat.solids.standard.materials import material
from layflat.solids.standard.processes import PROCESSES

if TYPE_CHECKING:
    from layflat.arrays import Array
    from layflat.solids.component import Component
    from layflat.solids.drawings.table import Fits

VIEW_MARGIN = 16.0  # of dimensions and labels around a view
VIEW_GAP = 20.0  # two views
SOFT_MATERIALS = frozenset(
    {"hose", "webbing", "rubber", "steel-strip"}
)  # materials that need no deburring, or no side view
IN_AXIS = 1e-6  # product of a direction along two axes, below which it lies along one
SOFT_TOLERANCE = "ISO 2768-c"  # of processes without one of their own


@dataclass(frozen=True)
class PartSheet:
    """Part with what its sheet states."""

    component: Component
    number: str
    mass: float  # of one, kg
    machine: str
    file: str  # name of the drawing, without a suffix
    fits: Fits


def part_sheet(part: PartSheet) -> Paper:
    """Return the drawing sheet of a part."""
    shape = part.component.shape
    if isinstance(shape, Turned):
        return _turned_sheet(part, shape)
    if isinstance(shape, Joined):
        return _joined_sheet(part, shape)
    pattern = flat_part(part.component)
    assert pattern is not None
    return _flat_sheet(part, pattern)


def _flat_sheet(part: PartSheet, pattern: FlatPart) -> Paper:
    table = hole_table(pattern, part.fits)
    table_or_none = table if table.rows else None
    w, h = (float(x) for x in pattern.box[1] - pattern.box[0])
    side = _side_box(part, pattern)
    sw, sh = side[1] - side[0] if side is not None else (0.0, 0.0)
    around, gap = 2 * VIEW_MARGIN, VIEW_GAP if side is not None else 0.0
    above = CHAIN_STEP * len(pattern.pockets)  # of the dimensions of pockets
    needs = [(w + sw, max(h, sh), around + gap, around + above)]
    if side is not None and pattern.profile is None:
        needs.append((max(w, sh), h + sw, around, around + gap))
    layout, arrangement = fitting_layout(needs, table_or_none)
    paper = Paper(layout.format, part.file)
    s, area = layout.scale, layout.area
    labels = Labels(paper)
    below = arrangement == 1
    total_w = s * (w if below else w + sw) + (0 if below else gap)
    total_h = s * (h + sw if below else max(h, sh)) + (gap if below else 0)
    left = (area.left + area.right - total_w) / 2
    top = (area.low + area.high + total_h - above) / 2
    # In the middle of the rows of views, or on top of the other view.
    middle = top - s * h / 2 if below else top - total_h / 2
    view = View(labels, s, left - s * float(pattern.box[0, 0]), middle - s * float(pattern.box[:, 1].mean()))
    _draw_flat_sizes(view, part, pattern)
    if side is not None:
        _draw_side_view(view, pattern, side, below=below)
    draw_plan(view, pattern, origin=bool(table.rows or pattern.pockets))
    _finish(paper, part, layout, table_or_none, _flat_notes(part, pattern))
    return paper


def _side_box(part: PartSheet, pattern: FlatPart) -> Array | None:
    """Return the box of the view beside a plan, (2, 2): a bent part's profile, or a plate from its edge, else None."""
    if pattern.profile is not None:
        points = pattern.profile.points()
        return np.array([points.min(axis=0), points.max(axis=0)])
    if part.component.material in SOFT_MATERIALS:
        return None
    (_, low), (_, high) = pattern.box
    return np.array([[0.0, low], [pattern.thickness, high]])


def _draw_flat_sizes(view: View, part: PartSheet, pattern: FlatPart) -> None:
    """Dimension the width and the height of a pattern; a round one has a diameter."""
    from layflat.solids.drawings.contours import as_circle  # noqa: PLC0415

    if as_circle(pattern.outline) is not None:
        return
    (x, y), (x_2, y_2) = pattern.box
    stated = cut_length(part.component)
    length = stated if stated is not None and abs(stated - (x_2 - x)) < 0.1 else x_2 - x
    view.distance((x, y), (x_2, y), -FIRST_OFFSET, number_text(length, 1))
    view.distance((x, y), (x, y_2), -FIRST_OFFSET, number_text(y_2 - y, 1), upright=True)


def _draw_side_view(view: View, pattern: FlatPart, box: Array, *, below: bool) -> None:
    """Draw the view beside or below a plan, and the thickness."""
    s, labels = view.scale, view.labels
    (_, y), (x_2, y_2) = pattern.box
    t = number_text(pattern.thickness, 1)
    if pattern.profile is not None:
        low = view.y + s * (y + y_2) / 2 - s * float(box[:, 1].mean())
        side = View(labels, s, view.x + s * x_2 + VIEW_GAP - s * float(box[0, 0]), low)
        side.line(pattern.profile.points(), "outline", closed=True)
        labels.paper.text(
            side.x + s * float(box[:, 0].mean()),
            side.y + s * float(box[1, 1]) + 4.0,
            f"profile, t = {t}",
            0.0,
            "center",
        )
    elif below:
        side = View(labels, s, view.x, view.y + s * y - VIEW_GAP)
        draw_side(side, pattern, below=True)
        side.distance((x_2, -pattern.thickness), (x_2, 0.0), FIRST_OFFSET, t, upright=True)
    else:
        side = View(labels, s, view.x + s * x_2 + VIEW_GAP, view.y)
        draw_side(side, pattern, below=False)
        side.distance((0.0, y), (pattern.thickness, y), -FIRST_OFFSET, t)
        for k, (first, last) in enumerate(dict.fromkeys((low, high) for _, low, high in pattern.pockets)):
            side.distance((first, y_2), (last, y_2), FIRST_OFFSET + k * CHAIN_STEP, number_text(last - first, 1))


def _flat_notes(part: PartSheet, pattern: FlatPart) -> list[str]:
    """Return the notes of a pattern's sheet."""
    component = part.component
    notes = []
    if cut_by_contour(component, pattern):
        curved = any(isinstance(side, CurveSide) for side in pattern.outline.sides)
        notes.append(f"Contour: {part.file}.dxf{' (spline)' if curved else ''}.")
    if pattern.bends:
        notes.append("Flat pattern, developed at mid-thickness; thin lines: edges of bent zones.")
        notes += [f"x {number_text(bend.start, 1)} to {number_text(bend.end, 1)}: {bend}." for bend in pattern.bends]
    if component.material in SOFT_MATERIALS:
        notes.append(f"Laid flat; thickness {number_text(pattern.thickness, 1)}, {component.designation}.")
    if any(
        abs(hole.direction[2]) < 0.5 and abs(hole.direction[0] * hole.direction[1]) > IN_AXIS
        for hole in pattern.drilled
    ):
        notes.append("Directions of holes are angles from x, anticlockwise.")
    return notes + pocket_notes(pattern)


def _turned_sheet(part: PartSheet, shape: Turned) -> Paper:
    table = drilled_table(shape.drilled, part.fits)
    table_or_none = table if table.rows else None
    all_faces = faces(shape)
    length = max(face.high for face in all_faces) - min(face.low for face in all_faces)
    diameter = 2 * max(face.radius for face in all_faces)
    left, right = sides_of(all_faces)
    chains = 2 if sum(not face.bore for face in all_faces) > 1 else 1
    around_w = VIEW_MARGIN + 6.0 + CHAIN_STEP * (len(left) + len(right))
    around_h = VIEW_MARGIN + CHAIN_STEP * chains + 4.0
    layout, _ = fitting_layout([(length, diameter, around_w, around_h)], table_or_none)
    paper = Paper(layout.format, part.file)
    s, area = layout.scale, layout.area
    low = min(face.low for face in all_faces)
    x = (area.left + area.right - s * length + CHAIN_STEP * (len(left) - len(right))) / 2 - s * low
    view = View(Labels(paper), s, x, (area.low + area.high + CHAIN_STEP * chains) / 2)
    draw_sizes(view, shape, part.fits, part.component.designation)
    draw_turned(view, shape)
    notes = ["z along the axis from the left end." if low == 0 else f"The left end lies at z = {number_text(low, 1)}."]
    _finish(paper, part, layout, table_or_none, notes if table.rows else [])
    return paper


def _joined_sheet(part: PartSheet, shape: Joined) -> Paper:
    views = joined_views(part.component, shape)
    table = drilled_table(views.holes, part.fits)
    table_or_none = table if table.rows else None
    boxes = [view.box for view in views.projections]
    sizes = [(float(w), float(h)) for w, h in (box[1] - box[0] for box in boxes)]
    format_, s, corners = arrange_views(sizes, Around(VIEW_MARGIN, 0.6 * VIEW_MARGIN), table_or_none)
    paper = Paper(format_, part.file)
    labels = Labels(paper)
    for k, (box, (left, high)) in enumerate(zip(boxes, corners, strict=True)):
        draw_joined(View(labels, s, left - s * float(box[0, 0]), high - s * float(box[1, 1])), views, k)
    size = part.component.size
    notes = [f"{size[:1].upper()}{size[1:]}."] if size else []
    notes.append(piece_note(shape))
    _finish(paper, part, Layout(format_, s, free_areas(format_, table_or_none)[0]), table_or_none, notes)
    return paper


def _finish(paper: Paper, part: PartSheet, layout: Layout, table: HoleTable | None, notes: list[str]) -> None:
    """Draw frame, title block, table and notes."""
    component = part.component
    one = material(component.material)
    name = component.material
    process = PROCESSES.get(component.making)
    if table is not None:
        corner = free_areas(layout.format)[0]
        draw_table(paper, table, corner.right - 1.0, corner.high - 1.0)
    if component.material not in SOFT_MATERIALS:
        notes = [*notes, "Edges deburred."]
    draw_notes(paper, notes)
    draw_frame(paper)
    draw_title_block(
        paper,
        TitleBlock(
            machine=part.machine,
            name=component.name,
            number=part.number,
            quantity=str(component.quantity),
            material=one.grade if one.grade.casefold().startswith(name.casefold()) else f"{name}, {one.grade}",
            stock=component.designation or "-",
            making=component.making,
            tolerance=process.tolerance if process else SOFT_TOLERANCE,
            mass=mass_text(part.mass),
            assembly=component.joint or "-",
            scale=scale_text(layout.scale),
            file=part.file,
        ),
    )


def mass_text(mass: float) -> str:
    """Return a mass (kg) in g, or from 1 kg on in kg."""
    return f"{mass * 1e3:.3g} g" if mass < 1 else f"{mass:.3g} kg"
