"""A description as people read it: line by line with its sources, as TOML to start from, as JSON Schema."""

import json
from dataclasses import dataclass
from typing import Any

from layflat.description.provenance import SOURCES, Provenance, Sources
from layflat.description.tables import Plain, leaves
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
