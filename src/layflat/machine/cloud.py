"""Clouds: in place of one machine, the many that agree with all that is known of it.

A cloud is a file of values that take the place of those of built-in machines. Member 17 of the paper's machines is
named `paper-arm@17`: the same description, with its values laid over it.
"""

import json
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

from layflat._version import __version__
from layflat.description.library import Layer
from layflat.description.provenance import Provenance
from layflat.description.tables import Plain, leaves
from layflat.description.text import read_text
from layflat.errors import MachineError

PAPER = Path(__file__).parent / "builtin" / "paper.cloud.json"
"""The cloud of the paper's machines; `python -m research.cloud` makes it."""

KEYS = ("layflat", "command", "columns", "bases", "members")


@dataclass(frozen=True)
class Column:
    """A value that differs from member to member."""

    machine: str  # over whose description it is laid
    paths: tuple[str, ...]  # dotted, an item of a list by its number
    unit: str = ""  # none of a plain number


@dataclass(frozen=True)
class Cloud:
    """Machines that agree with all that is known of one, as a file keeps them."""

    where: str
    command: str  # that makes the file
    columns: tuple[Column, ...]
    bases: Mapping[str, Plain]  # what the machines said when the cloud was made
    members: tuple[tuple[float, ...], ...]  # numbers by column, an item a member

    def layer(self, number: int, base: Layer, plain: Plain) -> Layer | None:
        """Return what a member lays over a description, None where it has nothing to say of it.

        Args:
            number: of the member.
            base: the description's own layer.
            plain: its values, with those that it extends.

        Raises:
            MachineError: there is no such member, or the description has changed since the cloud was made.
        """
        if not 0 <= number < len(self.members):
            right = f"give a number from 0 to {len(self.members) - 1}"
            raise MachineError(f"has no member {number}", where=self.where, right=right)
        if base.where not in self.bases:
            return None
        self._check(base)
        over: Plain = {}
        for column, value in zip(self.columns, self.members[number], strict=True):
            for path in column.paths if column.machine == base.where else ():
                _put(over, plain, path, f"{value:g} {column.unit}" if column.unit else value)
        note = Provenance("calibrated", f"member {number} of {Path(self.where).name}")
        return Layer(f"{base.where}@{number}", over, {path: note for path, _ in leaves(over)})

    def _check(self, base: Layer) -> None:
        """Refuse a description that says something else than when the cloud was made, but for what members replace."""
        then, now = dict(leaves(self.bases[base.where])), dict(leaves(base.plain))
        replaced = {path for one in self.columns if one.machine == base.where for path in map(_whole, one.paths)}
        for path in sorted(then.keys() | now.keys()):
            if then.get(path) != now.get(path) and path not in replaced:
                was, has = (f"{one[path]!r}" if path in one else "nothing" for one in (then, now))
                raise MachineError(
                    f"was made for {base.where} with {was}, which has {has} now",
                    where=f"{self.where}: {path}",
                    right=f"make it anew in a clone of layflat: {self.command}",
                )


def parted(where: str) -> tuple[str, Path, int] | None:
    """Part the name of a member, `NAME@17` or `NAME@FILE:17`, into machine, file and number; None: it is none."""
    name, at, member = where.rpartition("@")
    file, _, number = member.rpartition(":")
    if not (name and at and number.isascii() and number.isdigit()):
        return None
    return name, Path(file) if file else PAPER, int(number)


def cloud(path: Path = PAPER) -> Cloud:
    """Return the cloud that a file keeps.

    Raises:
        MachineError: it can't be read, is none, or is of another version.
    """
    return _parsed(read_text(path, str(path), "give a cloud's file, or none for the paper's", MachineError), str(path))


@lru_cache(maxsize=4)
def _parsed(text: str, where: str) -> Cloud:
    try:
        raw = json.loads(text)
        if lacking := [key for key in KEYS if key not in raw]:
            raise MachineError(f"has no {lacking[0]!r}", where=where, right="give a cloud's file")
        if raw["layflat"] != __version__:
            what = f"was made with layflat {raw['layflat']}, this is {__version__}"
            raise MachineError(what, where=where, right=f"make it anew in a clone of layflat: {raw['command']}")
        columns = tuple(Column(one["machine"], tuple(one["paths"]), one.get("unit", "")) for one in raw["columns"])
        members = tuple(tuple(float(value) for value in one) for one in raw["members"])
    except (ValueError, TypeError, KeyError, RecursionError):
        raise MachineError("is no cloud of machines", where=where, right="give a cloud's file") from None
    for i, one in enumerate(members):
        if len(one) != len(columns):
            what = f"member {i} has {len(one)} values for {len(columns)} columns"
            raise MachineError(what, where=where, right=f"make it anew in a clone of layflat: {raw['command']}")
    return Cloud(where, raw["command"], columns, raw["bases"], members)


def _put(over: Plain, plain: Plain, path: str, value: Any) -> None:
    """Put a value at a path; of a list the items beside it stay as they are."""
    *parts, key = path.split(".")
    below: Any = plain
    for part in parts:
        below = below[part]
        if isinstance(below, list):
            items = over.setdefault(part, list(below))
            items[int(key)] = value
            return
        over = over.setdefault(part, {})
    over[key] = value


def _whole(path: str) -> str:
    """The path of what is written as one: a list, for its items."""
    head, _, last = path.rpartition(".")
    return head if last.isdigit() else path
