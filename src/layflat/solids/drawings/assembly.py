"""Sheets of assemblies: views with item numbers and overall sizes, and the list of items; mm."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from layflat.lazy import numpy as np
from layflat.solids.drawings.arrangement import Around, arrange_views
from layflat.solids.drawings.balloons import BALLOON_DISTANCE, BALLOON_RADIUS, draw_balloons
from layflat.solids.drawings.dimensions import Labels
from layflat.solids.drawings.layout import scale_text
from layflat.solids.drawings.paper import Paper
from layflat.solids.drawings.projection import FRONT_VIEW, LEFT_VIEW, TOP_VIEW, Projection, cut, project
from layflat.solids.drawings.sheets import mass_text
from layflat.solids.drawings.table import number_text
from layflat.solids.drawings.text import fit_height
from layflat.solids.drawings.title import (
    BLOCK_WIDTH,
    FRAME_MARGIN,
    TABLE_TEXT,
    Area,
    TitleBlock,
    draw_frame,
    draw_list,
    draw_title_block,
    free_areas,
)
from layflat.solids.drawings.views import View
from layflat.solids.shapes import place

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from layflat.arrays import Array
    from layflat.solids.component import Component
    from layflat.solids.shapes import PartPlace

AROUND_VIEWS = Around(BALLOON_DISTANCE + BALLOON_RADIUS + 8.0, BALLOON_DISTANCE + BALLOON_RADIUS + 1.0)
ROWS_OF_COLUMN = 50  # of the list
BLACK_THICKNESS = 0.6  # thickness of a part on the paper up to which its section is black


class AssemblySheet(NamedTuple):
    """Components that a sheet shows, each with the number or name of its item."""

    title: str
    machine: str
    file: str
    components: Sequence[Component]
    items: Sequence[str]
    frame: PartPlace  # in which its views lie
    joint: bool  # one joint, which is cut in its middle; else many
    mass: float  # kg


class DrawnMachine(NamedTuple):
    """Machine that is drawn; components with the same number are one item of its list."""

    name: str
    components: Sequence[Component]
    numbers: Sequence[int]  # of their items
    masses: Sequence[float]  # of one part of each component, kg

    def mass(self, joint: str | None = None) -> float:
        """Return the mass of the whole, or of a joint without the link behind it, kg."""
        links = _link_parts(self.components)
        return sum(
            one.quantity * mass
            for one, mass, link in zip(self.components, self.masses, links, strict=True)
            if joint is None or (one.joint == joint and not link)
        )


def assemblies(machine: DrawnMachine) -> list[AssemblySheet]:
    """Return the assemblies of a machine: its only joint, or the whole, with joints as items, and each joint."""
    name, components = machine.name, machine.components
    texts = [str(number) for number in machine.numbers]
    links = _link_parts(components)
    joints = list(dict.fromkeys(one.joint for one in components))
    if len(joints) == 1 and not any(links):
        return [
            AssemblySheet(
                "assembly", name, "00-assembly", components, texts, components[0].places[0], True, machine.mass()
            )
        ]
    items = [
        one.joint if one.joint and not link else text for one, text, link in zip(components, texts, links, strict=True)
    ]
    found = [AssemblySheet("assembly", name, "00-assembly", components, items, place(), False, machine.mass())]
    for joint in filter(None, joints):
        own = [
            (one, text)
            for one, text, link in zip(components, texts, links, strict=True)
            if one.joint == joint and not link
        ]
        parts, names = zip(*own, strict=True)
        title, file, mass = f"joint {joint}", f"00-joint-{joint}", machine.mass(joint)
        found.append(AssemblySheet(title, name, file, parts, names, parts[0].places[0], True, mass))
    return found


def _link_parts(components: Sequence[Component]) -> list[bool]:
    """Return for each component whether it belongs to the link behind its joint: it follows the link's first part."""
    begun: set[str] = set()
    found = []
    for one in components:
        if "link" in one.tags:
            begun.add(one.joint)
        found.append(one.joint in begun)
    return found


def _views(assembly: AssemblySheet) -> list[Projection]:
    """Return the views of an assembly: from the front, from the left, and a joint's section or a view from above."""
    parts, items, frame = assembly.components, assembly.items, assembly.frame
    if assembly.joint:
        # The frame's z-axis is the cylinder's; the section goes through the middle of the cylinder, the first part.
        height = getattr(parts[0].shape, "height", 0.0)
        frame = place(z=height / 2).then(frame)
    views = [project("front", parts, items, FRONT_VIEW, frame), project("left", parts, items, LEFT_VIEW, frame)]
    section = cut("section in the middle", parts, items, frame) if assembly.joint else None
    if section is not None and section.shadows:
        return [*views, section]
    return [*views, project("seen from above", parts, items, TOP_VIEW, frame)]


