"""Keys that cell files had in earlier versions: they still load."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

TABLES = {"pack": "container"}
KEYS = {"turn": "rotation"}


def rename_keys(plain: dict[str, Any]) -> None:
    """Give the tables and keys of a description as it is written, and those that it omits, their present names."""
    _rename(plain, TABLES)
    if isinstance(plain.get("omits"), list):
        plain["omits"] = [_renamed_path(path) for path in plain["omits"]]
    for part in _rotated(plain):
        if isinstance(part, dict):
            _rename(part, KEYS)


def _renamed_path(path: Any) -> Any:
    """Return a dotted path of a description with present names; what is no path as it is."""
    if not isinstance(path, str):
        return path
    first, *others = path.split(".")
    if others:
        others[-1] = KEYS.get(others[-1], others[-1])
    return ".".join([TABLES.get(first, first), *others])


def _rename(table: dict[str, Any], names: dict[str, str]) -> None:
    for former, name in names.items():
        if former in table and name not in table:
            table[name] = table.pop(former)


def _rotated(plain: dict[str, Any]) -> Iterator[Any]:
    """Yield the tables that have an angle of rotation."""
    yield plain.get("camera")
    base = plain.get("base_markers")
    groups = [plain.get("tray"), plain.get("container"), base.get("marker") if isinstance(base, dict) else None]
    for group in groups:
        if isinstance(group, dict):
            yield from group.values()
