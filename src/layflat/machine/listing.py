"""Descriptions as text: lines with their sources, TOML, JSON Schema, and those that a search wrote."""

import json
from collections.abc import Callable, Mapping
from copy import deepcopy
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

from layflat.description.provenance import SOURCES, Provenance, Sources
from layflat.description.tables import Plain, leaves
from layflat.errors import InputError, MachineError
from layflat.files import whole_file
from layflat.machine.loader import MACHINES, load, names, tables
from layflat.machine.model import Machine


@dataclass(frozen=True)
class Line:
    """One value of a description."""

    path: str
    text: str
    source: str
    note: str


def listing(plain: Plain, sources: Sources) -> list[Line]:
    """Every value of a description that its arm uses, as written, with its source."""
    used = {f"joint.{name}" for name in plain.get("arm", {}).get("joints", [])}
    lines = []
    for path, value in leaves(plain):
        parts = path.split(".")
        if path in {"kind", "name", "title"} or (parts[0] == "joint" and ".".join(parts[:2]) not in used):
            continue
        source = sources.get(path, Provenance())
        lines.append(Line(path, _text(value), source.source, source.note))
    return lines


def _text(value: Any) -> str:
    if isinstance(value, dict):
        return "; ".join(f"{key} = {_text(one)}" for key, one in value.items())
    if isinstance(value, list):
        return (" / " if any(isinstance(one, dict) for one in value) else ", ").join(map(_text, value))
    return str(value)


def to_toml(plain: Plain, sources: Sources) -> str:
    """Plain values and their sources as TOML text that `load` takes back."""
    import tomli_w  # noqa: PLC0415

    return tomli_w.dumps(_joined(plain, sources, ""))


def _joined(table: Plain, sources: Sources, prefix: str) -> Plain:
    joined: Plain = {}
    for key, value in table.items():
        path = f"{prefix}.{key}" if prefix else key
        source = sources.get(path, Provenance())
        if isinstance(value, dict):
            joined[key] = _joined(value, sources, path)
        elif source == Provenance():
            joined[key] = value
        else:
            joined[key] = {"value": value, "source": source.source} | ({"note": source.note} if source.note else {})
    return joined


def schema_text() -> str:
    """JSON Schema of description files."""
    schema = Machine.model_json_schema()
    definitions = schema.pop("$defs", {})
    schema["title"] = "layflat machine"
    schema["properties"]["extends"] = {"type": "string", "description": "built-in name or file to lay this one over"}
    schema["properties"]["omits"] = {
        "type": "array",
        "items": {"type": "string"},
        "description": "parts left out of it",
    }
    schema.pop("required", None)
    opened = {name: _with_sources(entry) for name, entry in definitions.items()}
    schema["properties"] = {key: _sourced(entry) for key, entry in schema["properties"].items()}
    return json.dumps({"$schema": "https://json-schema.org/draft/2020-12/schema", **schema, "$defs": opened}, indent=2)


def _with_sources(definition: dict[str, Any]) -> dict[str, Any]:
    """A part whose keys may be left to the description that it extends, and whose values may carry a source."""
    open_definition = {key: value for key, value in definition.items() if key != "required"}
    open_definition["properties"] = {key: _sourced(entry) for key, entry in definition.get("properties", {}).items()}
    return open_definition


def _sourced(entry: dict[str, Any]) -> dict[str, Any]:
    if "oneOf" in entry:  # kinds: what a file leaves to the one that it extends may tell them apart
        return {("anyOf" if key == "oneOf" else key): value for key, value in entry.items()}
    if "$ref" in entry or entry.get("type") == "object" or "anyOf" in entry:
        return entry
    plain = {key: value for key, value in entry.items() if key != "description"}
    with_source = {
        "type": "object",
        "properties": {"value": plain, "source": {"enum": list(SOURCES)}, "note": {"type": "string"}},
        "required": ["value"],
        "additionalProperties": False,
    }
    kept = {key: entry[key] for key in ("description",) if key in entry}
    return {**kept, "anyOf": [plain, with_source]}


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
    """Return what stands in nested tables and lists, or None."""
    for key in keys:
        table = table[int(key)] if isinstance(table, list) else table.get(key) if isinstance(table, dict) else None
    return table
