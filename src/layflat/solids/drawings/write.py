"""Writing of all drawings of a machine: a sheet of each part that is made, contours, assemblies and the list."""

from __future__ import annotations

import re
from dataclasses import replace
from typing import TYPE_CHECKING

from layflat import extras
from layflat.files import whole_file
from layflat.solids.drawings.assembly import assemblies, assembly_sheet, list_sheet
from layflat.solids.drawings.contours import contour_text
from layflat.solids.drawings.flat import cut_by_contour, flat_part
from layflat.solids.drawings.paper import svg_and_pdf
from layflat.solids.drawings.sheets import PartSheet, part_sheet
from layflat.solids.drawings.table import fits_of
from layflat.solids.parts_list import common_name
from layflat.solids.standard.materials import material

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence
    from pathlib import Path

    from layflat.solids.component import Component
    from layflat.solids.drawings.paper import Paper


def write_drawings(
    components: Sequence[Component],
    numbers: Sequence[int],
    mass: Callable[[Component], float],
    folder: Path,
    *,
    machine: str,
    progress: Callable[[int, int], object] = lambda *_: None,
) -> list[Path]:
    """Write drawings of a machine: of its assemblies, and of each part that is made; return the files.

    A sheet is one SVG and one PDF; parts that are cut along a contour have a DXF too, if ezdxf, which the extra
    `drawing` brings, is installed. The same machine gives the same bytes.

    Args:
        components: of the machine.
        numbers: of the items of the list; components with the same number are one item.
        mass: function that returns the mass of one of a component, kg.
        folder: that the files go to; it is made.
        machine: name on the sheets.
        progress: function that is called with the number of sheets that are written, and of all.

    Returns:
        Paths of the files; none for a machine without components.

    Raises:
        OutputError: the folder can't be written.
    """
    if not components:
        return []
    fits, contours = fits_of(components), extras.available("drawing")
    items = merge_items(components, numbers)
    made = {number: one for number, one in items.items() if not one.bought}
    total_mass = sum(one.quantity * mass(one) for one in components)
    groups = assemblies(components, numbers, machine)
    total, files = len(made) + len(groups) + 1, []
    for number, one in made.items():
        name = f"{number:02d}-{file_stem(one.name)}"
        files += _write_sheet(part_sheet(PartSheet(one, str(number), mass(one), machine, name, fits)), folder / name)
        part = flat_part(one)
        if contours and part is not None and cut_by_contour(one, part):
            notes = (f"{machine}, item {number}, quantity {one.quantity}", _stock_note(one))
            files.append(_write(folder / f"{name}.dxf", contour_text(part, one.name, notes).encode()))
        progress(len({path.stem for path in files}), total)
    for group in groups:
        group_mass = sum(one.quantity * mass(one) for one in group.components)
        files += _write_sheet(assembly_sheet(group, group_mass), folder / file_stem(group.file))
        progress(len({path.stem for path in files}), total)
    files += _write_sheet(list_sheet(groups[0], items, total_mass), folder / "00-list")
    progress(total, total)
    return files


def merge_items(components: Sequence[Component], numbers: Sequence[int]) -> dict[int, Component]:
    """Return the component of each number, in order, with the places and the common name of all that have it.

    Args:
        components: of a machine.
        numbers: of their items.
    """
    rows: dict[int, list[Component]] = {}
    for number, one in zip(numbers, components, strict=True):
        rows.setdefault(number, []).append(one)
    return {
        number: replace(
            row[0],
            name=common_name(list(dict.fromkeys(one.name for one in row))),
            places=tuple(at for one in row for at in one.places),
            joint=", ".join(dict.fromkeys(one.joint for one in row)),
        )
        for number, row in sorted(rows.items())
    }


def file_stem(name: str) -> str:
    """Return a name as a part of file names: letters, digits, points and underscores, other characters as a dash."""
    return re.sub(r"[^\w.]+", "-", name).strip("-")


def _stock_note(component: Component) -> str:
    return ", ".join(text for text in (material(component.material).grade, component.designation) if text)


def _write_sheet(paper: Paper, path: Path) -> list[Path]:
    """Write a sheet as SVG and PDF beside each other, and return their paths."""
    svg, pdf = svg_and_pdf(paper)
    return [_write(path.with_name(f"{path.name}.svg"), svg), _write(path.with_name(f"{path.name}.pdf"), pdf)]


def _write(path: Path, content: bytes) -> Path:
    with whole_file(path) as temporary:
        temporary.write_bytes(content)
    return path
