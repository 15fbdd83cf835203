"""Writing of a cloud's file: its members by their values in descriptions."""

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from layflat._version import __version__
from layflat.arrays import Array
from layflat.files import write_text
from layflat.machine.loader import MACHINE_LIBRARY
from research.cloud.open import NAMES, texts


def write(path: Path, members: Sequence[Array], command: str, **notes: float) -> None:
    """Write the file of a cloud.

    Args:
        path: of the file.
        members: shares of each member, (unknowns,).
        command: that reproduces the file.
        **notes: further numbers in the file.
    """
    said = [_numbers(texts(one)) for one in members]
    table = _grouped(said)
    raw = {
        "layflat": __version__,
        "command": command,
        "notes": notes,
        "columns": [
            {"machine": of, "paths": paths, **({"unit": unit} if unit else {})} for of, paths, unit, _ in table
        ],
        "bases": {name: MACHINE_LIBRARY.layers(name)[-1].plain for name in NAMES},
        "members": [list(one) for one in zip(*(numbers for *_, numbers in table), strict=True)],
    }
    # One line for each member, so that a change of one is a change of one line.
    head, name, rows = json.dumps(raw).rpartition('"members": ')
    write_text(path, head + name + rows.replace("], [", "],\n[") + "\n")


Numbers = dict[tuple[str, str], tuple[float, str]]
"""Number and unit by machine and path; items of lists by their number."""


def _numbers(said: Mapping[str, Mapping[str, Any]]) -> Numbers:
    found: Numbers = {}
    for name, values in said.items():
        for path, value in values.items():
            items = (
                [(f"{path}.{i}", one) for i, one in enumerate(value)] if isinstance(value, list) else [(path, value)]
            )
            for at, one in items:
                number, _, unit = one.partition(" ") if isinstance(one, str) else (one, "", "")
                found[name, at] = float(number), unit
    return found


def _grouped(said: Sequence[Numbers]) -> list[tuple[str, list[str], str, list[float]]]:
    """Return columns: machine, paths with equal values in every member, unit and numbers."""
    found: dict[tuple[Any, ...], tuple[str, list[str], str, list[float]]] = {}
    for name, path in said[0]:
        numbers, unit = [one[name, path][0] for one in said], said[0][name, path][1]
        found.setdefault((name, unit, *numbers), (name, [], unit, numbers))[1].append(path)
    return list(found.values())
