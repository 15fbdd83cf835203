"""Variants of a machine, for experiments."""

from __future__ import annotations

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
        raise InputError(
            f"{head!r} is not there", where=f"{machine.origin}: {path}", right="`layflat show` lists the paths"
        )

    def replaced_item(item: Any, keys: list[str]) -> Any:
        return replaced(item, keys) if keys else value

    return replaced(machine, path.split("."))  # type: ignore[no-any-return]
