"""Nested tables: parsed from TOML, overlaid, and split into values and the sources of these.

In a file a value stands alone, or in a table with its source:

    width = "160 mm"
    width = { value = "160 mm", source = "paper", note = "section 2.3" }
"""

import re
import tomllib
from collections.abc import Iterator
from copy import deepcopy
from dataclasses import dataclass
from functools import lru_cache
from math import inf
from typing import Any

from layflat.description.wrong import shown
from layflat.errors import InputError

Plain = dict[str, Any]

MAX_DEPTH = 20  # tables within tables; a machine has four


MAX_BARE_NUMBER = (
    1e15  # of a number without unit, infinity and what is not a number aside, which are refused where they stand
)

TOO_DEEP = "is nested too deeply", f"use at most {MAX_DEPTH} levels"


def parse_toml(text: str, where: str, example: str) -> Plain:
    """Return the tables of a TOML text.

    Args:
        text: TOML.
        where: its name in messages.
        example: line of such a file, for messages.

    Raises:
        InputError: it is not TOML, nested too deeply, or has a number beyond `MAX_BARE_NUMBER` or that can't exist.
    """
    try:
        plain = deepcopy(_loaded(text))
    except tomllib.TOMLDecodeError as error:
        what, right = _explain_toml_error(str(error), text)
        raise InputError(what, where=where, right=right or f"values look like {example}") from None
    except ValueError:  # a whole number of thousands of digits, or a date that is none
        right = "numbers have up to 15 digits, dates are such as 2026-01-31"
        raise InputError("has a number or a date that is not valid", where=where, right=right) from None
    except RecursionError:
        raise InputError(TOO_DEEP[0], where=where, right=TOO_DEEP[1]) from None
    if _is_too_deep(plain):
        raise InputError(TOO_DEEP[0], where=where, right=TOO_DEEP[1])
    for path, value in leaves(plain):
        if isinstance(value, (int, float)) and MAX_BARE_NUMBER < abs(value) < inf:
            raise InputError(f"{shown(value)} is out of range", where=f"{where}: {path}", right="give at most 1e15")
    return plain


@lru_cache(maxsize=8)
def _loaded(text: str) -> Plain:
    """Return the tables of a text, the cached object itself: a command often loads a file several times."""
    return tomllib.loads(text)


def _explain_toml_error(message: str, text: str) -> tuple[str, str]:
    """Return the problem of a text that is not TOML, with the line as written, and the advice."""
    match = re.search(r"\(at line (\d+), column \d+\)", message)
    lines = text.splitlines()
    number = int(match[1]) if match else len(lines)
    line = lines[number - 1].strip()[:60] if 0 < number <= len(lines) else ""
    problem = re.sub(r"\s*\(at .*\)$", "", message)
    if problem.startswith(("Cannot overwrite a value", "Cannot declare", "Cannot mutate", "Cannot redefine")):
        key = line.partition("=")[0].strip() or line
        if problem.startswith("Cannot overwrite"):  # the parser is behind the value, mostly in the next line
            key = _repeated_key(lines, number) or key
        return f"has {key} twice (line {number})", "keep one"
    at = f" at line {number}: {line!r}" if line else ""
    return f"is not TOML: {problem[:1].lower()}{problem[1:]}{at}", ""


def _repeated_key(lines: list[str], number: int) -> str:
    """Return the first key that appears twice in its table within the first lines; empty if there is none."""
    seen: set[str] = set()
    for line in lines[:number]:
        if line.lstrip().startswith("["):
            seen.clear()
        key = line.partition("=")[0].strip() if "=" in line else ""
        if key and key in seen:
            return key
        seen.add(key)
    return ""


def _is_too_deep(plain: Plain) -> bool:
    """Return whether tables and lists are nested deeper than `MAX_DEPTH`."""
    level: list[Any] = [plain]
    for _ in range(MAX_DEPTH + 1):
        level = [
            item
            for container in level
            for item in (container.values() if isinstance(container, dict) else container)
            if isinstance(item, (dict, list))
        ]
        if not level:
            return False
    return True


def overlay(under: Plain, over: Plain) -> Plain:
    """Return tables `under` merged with `over`, whose values replace those at the same paths."""
    merged = dict(under)
    for key, value in over.items():
        below = merged.get(key)
        merged[key] = overlay(below, value) if isinstance(below, dict) and isinstance(value, dict) else value
    return merged


def leaves(table: Plain, prefix: str = "") -> Iterator[tuple[str, Any]]:
    """Yield dotted path and value of every leaf: a value that is no table, a list as a whole."""
    for key, value in table.items():
        path = f"{prefix}.{key}" if prefix else key
        if isinstance(value, dict):
            yield from leaves(value, path)
        else:
            yield path, value


SOURCE_NAMES = ("paper", "derived", "assumed", "calibrated", "identified", "given")


@dataclass(frozen=True)
class Provenance:
    """Source of a value, one of `SOURCE_NAMES`, with a note."""

    source: str = "given"
    note: str = ""


Sources = dict[str, Provenance]


def split_provenance(table: dict[str, Any], where: str, path: str = "") -> tuple[dict[str, Any], dict[str, Provenance]]:
    """Split a raw description into plain values and the provenance of each, by its dotted path ("given" by default).

    Args:
        table: raw tables, in which a value may be a table with `value`, `source` and `note`.
        where: name of the description in messages.
        path: dotted path of the table.

    Raises:
        InputError: a source is none of `SOURCE_NAMES`, or a value's table has an unknown key.
    """
    plain: dict[str, Any] = {}
    sources: dict[str, Provenance] = {}
    for key, value in table.items():
        here = f"{path}.{key}" if path else key
        if isinstance(value, dict) and "value" in value:
            plain[key] = value["value"]
            sources[here] = _read_provenance(value, where, here)
        elif isinstance(value, dict):
            plain[key], below = split_provenance(value, where, here)
            sources |= below
        else:
            plain[key] = value
            sources[here] = Provenance()
    return plain, sources


def _read_provenance(entry: dict[str, Any], where: str, path: str) -> Provenance:
    """Return the source of an entry with a value; raise InputError for unknown keys or sources."""
    unknown = sorted(set(entry) - {"value", "source", "note"})
    if unknown:
        raise InputError(
            f"unknown key {unknown[0]!r} beside a value", where=f"{where}: {path}", right="use value, source and note"
        )
    source = entry.get("source", "given")
    if source not in SOURCE_NAMES:
        raise InputError(
            f"source {source!r} is unknown", where=f"{where}: {path}", right=f"use one of {', '.join(SOURCE_NAMES)}"
        )
    return Provenance(source, str(entry.get("note", "")))
