"""Put calibrated values into the text of a built-in description, leaving all else as it stands."""

from __future__ import annotations

import json
import re
from importlib.resources import as_file

from layflat.files import whole_file
from layflat.machine.loader import BUILT_IN


def write_values(name: str, values: dict[str, object]) -> None:
    """Replace values by dotted path in a built-in description; an item of a list by its index.

    Raises:
        KeyError: the description itself has no such line, or does not mark it as calibrated.
    """
    with as_file(BUILT_IN / f"{name}.toml") as path:
        text = path.read_text(encoding="utf-8")
        for key, value in values.items():
            text = replaced(text, key, value)
        with whole_file(path) as temporary:
            temporary.write_text(text, encoding="utf-8")


def replaced(text: str, path: str, value: object) -> str:
    """The text of a description with one value replaced."""
    *table, key = path.split(".")
    index = int(key) if key.isdigit() else None
    if index is not None:
        *table, key = table
    header = f"[{'.'.join(table)}]"
    start = text.find(header + "\n")
    if start < 0:
        raise KeyError(path)
    end = text.find("\n[", start + 1)
    section = text[start : end if end >= 0 else len(text)]
    line = re.search(rf'^{re.escape(key)} = \{{ value = (.+?), source = "calibrated"', section, flags=re.MULTILINE)
    if line is None:
        raise KeyError(path)
    if index is not None:
        items = json.loads(line.group(1))
        items[index] = value
        value = items
    begin, stop = start + line.start(1), start + line.end(1)
    return text[:begin] + json.dumps(value) + text[stop:]
