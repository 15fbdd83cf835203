"""Clouds: ensembles of plausible parameter sets of a machine, all consistent with what is known of it.

A cloud is a file of values that replace those of built-in machines. Member 17 of the paper's machines is named
`paper-arm@17`: the same description, overlaid by the member's values.
"""

import json
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

from layflat._version import __version__
from layflat.description.library import Layer
from layflat.description.renamed import with_present_keys
from layflat.description.tables import Plain, Provenance, leaves
from layflat.description.text import read_text
from layflat.errors import MachineError

PAPER_CLOUD = Path(__file__).parent / "builtin" / "paper.cloud.json"
"""Cloud of the paper's machines, written by `python -m research.cloud`."""

REQUIRED_KEYS = ("layflat", "command", "columns", "bases", "members")


@dataclass(frozen=True)
class CloudColumn:
    """Value that differs from member to member."""

    machine: str  # whose description it overlays
    paths: tuple[str, ...]  # dotted paths of the value, items of lists by their numbers
    unit: str = ""  # empty for a plain number


@dataclass(frozen=True)
class MachineCloud:
    """Plausible parameter sets of a machine, as a file stores them."""

    where: str  # the file, for messages
    command: str  # that writes the file
    columns: tuple[CloudColumn, ...]
    bases: Mapping[str, Plain]  # descriptions of the machines when the cloud was computed
    members: tuple[tuple[float, ...], ...]  # values by column, an item a member

    def layer(self, number: int, base: Layer, plain: Plain) -> Layer | None:
        """Return the layer of a member over a description; None if the cloud has no values of it.

        Args:
            number: index of the member.
            base: layer of the description.
            plain: values of the description, inherited ones included.

        Raises:
            MachineError: there is no such member, or the description has changed since the cloud was computed.
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
                _set_value(over, plain, path, f"{value:g} {column.unit}" if column.unit else value)
        note = Provenance("calibrated", f"member {number} of {Path(self.where).name}")
        return Layer(f"{base.where}@{number}", over, {path: note for path, _ in leaves(over)})

    def _check(self, base: Layer) -> None:
        """Raise MachineError if a value that members do not replace has changed since the cloud was computed."""
        then, now = dict(leaves(self.bases[base.where])), dict(leaves(base.plain))
        replaced = {
            path for column in self.columns if column.machine == base.where for path in map(_list_path, column.paths)
        }
        for path in sorted(then.keys() | now.keys()):
            if then.get(path) != now.get(path) and path not in replaced:
                was, has = (f"{one[path]!r}" if path in one else "nothing" for one in (then, now))
                raise MachineError(
                    f"was made for {base.where} with {was}, which has {has} now",
                    where=f"{self.where}: {path}",
                    right=f"make it anew in a clone of layflat: {self.command}",
                )


def split_member_name(where: str) -> tuple[str, Path, int] | None:
    """Return machine, file and index of a member's name, `NAME@17` or `NAME@FILE:17`; None for another name."""
    name, at, member = where.rpartition("@")
    file, _, number = member.rpartition(":")
    if not (name and at and number.isascii() and number.isdigit()):
        return None
    return name, Path(file) if file else PAPER_CLOUD, int(number)


def load_cloud(path: Path = PAPER_CLOUD) -> MachineCloud:
    """Return the cloud in a file.

    Raises:
        MachineError: the file can't be read, is no cloud, or is of another version.
    """
    return _parse_cloud(
        read_text(path, str(path), "give a cloud's file, or none for the paper's", MachineError), str(path)
    )


@lru_cache(maxsize=4)
def _parse_cloud(text: str, where: str) -> MachineCloud:
    """Return the cloud in a file's text; raise MachineError if it is none, or of another version of layflat."""
    try:
        raw, _ = with_present_keys("cloud", json.loads(text), certain=False)
        if lacking := [key for key in REQUIRED_KEYS if key not in raw]:
            raise MachineError(f"has no {lacking[0]!r}", where=where, right="give a cloud's file")
        if raw["layflat"] != __version__:
            what = f"was made with layflat {raw['layflat']}, this is {__version__}"
            raise MachineError(what, where=where, right=f"make it anew in a clone of layflat: {raw['command']}")
        columns = tuple(CloudColumn(one["machine"], tuple(one["paths"]), one.get("unit", "")) for one in raw["columns"])
        members = tuple(tuple(float(value) for value in one) for one in raw["members"])
    except (ValueError, TypeError, KeyError, RecursionError):
        raise MachineError("is no cloud of machines", where=where, right="give a cloud's file") from None
    for i, one in enumerate(members):
        if len(one) != len(columns):
            what = f"member {i} has {len(one)} values for {len(columns)} columns"
            raise MachineError(what, where=where, right=f"make it anew in a clone of layflat: {raw['command']}")
    return MachineCloud(where, raw["command"], columns, raw["bases"], members)


def _set_value(over: Plain, plain: Plain, path: str, value: Any) -> None:
    """Set a value at a path in `over`; the other items of a list are copied from `plain`."""
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


def _list_path(path: str) -> str:
    """Return the path of the list that a path is an item of; else the path itself."""
    head, _, last = path.rpartition(".")
    return head if last.isdigit() else path
