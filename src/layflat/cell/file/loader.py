"""From a description file, or the name of a built-in cell, to a validated `Cell`."""

from __future__ import annotations

import tomllib
from difflib import get_close_matches
from importlib.resources import files
from pathlib import Path
from typing import Any

from pydantic import BaseModel, ValidationError

from layflat.cell.file.model import Cell
from layflat.cell.file.parts import Layout
from layflat.description.provenance import split
from layflat.errors import CellError, MachineError
from layflat.machine import load as load_machine
from layflat.machine.loader import Plain, Sources, explained, laid_over, omit
from layflat.machine.loader import names as machine_names

BUILT_IN = files("layflat.cell.file") / "builtin"


def names() -> tuple[str, ...]:
    """Names of the built-in cells."""
    return _named("")


def layout_names() -> tuple[str, ...]:
    """Names of the built-in layouts of packs."""
    return _named("layouts")


def load(cell: str | Path | Cell) -> Cell:
    """A cell from its built-in name or from a TOML file; a `Cell` is passed through.

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
        plain["machine"] = load_machine(_beside(where, plain["machine"], machine_names()))
    if isinstance(plain.get("pack"), dict):
        plain["pack"] = {name: _with_layout(pack, where) for name, pack in plain["pack"].items()}
    if isinstance(plain.get("network"), dict) and "file" in plain["network"]:
        plain["network"] = plain["network"] | {"file": str(Path(where).parent / str(plain["network"]["file"]))}
    cell: Cell = _validated(Cell, plain, where)
    cell._provenance.update(sources)
    cell._origin = where
    return cell


def tables(cell: str | Path) -> tuple[Plain, Sources]:
    """The plain values of a description as they are written, what it extends included, and where they come from.

    Raises:
        CellError: the file is missing or broken.
    """
    return _read(str(cell), "", ())


def _with_layout(pack: Any, where: str) -> Any:
    if not isinstance(pack, dict) or not isinstance(pack.get("layout"), str):
        return pack
    place = _beside(where, pack["layout"], layout_names())
    return pack | {"layout": _validated(Layout, _read(place, "layouts", ())[0], place)}


def _validated(kind: type[BaseModel], plain: Plain, where: str) -> Any:
    try:
        return kind.model_validate(plain)
    except ValidationError as error:
        found = explained(error.errors()[0], where, kind, "the built-in cell 'packing' is")
        raise CellError(found.what, where=found.where, right=found.right) from None


def _beside(where: str, name: str, built_in: tuple[str, ...]) -> str:
    """A built-in name as it is, a file as seen from the file that names it."""
    is_file = name.endswith(".toml") and name not in built_in and where not in names()
    return str(Path(where).parent / name) if is_file else name


def _read(where: str, folder: str, seen: tuple[str, ...]) -> tuple[Plain, Sources]:
    if where in seen:
        raise CellError(f"extends itself through {' -> '.join(seen)}", where=where, right="break the circle")
    try:
        raw = tomllib.loads(_text(where, folder))
    except tomllib.TOMLDecodeError as error:
        raise CellError(f"is not TOML: {error}", where=where, right='values look like height = "60 mm"') from None
    base, omitted = raw.pop("extends", None), raw.pop("omits", [])
    if not isinstance(base, str | None):
        raise CellError(f"{base!r} is not a name", where=f"{where}: extends", right='give one such as "packing"')
    under: tuple[Plain, Sources] = ({}, {})
    if base is not None:
        under = _read(_beside(where, base, _named(folder)), folder, (*seen, where))
    try:
        for path in omitted:
            omit(*under, path, where)
        plain, sources = split(raw, where)
    except MachineError as error:
        raise CellError(error.what, where=error.where, right=error.right) from None
    return laid_over(under[0], plain), under[1] | sources


def text(cell: str) -> str:
    """A cell's file as it is written, of a built-in name or a path.

    Raises:
        CellError: it can't be read.
    """
    return _text(cell, "")


def _text(where: str, folder: str) -> str:
    if where in _named(folder):
        return (BUILT_IN / folder / f"{where}.toml").read_text(encoding="utf-8")
    path = Path(where)
    known = ", ".join(_named(folder))
    if not path.suffix and not path.exists():
        near = get_close_matches(path.name, _named(folder), n=1)
        hint = f"did you mean {near[0]!r}?" if near else f"built in: {known}"
        raise CellError(f"no such {'layout' if folder else 'cell'}", where=where, right=hint)
    try:
        return path.read_text(encoding="utf-8")
    except OSError as error:
        right = f"give the path of a TOML file, or a built-in name: {known}"
        raise CellError(f"can't be read ({error.strerror})", where=where, right=right) from None
    except UnicodeDecodeError:
        raise CellError("is not a text file in UTF-8", where=where, right="give a TOML file") from None


def _named(folder: str) -> tuple[str, ...]:
    entries = (BUILT_IN / folder if folder else BUILT_IN).iterdir()
    return tuple(sorted(entry.name.removesuffix(".toml") for entry in entries if entry.name.endswith(".toml")))
