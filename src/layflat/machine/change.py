"""Variants of a machine, for experiments."""

from __future__ import annotations

from difflib import get_close_matches
from typing import Any

from layflat.errors import InputError
from layflat.machine.model import Machine


def changed(machine: Machine, path: str, value: Any) -> Machine:
    """A copy of a machine with one value (SI) replaced, by its dotted path, such as "joint.small.brake.torque".

    The value is taken as it is: a description file is the place where values are checked.

    Raises:
        InputError: there is no such path.
    """

    def replaced(part: Any, keys: list[str]) -> Any:
        head, rest = keys[0], keys[1:]
        if isinstance(part, tuple) and head.isdigit() and int(head) < len(part):
            return tuple(replaced_item(item, rest) if i == int(head) else item for i, item in enumerate(part))
        if isinstance(part, dict) and head in part:
            return {**part, head: replaced_item(part[head], rest)}
        if head in getattr(type(part), "model_fields", {}):
            return part.model_copy(update={head: replaced_item(getattr(part, head), rest)})
        near = get_close_matches(path, paths(machine), n=1, cutoff=0.5)
        right = f"nearest is {near[0]!r}; `layflat show` lists the paths" if near else "`layflat show` lists the paths"
        raise InputError(f"{head!r} is not there", where=f"{machine.origin}: {path}", right=right)

    def replaced_item(item: Any, keys: list[str]) -> Any:
        return replaced(item, keys) if keys else value

    return replaced(machine, path.split("."))  # type: ignore[no-any-return]


def value_at(machine: Machine, path: str) -> Any:
    """What stands at a dotted path of a machine (SI)."""
    part: Any = machine
    for key in path.split("."):
        if isinstance(part, dict):
            part = part[key]
        else:
            part = part[int(key)] if isinstance(part, tuple) else getattr(part, key)
    return part


def paths(machine: Machine) -> list[str]:
    """Every number of a machine, by its dotted path."""

    def below(part: Any, path: str) -> list[str]:
        if isinstance(part, (int, float)) and not isinstance(part, bool):
            return [path]
        items: list[tuple[str, Any]]
        if isinstance(part, dict):
            items = list(part.items())
        elif isinstance(part, tuple):
            items = [(str(i), item) for i, item in enumerate(part)]
        else:
            items = [(name, getattr(part, name)) for name in getattr(type(part), "model_fields", {})]
        return [leaf for name, item in items for leaf in below(item, f"{path}.{name}" if path else name)]

    return below(machine, "")
