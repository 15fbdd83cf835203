"""Descriptions as text: values with their sources, TOML, JSON Schema, and descriptions derived from others."""

import json
from collections.abc import Callable, Mapping
from copy import deepcopy
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

from layflat.description.tables import SOURCE_NAMES, Plain, Provenance, Sources, leaves
from layflat.errors import InputError, MachineError
from layflat.files import whole_file
from layflat.machine.loader import MACHINE_LIBRARY, load, names, tables
from layflat.machine.model import Machine


@dataclass(frozen=True)
class ListedValue:
    """Value of a description as text, with its source."""

    path: str
    text: str
    source: str
    note: str


def list_values(plain: Plain, sources: Sources) -> list[ListedValue]:
    """Return every value of a description as text with its source; a list is one value.

    Joints that the arm does not use are left out, and so are kind, name and title of the machine.

    Args:
        plain: plain values of the description, with their units.
        sources: sources by dotted path; a value without one has that of `Provenance()`.
    """
    used = {f"joint.{name}" for name in plain.get("arm", {}).get("joints", [])}
    lines = []
    for path, value in leaves(plain):
        parts = path.split(".")
        if path in {"kind", "name", "title"} or (parts[0] == "joint" and ".".join(parts[:2]) not in used):
            continue
        source = sources.get(path, Provenance())
        lines.append(ListedValue(path, _format_value(value), source.source, source.note))
    return lines


def _format_value(value: Any) -> str:
    """Return a value of a description as text for people; lists by commas, tables by semicolons."""
    if isinstance(value, dict):
        return "; ".join(f"{key} = {_format_value(item)}" for key, item in value.items())
    if isinstance(value, list):
        return (" / " if any(isinstance(item, dict) for item in value) else ", ").join(map(_format_value, value))
    return str(value)


def to_toml(plain: Plain, sources: Sources) -> str:
    """Return plain values and their sources as TOML text that `load` reads.

    A value with a source becomes a table of value, source and note.
    """
    import tomli_w  # noqa: PLC0415

    return tomli_w.dumps(_join_sources(plain, sources, ""))


def _join_sources(table: Plain, sources: Sources, prefix: str) -> Plain:
    """Return a table whose values with a source are tables of value, source and note."""
    joined: Plain = {}
    for key, value in table.items():
        path = f"{prefix}.{key}" if prefix else key
        source = sources.get(path, Provenance())
        if isinstance(value, dict):
            joined[key] = _join_sources(value, sources, path)
        elif source == Provenance():
            joined[key] = value
        else:
            joined[key] = {"value": value, "source": source.source} | ({"note": source.note} if source.note else {})
    return joined


def schema_text() -> str:
    """Return the JSON Schema of description files as text."""
    schema = Machine.model_json_schema()
    definitions = schema.pop("$defs", {})
    schema["title"] = "layflat machine"
    schema["description"] = schema["description"].partition("\n")[0]
    schema["properties"]["extends"] = {"type": "string", "description": "built-in name or file to lay this one over"}
    schema["properties"]["omits"] = {
        "type": "array",
        "items": {"type": "string"},
        "description": "parts left out of it",
    }
    schema.pop("required", None)
    opened = {name: _with_sources(entry) for name, entry in definitions.items()}
    schema["properties"] = {key: _allow_source(entry) for key, entry in schema["properties"].items()}
    return json.dumps({"$schema": "https://json-schema.org/draft/2020-12/schema", **schema, "$defs": opened}, indent=2)


def _with_sources(definition: dict[str, Any]) -> dict[str, Any]:
    """Return the schema of a part with optional keys, as files extend others, and with sources of values."""
    open_definition = {key: value for key, value in definition.items() if key != "required"}
    open_definition["properties"] = {
        key: _allow_source(entry) for key, entry in definition.get("properties", {}).items()
    }
    return open_definition


def _allow_source(entry: dict[str, Any]) -> dict[str, Any]:
    """Return the JSON schema of an entry that may also be a table of value, source and note."""
    if "oneOf" in entry:  # kinds: the key that distinguishes them may be inherited
        return {("anyOf" if key == "oneOf" else key): value for key, value in entry.items()}
    if "$ref" in entry or entry.get("type") == "object" or "anyOf" in entry:
        return entry
    plain = {key: value for key, value in entry.items() if key != "description"}
    with_source = {
        "type": "object",
        "properties": {"value": plain, "source": {"enum": list(SOURCE_NAMES)}, "note": {"type": "string"}},
        "required": ["value"],
        "additionalProperties": False,
    }
    kept = {key: entry[key] for key in ("description",) if key in entry}
    return {**kept, "anyOf": [plain, with_source]}


Loaded = TypeVar("Loaded")


def derived_path(base: str, folder: Path, suffix: str) -> Path:
    """Return the path NAME-SUFFIX.toml of a description derived from a built-in machine or a file.

    Args:
        base: built-in name or file.
        folder: folder of the result.
        suffix: such as "tuned".

    Raises:
        InputError: it would overwrite a file that it is derived from.
    """
    path = folder / f"{tables(base)[0].get('name', Path(base).stem)}-{suffix}.toml"
    if base in names():
        return path
    if path.resolve() in [Path(layer.where).resolve() for layer in MACHINE_LIBRARY.layers(base)]:
        right = "give another folder"
        raise InputError("would be overwritten by what is derived from it", where=str(path), right=right)
    return path


def write_derived(
    base: str, title: str, values: Mapping[str, Any], sources: Mapping[str, Provenance], path: Path
) -> Machine:
    """Write a self-contained description and return the machine loaded from it.

    Args:
        base: built-in name or file; the values of a file are included in the result.
        title: title of the description.
        values: values as they stand in a file, by dotted path; items of a list by their number ("....deflections.0").
        sources: sources of these values; of a list, that of its last item is kept.
        path: path of the result, from `derived_path`.

    Raises:
        MachineError: the values make no description; nothing is replaced then.
        OutputError: it can't be written there.
    """
    base_values, base_sources = tables(base)
    plain: dict[str, Any] = {"extends": base} if base in names() else deepcopy(base_values)
    plain |= {"name": path.stem, "title": title}
    noted = {} if base in names() else dict(base_sources)
    for key, value in values.items():
        noted[set_nested_value(plain, base_values, key, value)] = sources[key]
    return write_loadable(path, to_toml(plain, noted), load)


def write_loadable(path: Path, text: str, load_file: Callable[[Path], Loaded]) -> Loaded:
    """Write a description and return it as loaded again; a text that does not load replaces nothing.

    Args:
        path: path of the file.
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


def set_nested_value(plain: dict[str, Any], base: dict[str, Any], path: str, value: Any) -> str:
    """Set a value in nested tables; the other items of a list are copied from `base` if `plain` has none.

    Args:
        plain: nested tables, changed in place.
        base: tables that `plain` extends.
        path: dotted path of the value, an item of a list by its number.
        value: the value.

    Returns:
        The path, without the number of an item.
    """
    *parts, last = path.split(".")
    if last.isdigit():
        items = nested_value(plain, parts) or nested_value(base, parts)
        value = [value if i == int(last) else item for i, item in enumerate(items)]
        *parts, last = parts
    table = plain
    for part in parts:
        table = table.setdefault(part, {})
    table[last] = value
    return ".".join([*parts, last])


def nested_value(table: Any, keys: list[str]) -> Any:
    """Return the value in nested tables and lists, or None."""
    for key in keys:
        table = table[int(key)] if isinstance(table, list) else table.get(key) if isinstance(table, dict) else None
    return table
