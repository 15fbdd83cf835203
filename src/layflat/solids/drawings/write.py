"""Writing of all drawings of a machine: a sheet of each part that is made, contours, assemblies and the list."""

from __future__ import annotations

import re
from dataclasses import replace
from typing import TYPE_CHECKING, NamedTuple

from layflat import extras
from layflat.files import whole_file
from layflat.solids.drawings.assembly import DrawnMachine, assemblies, assembly_sheet, list_sheet
from layflat.solids.drawings.contours import contour_text
from layflat.solids.drawings.flat import cut_by_contour, flat_part
from layflat.solids.drawings.paper import svg_and_pdf
from layflat.solids.drawings.sheets import PartSheet, part_sheet
from layflat.solids.drawings.table import fits_of
from layflat.solids.parts_list import common_name
from layflat.solids.standard.materials import material

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator, Sequence
    from pathlib import Path

    from layflat.solids.component import Component
    from layflat.solids.drawings.paper import Paper


class SheetFiles(NamedTuple):
    """Files of a drawing."""

    paths: list[Path]
    total: int  # number of drawings of the machine


def write_drawings(
    machine: DrawnMachine,
    folder: Path,
    drawn: Iterable[SheetFiles] = (),
    progress: Callable[[int, int], object] = lambda *_: None,
) -> list[Path]:
    """Write drawings of a machine: of its assemblies, and of each part that is made; return the files.

    A sheet is one SVG and one PDF; parts that are cut along a contour have a DXF too, if ezdxf, which the extra
    `drawing` brings, is installed. The same machine gives the same bytes.

    Args:
        machine: the machine.
        folder: that the files go to; it is made.
        drawn: the first values of `draw_sheets`, from another process that writes them; default: none.
        progress: function that is called with the number of sheets that are written, and of all.

    Returns:
        Paths of the files; none for a machine without components.

    Raises:
        OutputError: the folder can't be written.
    """
    sheets: list[SheetFiles] = []

    def collect(written: Iterable[SheetFiles]) -> None:
        for one in written:
            sheets.append(one)
            progress(len(sheets), one.total)

    collect(drawn)
    collect(draw_sheets(machine, folder, len(sheets)))
    return [path for one in sheets for path in one.paths]


def draw_sheets(machine: DrawnMachine, folder: Path, done: int = 0) -> Iterator[SheetFiles]:
    """Yield the files of each drawing of a machine once they are written.

    Args:
        machine: the machine.
        folder: that the files go to; files of these names in it are replaced.
        done: number of the first drawings that are left out.
    """
    if not machine.components:
        return
    items, fits = merge_items(machine.components, machine.numbers), fits_of(machine.components)
    made = [(number, one) for number, one in items.items() if not one.bought]
    groups = assemblies(machine)
    total = len(made) + len(groups) + 1
    for number, one in made[done:]:
        mass = machine.masses[list(machine.numbers).index(number)]
        name = f"{number:02d}-{file_stem(one.name)}"
        files = _write_sheet(part_sheet(PartSheet(one, str(number), mass, machine.name, name, fits)), folder / name)
        yield SheetFiles([*files, *_write_contour(one, number, machine.name, folder / f"{name}.dxf")], total)
    for group in groups[max(done - len(made), 0) :]:
        yield SheetFiles(_write_sheet(assembly_sheet(group), folder / file_stem(group.file)), total)
    if done < total:
        yield SheetFiles(_write_sheet(list_sheet(groups[0], items), folder / "00-list"), total)


def _write_contour(component: Component, number: int, machine: str, path: Path) -> list[Path]:
    """Write the contour along which a part is cut, if there is one; return the paths of what is written.

    Args:
        component: the part.
        number: of its item.
        machine: name of the machine.
        path: of the file.
    """
    part = flat_part(component)
    if part is None or not extras.available("drawing") or not cut_by_contour(component, part):
        return []
    notes = (f"{machine}, item {number}, quantity {component.quantity}", _stock_note(component))
    return [_write(path, contour_text(part, component.name, notes).encode())]


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
    with whole_file(path, owned=True) as temporary:
        temporary.write_bytes(content)
    return path
