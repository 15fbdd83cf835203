"""From a description file, or the name of a built-in cell, to a validated `Cell`."""

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from pydantic import BaseModel, ValidationError

from layflat.cell.file.checks import check
from layflat.cell.file.model import Cell
from layflat.cell.file.parts import Layout
from layflat.description.explain import explained
from layflat.description.library import Library
from layflat.description.provenance import Sources
from layflat.description.tables import Plain
from layflat.errors import CellError
from layflat.machine import load as load_machine
from layflat.machine.loader import MACHINES

BUILT_IN = Path(__file__).parent / "builtin"
ROTATED = ("camera", "tray.*", "container.*", "base_markers.marker.*")  # tables that have an angle of rotation


class CellLibrary(Library):
    """Cells, whose files may have the keys of earlier versions: `pack` for `container`, `turn` for `rotation`."""

    def raw(self, where: str | Path) -> Plain:
        """Return the tables of one description with present keys; raise CellError if it can't be read or is no TOML."""
        plain = super().raw(where)
        _rename(plain, "pack", "container")
        for path in ROTATED:
            for table in _tables(plain, path):
                _rename(table, "turn", "rotation")
        if isinstance(omits := plain.get("omits"), list):
            plain["omits"] = [_present(path) if isinstance(path, str) else path for path in omits]
        return plain


CELLS = CellLibrary(BUILT_IN, "cell", "`layflat cells` lists them", 'height = "60 mm"', CellError)
LAYOUTS = Library(BUILT_IN / "layouts", "layout", "built in are punnet-2x3 and tray-12", 'height = "60 mm"', CellError)
text = CELLS.text


def names() -> tuple[str, ...]:
    """Return the names of the built-in cells."""
    return CELLS.names


def load(cell: str | Path | Cell) -> Cell:
    """Return a cell from its built-in name or from a TOML file; a `Cell` is passed through.

    CellError says in one line which file, key and value is wrong, MachineError the same of the machine that it names.
    """
    return cell if isinstance(cell, Cell) else build(*CELLS.tables(cell), str(cell))


def build(plain: Plain, sources: Sources, where: str) -> Cell:
    """Validate plain tables into a cell; machine and layouts may be names or files beside `where`. Raise as `load`."""
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


def _tables(plain: Plain, path: str) -> Iterator[Plain]:
    """Yield the tables at a dotted path, in which * is any name."""
    head, _, rest = path.partition(".")
    for table in list(plain.values()) if head == "*" else [plain.get(head)]:
        if isinstance(table, dict):
            yield from _tables(table, rest) if rest else [table]


def _rename(table: Plain, former: str, present: str) -> None:
    if former in table and present not in table:
        table[present] = table.pop(former)


def _present(path: str) -> str:
    """Return a dotted path of a description with present names."""
    return re.sub(r"\.turn$", ".rotation", re.sub(r"^pack(?=\.|$)", "container", path))
