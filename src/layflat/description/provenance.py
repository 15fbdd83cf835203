"""Where each value of a description comes from.

In a file a value stands alone, or in a table that says where it comes from:

    width = "160 mm"
    width = { value = "160 mm", source = "paper", note = "section 2.3" }
"""

from dataclasses import dataclass
from typing import Any

from layflat.errors import InputError

SOURCES = ("paper", "derived", "assumed", "calibrated", "identified", "given")


@dataclass(frozen=True)
class Provenance:
    """Source of a value, one of `SOURCES`, and how it was had from there."""

    source: str = "given"
    note: str = ""


Sources = dict[str, Provenance]


def split(table: dict[str, Any], where: str, path: str = "") -> tuple[dict[str, Any], dict[str, Provenance]]:
    """Part a raw description into plain values and the provenance of each, keyed by its dotted path.

    Raises:
        InputError: a source that is none of `SOURCES`.
    """
    plain: dict[str, Any] = {}
    sources: dict[str, Provenance] = {}
    for key, value in table.items():
        here = f"{path}.{key}" if path else key
        if isinstance(value, dict) and "value" in value:
            plain[key] = value["value"]
            sources[here] = _provenance(value, where, here)
        elif isinstance(value, dict):
            plain[key], below = split(value, where, here)
            sources |= below
        else:
            plain[key] = value
            sources[here] = Provenance()
    return plain, sources


def _provenance(entry: dict[str, Any], where: str, path: str) -> Provenance:
    unknown = sorted(set(entry) - {"value", "source", "note"})
    if unknown:
        raise InputError(
            f"unknown key {unknown[0]!r} beside a value", where=f"{where}: {path}", right="use value, source and note"
        )
    source = entry.get("source", "given")
    if source not in SOURCES:
        raise InputError(
            f"source {source!r} is unknown", where=f"{where}: {path}", right=f"use one of {', '.join(SOURCES)}"
        )
    return Provenance(source, str(entry.get("note", "")))