def assembly_sheet(assembly: AssemblySheet) -> Paper:
    """Return the sheet of an assembly."""
    views = _views(assembly)
    sizes = [(float(w), float(h)) for w, h in (view.box[1] - view.box[0] for view in views)]
    found = arrange_views(sizes, AROUND_VIEWS, formats=("A3",))
    paper = Paper(found.format, f"{assembly.machine}: {assembly.title}")
    labels, s = Labels(paper), found.scale
    chosen = _chosen_views(views)
    for k, (view, (left, high)) in enumerate(zip(views, found.corners, strict=True)):
        low_corner, high_corner = view.box
        placed = View(labels, s, left - s * float(low_corner[0]), high - s * float(high_corner[1]))
        _draw_view(placed, view)
        _draw_balloons_and_sizes(placed, view, {item: point for item, (n, point) in chosen.items() if n == k}, k)
    hidden = sorted(set(assembly.items) - set(chosen), key=lambda item: (len(item), item))
    if hidden:
        area = free_areas(found.format)[0]
        note = f"Not visible: {', '.join(hidden)}."
        paper.text(area.right - 2.0, area.low + 2.0, note, fit_height(note, TABLE_TEXT, BLOCK_WIDTH - 4.0), "right")
    _finish(paper, assembly, scale_text(s))
    return paper


def _chosen_views(views: Sequence[Projection]) -> dict[str, tuple[int, Array]]:
    """Return for each visible item the view that shows most of it, and a point of it there."""
    best: dict[str, tuple[int, int, Array]] = {}
    for k, view in enumerate(views):
        for item, (count, point) in view.visible().items():
            if item not in best or count > best[item][0]:
                best[item] = count, k, point
    return {item: (k, point) for item, (_, k, point) in best.items()}


def _draw_view(placed: View, view: Projection) -> None:
    """Draw the shadows of a view, further ones first."""
    for k, shadow in enumerate(view.shadows):
        lines = [placed.paper_points(line) for line in shadow.lines]
        if not view.section:
            placed.paper.area(lines, "part", "white")
            continue
        placed.paper.area(
            lines, "part", "black" if _thickness(lines[0]) < BLACK_THICKNESS else ("hatched", "hatched back")[k % 2]
        )
        for pocket in shadow.white:
            placed.paper.area([placed.paper_points(pocket)], "none", "white")


def _thickness(line: Array) -> float:
    """Return the thickness of a thin area within a closed line (n, 2): twice its area over its length."""
    x, y = line.T
    area = abs(float(x @ np.roll(y, -1) - y @ np.roll(x, -1))) / 2
    return 2 * area / float(np.hypot(*(line - np.roll(line, 1, axis=0)).T).sum())


def _draw_balloons_and_sizes(placed: View, view: Projection, points: dict[str, Array], number: int) -> None:
    """Draw balloons around a view, the title of the third, and overall sizes below and on the left of others.

    Args:
        placed: where.
        view: the projection.
        points: a point of each item that has a balloon here.
        number: of the view, from 0 on.
    """
    draw_balloons(placed, view, points)
    (x, y), (x_2, y_2) = view.box
    out = BALLOON_DISTANCE + BALLOON_RADIUS + 6.0
    if number == 2:
        left, low = placed.paper_points((x, y))
        placed.paper.text(float(left), float(low) - out, view.title)
    if number < 2:  # the third view shows no other size
        placed.distance((x, y), (x_2, y), -out, number_text(float(x_2 - x), 1))
    if number == 0:
        placed.distance((x, y), (x, y_2), -out, number_text(float(y_2 - y), 1), upright=True)


def list_sheet(assembly: AssemblySheet, items: Mapping[int, Component]) -> Paper:
    """Return the sheet with the list of all items.

    Args:
        assembly: the whole, for the title block.
        items: components by number, each with all its places.
    """
    paper = Paper("A3", f"{assembly.machine}: list of items")
    rows = [
        (str(number), f"{one.name}{', ' + one.designation if one.designation else ''}", str(one.quantity))
        for number, one in items.items()
    ]
    whole = free_areas("A3")[0]
    columns = -(-len(rows) // ROWS_OF_COLUMN)
    draw_list(paper, rows, Area(whole.left + 2, whole.low + 4, whole.right - 2, whole.high - FRAME_MARGIN / 2), columns)
    _finish(paper, assembly._replace(title="list of items", file="00-list"), "-")
    return paper


def _finish(paper: Paper, assembly: AssemblySheet, scale: str) -> None:
    """Draw frame and title block."""
    draw_frame(paper)
    title, machine, file = assembly.title, assembly.machine, assembly.file
    draw_title_block(
        paper,
        TitleBlock(machine, title, "-", "1", "-", "-", "assembly", "-", mass_text(assembly.mass), "-", scale, file),
    )
