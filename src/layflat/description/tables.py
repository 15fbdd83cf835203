"""Nested tables: from TOML, laid over each other, and back to text."""

import re
import tomllib
from collections.abc import Iterator
from copy import deepcopy
from functools import lru_cache
from math import inf
from typing import Any

from layflat.description.wrong import shown
from layflat.errors import InputError

Plain = dict[str, Any]

DEEPEST = 20  # tables within tables; a machine has four


GREATEST = 1e15  # of a number without unit, infinity and what is not a number aside, which are refused where they stand

TOO_DEEP = "is nested too deeply", f"use at most {DEEPEST} levels"


def parsed(text: str, where: str, example: str) -> Plain:
    """Return the tables of a TOML text; `example` shows what values look like.

    Raises:
        InputError: it is not TOML, or nested too deeply.
    """
    try:
        plain = deepcopy(_loaded(text))
    except tomllib.TOMLDecodeError as error:
        what, right = _explained(str(error), text)
        raise InputError(what, where=where, right=right or f"values look like {example}") from None
    except ValueError:  # a whole number of thousands of digits, or a date that is none
        right = "numbers have up to 15 digits, dates are such as 2026-01-31"
        raise InputError("holds a number or a date that can't be", where=where, right=right) from None
    except RecursionError:
        raise InputError(TOO_DEEP[0], where=where, right=TOO_DEEP[1]) from None
    if _too_deep(plain):
        raise InputError(TOO_DEEP[0], where=where, right=TOO_DEEP[1])
    for path, value in leaves(plain):
        if isinstance(value, (int, float)) and GREATEST < abs(value) < inf:
            raise InputError(f"{shown(value)} is out of range", where=f"{where}: {path}", right="give at most 1e15")
    return plain


@lru_cache(maxsize=8)
def _loaded(text: str) -> Plain:
    """Tables of a text: a command often asks for those of one file several times, and for those that it extends."""
    return tomllib.loads(text)


def _explained(message: str, text: str) -> tuple[str, str]:
    """Return the error of a text that is not TOML: its line as written, and what would be right."""
    found = re.search(r"\(at line (\d+), column \d+\)", message)
    lines = text.splitlines()
    number = int(found[1]) if found else len(lines)
    line = lines[number - 1].strip()[:60] if 0 < number <= len(lines) else ""
    problem = re.sub(r"\s*\(at .*\)$", "", message)
    if problem.startswith(("Cannot overwrite a value", "Cannot declare", "Cannot mutate", "Cannot redefine")):
        key = line.partition("=")[0].strip() or line
        if problem.startswith("Cannot overwrite"):  # the reader has gone past the value, mostly to the next line
            key = _repeated(lines, number) or key
        return f"has {key} twice (line {number})", "keep one"
    at = f" at line {number}: {line!r}" if line else ""
    return f"is not TOML: {problem[:1].lower()}{problem[1:]}{at}", ""


def _repeated(lines: list[str], number: int) -> str:
    """The first key that stands twice in its table, at the latest in some line."""
    seen: set[str] = set()
    for line in lines[:number]:
        if line.lstrip().startswith("["):
            seen.clear()
        key = line.partition("=")[0].strip() if "=" in line else ""
        if key and key in seen:
            return key
        seen.add(key)
    return ""


def _too_deep(plain: Plain) -> bool:
    level: list[Any] = [plain]
    for _ in range(DEEPEST + 1):
        level = [
            item
            for one in level
            for item in (one.values() if isinstance(one, dict) else one)
            if isinstance(item, (dict, list))
        ]
        if not level:
            return False
    return True


def laid_over(under: Plain, over: Plain) -> Plain:
    """Return tables with what differs in others put in its place."""
    merged = dict(under)
    for key, value in over.items():
        below = merged.get(key)
        merged[key] = laid_over(below, value) if isinstance(below, dict) and isinstance(value, dict) else value
    return merged


def leaves(table: Plain, prefix: str = "") -> Iterator[tuple[str, Any]]:
    """Yield dotted path and value of everything in nested tables."""
    for key, value in table.items():
        path = f"{prefix}.{key}" if prefix else key
        if isinstance(value, dict):
            yield from leaves(value, path)
        else:
            yield path, value
