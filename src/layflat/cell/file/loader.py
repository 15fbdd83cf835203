"""From a description file, or the name of a built-in cell, to a validated `Cell`."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from pydantic import BaseModel, ValidationError

from layflat.cell.file.checks import check
from layflat.cell.file.former import rename_keys
from layflat.cell.file.model import Cell
from layflat.cell.file.parts import Layout
from layflat.description.explain import explained
from layflat.description.library import Library
from layflat.description.provenance import Sources
from layflat.description.tables import Plain
from layflat.errors import CellError
from layflat.machine import load as load_machine
from layflat.machine.libraries import MACHINES

BUILT_IN = Path(__file__).parent / "builtin"


class CellLibrary(Library):
    """Cells, whose files may have the keys of earlier versions."""

    def raw(self, where: str | Path) -> Plain:
        """Return the tables of one description with present keys.

        Raises:
            CellError: it can't be read or is not TOML.
        """
        plain = super().raw(where)
        rename_keys(plain)
        return plain


CELLS = CellLibrary(BUILT_IN, "cell", "`layflat cells` lists them", 'height = "60 mm"', CellError)
LAYOUTS = Library(BUILT_IN / "layouts", "layout", "built in are punnet-2x3 and tray-12", 'height = "60 mm"', CellError)


def names() -> tuple[str, ...]:
    """Return the names of the built-in cells."""
    return CELLS.names


def layout_names() -> tuple[str, ...]:
    """Return the names of the built-in layouts of containers."""
    return LAYOUTS.names


def load(cell: str | Path | Cell) -> Cell:
    """Return a cell from its built-in name or from a TOML file; a `Cell` is passed through.

    Raises:
        CellError: in one line, which file, key and value is wrong and what would be right.
        MachineError: the same about the machine that it names.
    """
    return cell if isinstance(cell, Cell) else build(*tables(cell), str(cell))


def build(plain: Plain, sources: Sources, where: str) -> Cell:
    """Validate plain tables into a cell; machine and layouts may be names or files beside `where`.

    Raises:
        CellError, MachineError: as `load`.
    """
    plain = dict(plain)
    if isinstance(plain.get("machine"), str):
        plain["machine"] = load_machine(MACHINES.beside(where, plain["machine"]))
    if isinstance(plain.get("container"), dict):
        plain["container"] = {name: _with_layout(one, where) for name, one in plain["container"].items()}
    if isinstance(plain.get("network"), dict) and "file" in plain["network"]:
        plain["network"] = plain["network"] | {"file": str(Path(where).parent / str(plain["network"]["file"]))}
    cell: Cell = _validated(Cell, plain, where)
    try:
        check(cell)
    except ValueError as error:
        raise CellError(str(error), where=where) from None
    cell._provenance.update(sources)
    cell._origin = where
    return cell


def tables(cell: str | Path) -> tuple[Plain, Sources]:
    """Return the plain values of a description as they are written, what it extends included, and their sources.

    Raises:
        CellError: the file is missing or broken.
    """
    return CELLS.tables(cell)


def text(cell: str) -> str:
    """Return a cell's file as it is written, of a built-in name or a path.

    Raises:
        CellError: it can't be read.
    """
    return CELLS.text(cell)


def _with_layout(container: Any, where: str) -> Any:
    if not isinstance(container, dict) or not isinstance(container.get("layout"), str):
        return container
    place = LAYOUTS.beside(where, container["layout"])
    return container | {"layout": _validated(Layout, LAYOUTS.tables(place)[0], place)}


def _validated(kind: type[BaseModel], plain: Plain, where: str) -> Any:
    try:
        return kind.model_validate(plain)
    except ValidationError as error:
        raise explained(error, where, kind, CellError, "`layflat cells packing` shows a complete description") from None
