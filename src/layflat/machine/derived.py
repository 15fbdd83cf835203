"""Descriptions that a search wrote: what it found, laid over the description that it began with."""

from collections.abc import Callable, Mapping
from copy import deepcopy
from pathlib import Path
from typing import Any, TypeVar

from layflat.description.provenance import Provenance
from layflat.errors import InputError, MachineError
from layflat.files import whole_file
from layflat.machine.listing import to_toml
from layflat.machine.loader import MACHINES, load, names, tables
from layflat.machine.model import Machine

Loaded = TypeVar("Loaded")


def derived_path(given: str, folder: Path, suffix: str) -> Path:
    """Return where a description derived from a built-in machine or a file is put: NAME-tuned.toml, after its name.

    Raises:
        InputError: it would overwrite a file that it is derived from.
    """
    path = folder / f"{tables(given)[0].get('name', Path(given).stem)}-{suffix}.toml"
    if given in names():
        return path
    if path.resolve() in [Path(layer.where).resolve() for layer in MACHINES.layers(given)]:
        right = "give another folder"
        raise InputError("would be overwritten by what is derived from it", where=str(path), right=right)
    return path


def write_derived(
    given: str, title: str, values: Mapping[str, Any], sources: Mapping[str, Provenance], path: Path
) -> Machine:
    """Write a description that stands on its own wherever it is moved to, and load what was written.

    Args:
        given: built-in name or file of the base; what a file extends is included.
        title: of the description.
        values: as they stand in a file, by dotted path; items of a list by their number ("....deflections.0").
        sources: of these values; of a list, that of its last item is kept.
        path: from `derived_path`.

    Raises:
        MachineError: the values make no description; nothing is replaced then.
        OutputError: it can't be written there.
    """
    base, known = tables(given)
    plain: dict[str, Any] = {"extends": given} if given in names() else deepcopy(base)
    plain |= {"name": path.stem, "title": title}
    noted = {} if given in names() else dict(known)
    for key, value in values.items():
        noted[with_value(plain, base, key, value)] = sources[key]
    return write_loadable(path, to_toml(plain, noted), load)


def write_loadable(path: Path, text: str, load_file: Callable[[Path], Loaded]) -> Loaded:
    """Write a description and return it as loaded again; what does not load replaces nothing.

    Args:
        path: where it is put.
        text: TOML.
        load_file: loads a description from a path.

    Raises:
        MachineError: the text is no description.
        OutputError: it can't be written there.
    """
    with whole_file(path) as temporary:
        temporary.write_text(text, encoding="utf-8")
        try:
            load_file(temporary)
        except InputError as error:
            where = error.where.replace(str(temporary), str(path))
            raise MachineError(error.what, where=where, right=error.right) from None
    return load_file(path)


def with_value(plain: dict[str, Any], base: dict[str, Any], path: str, value: Any) -> str:
    """Put a value into nested tables; of a list, what `plain` does not have is taken from `base`.

    Returns:
        Where it stands: the path, without the number of an item.
    """
    *parts, last = path.split(".")
    if last.isdigit():
        items = at_path(plain, parts) or at_path(base, parts)
        value = [value if i == int(last) else item for i, item in enumerate(items)]
        *parts, last = parts
    table = plain
    for part in parts:
        table = table.setdefault(part, {})
    table[last] = value
    return ".".join([*parts, last])


def at_path(table: Any, keys: list[str]) -> Any:
    """What stands in nested tables and lists, or None."""
    for key in keys:
        table = table[int(key)] if isinstance(table, list) else table.get(key) if isinstance(table, dict) else None
    return table
