"""Loading of cells: from a description file, or the name of a built-in one, to a validated `Cell`."""

from pathlib import Path
from typing import Any

from pydantic import BaseModel, ValidationError

from layflat.cell.file.checks import check
from layflat.cell.file.model import Cell
from layflat.cell.file.parts import ContainerLayout
from layflat.description.explain import explain_error
from layflat.description.library import Library
from layflat.description.tables import Plain, Sources
from layflat.errors import CellError
from layflat.machine import load as load_machine
from layflat.machine.loader import MACHINE_LIBRARY

BUILT_IN = Path(__file__).parent / "builtin"

CELL_LIBRARY = Library(BUILT_IN, "cell", "`layflat cell list` lists them", 'height = "60 mm"', CellError)
LAYOUT_LIBRARY = Library(
    BUILT_IN / "layouts", "layout", "built in are punnet-2x3 and tray-12", 'height = "60 mm"', CellError
)
text = CELL_LIBRARY.text


def names() -> tuple[str, ...]:
    """Return the names of the built-in cells."""
    return CELL_LIBRARY.names


def load(cell: str | Path | Cell) -> Cell:
    """Return a cell from its built-in name or from a TOML file; a `Cell` is passed through.

    CellError says in one line which file, key and value is wrong, MachineError the same of the machine that it names.
    """
    return cell if isinstance(cell, Cell) else build_cell(*CELL_LIBRARY.tables(cell), str(cell))


def build_cell(plain: Plain, sources: Sources, where: str) -> Cell:
    """Validate plain tables into a cell, and return it; raise as `load`.

    Args:
        plain: tables; the machine and layouts may be names, or files relative to `where`, as the network's file.
        sources: sources of the values.
        where: path of the file, or name of the built-in cell.
    """
    plain = dict(plain)
    if isinstance(plain.get("machine"), str):
        plain["machine"] = load_machine(MACHINE_LIBRARY.resolve(where, plain["machine"]))
    if isinstance(plain.get("container"), dict):
        plain["container"] = {name: _load_layout(one, where) for name, one in plain["container"].items()}
    if isinstance(plain.get("network"), dict) and "file" in plain["network"]:
        plain["network"] = plain["network"] | {"file": str(Path(where).parent / str(plain["network"]["file"]))}
    cell: Cell = _validate(Cell, plain, where)
    try:
        check(cell)
    except ValueError as error:
        raise CellError(str(error), where=where) from None
    cell._provenance.update(sources)
    cell._origin = where
    return cell


def _load_layout(container: Any, where: str) -> Any:
    """Return a container's table with its named layout loaded; other tables are returned unchanged."""
    if not isinstance(container, dict) or not isinstance(container.get("layout"), str):
        return container
    place = LAYOUT_LIBRARY.resolve(where, container["layout"])
    return container | {"layout": _validate(ContainerLayout, LAYOUT_LIBRARY.tables(place)[0], place)}


def _validate(kind: type[BaseModel], plain: Plain, where: str) -> Any:
    """Return a validated part of a description; raise CellError in one line, with its file."""
    try:
        return kind.model_validate(plain)
    except ValidationError as error:
        raise explain_error(
            error, where, kind, CellError, "`layflat cell show packing` shows a complete description"
        ) from None
