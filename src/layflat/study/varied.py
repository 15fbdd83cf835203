"""Axes of a study: one thing that varies, over the unit interval or on a grid, and machines that are compared."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from math import inf
from pathlib import Path
from typing import Any

import numpy as np

from layflat.arrays import Array
from layflat.description.change import changed_all, paths, value_at
from layflat.description.provenance import split
from layflat.description.tables import laid_over, leaves
from layflat.errors import InputError
from layflat.machine import Machine, load
from layflat.machine.exchanged import differing
from layflat.machine.loader import tables
from layflat.machine.model import build
from layflat.study.description import FACTOR, NUMBER, Kind, Range, StudyFile, VariantTable, kind, refuse


@dataclass(frozen=True)
class Variant:
    """A machine by its name in the table; the name is empty where a study has but one machine."""

    name: str
    machine: Machine


def variants(file: StudyFile, folder: Path, where: str) -> tuple[Variant, ...]:
    """Return the machines of a study; machine files are meant relative to `folder` (InputError: naming `where`)."""
    machine = load(_place(file.machine, folder))
    if not file.variant:
        return (Variant("", machine),)
    names = [table.name for table in file.variant]
    if len(set(names)) < len(names):
        raise InputError("two have the same name", where=f"{where}: variant.name", right="give each its own")
    made = tuple(
        Variant(table.name, _varied(table, file.machine, folder, f"{where}: variant.{i}"))
        for i, table in enumerate(file.variant)
    )
    for i, one in enumerate(made):
        if one.machine.arm.joints != made[0].machine.arm.joints:
            what = f"has the joints {', '.join(one.machine.arm.joints)}"
            right = f"all variants have the same: {', '.join(made[0].machine.arm.joints)}"
            raise InputError(what, where=f"{where}: variant.{i}", right=right)
    return made


def _place(machine: str, folder: Path) -> str:
    """A file is meant relative to the study's file."""
    return str(folder / machine) if machine.endswith(".toml") else machine


def _varied(table: VariantTable, usual: str, folder: Path, where: str) -> Machine:
    place = _place(table.machine or usual, folder)
    plain, sources = tables(place)
    over, own = split(table.set, f"{where}.set")
    machine = build(laid_over(plain, over), sources | own, f"{where}.set" if over else place)
    known, times = set(paths(machine)), dict[str, float]()
    for path, factor in leaves(table.times):
        key = f"{where}.times.{path}"
        if isinstance(factor, bool) or not isinstance(factor, (int, float)) or factor < 0:
            raise InputError(f"{factor!r} is not a factor", where=key, right="give a number such as 2.0")
        if path not in known:
            value_at(machine, path)
            raise InputError("is not a number", where=key, right="name a single number of the machine")
        times[path] = value_at(machine, path) * factor
    machine = changed_all(machine, times, f"{where}.times")
    return build(machine.model_dump(mode="json"), sources | own, f"{where}.times") if table.times else machine


EDGE = 1e-12  # a normal distribution is cut off where less than this share of it lies beyond

MEMBER = "member"  # in place of a path: a member of the machine's cloud, by its number

WHOLE = "is a whole number; give values, such as values = [10, 12]"


@dataclass(frozen=True)
class Varied:
    """An axis of a study, in SI units: among `values`, normally where there is a `deviation`, else evenly."""

    path: str
    kind: Kind  # of its values
    low: float = -inf  # a normal distribution may have no ends
    high: float = inf
    points: int | None = None  # on a grid
    log: bool = False  # whether it is the logarithm that is spread evenly
    values: tuple[float, ...] = ()  # to choose from
    mean: float = 0.0  # of a normal distribution, before it is cut off at `low` and `high`
    deviation: float = 0.0  # of a normal distribution
    also: tuple[str, ...] = ()  # paths that vary along with it
    relative: bool = False  # whether its values are factors on what the machine says
    group: str | None = None  # what it belongs to, where sensitivity is asked for
    # Of a number of a cloud's member: what each member sets, by path (SI).
    members: Mapping[str, Array] = field(default_factory=dict, compare=False)

    @property
    def paths(self) -> tuple[str, ...]:
        """Everything that it changes."""
        return tuple(self.members) or (self.path, *self.also)

    def at(self, share: Array) -> Array:
        """Return the values that lie at shares, 0 to 1, of the distribution."""
        if self.values:
            count = len(self.values)
            chosen: Array = np.array(self.values)[np.minimum((share * count).astype(int), count - 1)]
            return chosen
        if self.deviation:
            from scipy.special import ndtr, ndtri  # noqa: PLC0415  # not needed by most studies

            below, above = (float(ndtr((end - self.mean) / self.deviation)) for end in (self.low, self.high))
            inside = np.clip(below + share * (above - below), EDGE, 1.0 - EDGE)
            values = self.mean + self.deviation * ndtri(inside)
        elif self.log:
            values = self.low * (self.high / self.low) ** share
        else:
            values = self.low + share * (self.high - self.low)
        return np.clip(values, self.low, self.high)

    @property
    def count(self) -> int:
        """Number of its values on a grid."""
        return len(self.values) or self.points or 0

    def grid(self) -> Array:
        """Return its values on a grid."""
        return np.array(self.values) if self.values else self.at(np.linspace(0.0, 1.0, self.points or 0))

    def thinned(self, points: int) -> "Varied":
        """Return the same with at most so many points on a grid, spread over all of it."""
        if self.values:
            kept = np.unique(np.linspace(0, len(self.values) - 1, min(points, len(self.values))).astype(int))
            return replace(self, values=tuple(self.values[i] for i in kept))
        return replace(self, points=min(points, self.points or points))

    def canonical(self) -> dict[str, Any]:
        """Return how it varies, as it could stand in the file, in SI units."""
        noted = {"also": list(self.also), "relative": self.relative, "group": self.group, "points": self.points}
        linked = {key: value for key, value in noted.items() if value}
        if self.members:
            linked["members"] = {path: numbers.tolist() for path, numbers in self.members.items()}
        if self.values:
            return {"values": [self.kind.written(value) for value in self.values], **linked}
        numbers = {key: value for key, value in (("low", self.low), ("high", self.high)) if abs(value) < inf}
        numbers |= {"mean": self.mean, "deviation": self.deviation} if self.deviation else {}
        scale = {} if self.deviation else {"scale": "log" if self.log else "linear"}
        return {key: self.kind.written(value) for key, value in numbers.items()} | scale | linked


def applied(varied: Sequence[Varied], drawn: Mapping[str, Array], machine: Machine) -> dict[str, Array]:
    """Return what to set on a machine, by path (SI), from samples of what varies."""
    found = {}
    for one in varied:
        for path in one.paths:
            own = one.members[path][drawn[one.path].astype(int)] if one.members else drawn[one.path]
            found[path] = own * value_at(machine, path) if one.relative else own
    return found


def groups(varied: Sequence[Varied]) -> dict[str, list[int]]:
    """Return the numbers of the things in each group, by its name in alphabetical order."""
    names = sorted({one.group for one in varied if one.group is not None})
    return {name: [i for i, one in enumerate(varied) if one.group == name] for name in names}


def resolved(path: str, given: Range, machine: Machine, sampling: str, where: str) -> Varied:
    """Return what a file says of a path and of those that vary along, in SI units (InputError: naming `where`)."""
    if path == MEMBER:
        return _of_cloud(given, machine, where)
    own = kind(machine, path, where)
    others = [kind(machine, other, f"{where}.also.{i}") for i, other in enumerate(given.also)]
    setting = next((name for name in (path, *given.also) if name.startswith("scenario.")), "")
    odd = next((name for name, other in zip(given.also, others, strict=True) if other.unit != own.unit), "")
    whole, relative = any(other.whole for other in (own, *others)), given.relative
    refuse(
        where,
        (
            given.group is not None and sampling != "saltelli",
            ".group",
            'has no effect; use sampling = "saltelli", or leave it out',
        ),
        (relative and setting != "", ".relative", f"{setting} is not a number of the machine; leave it out"),
        (relative and whole, ".relative", WHOLE),
        (not relative and odd != "", ".also", f"{odd!r} is of another kind; vary it by itself, or add relative = true"),
    )
    if given.relative:
        own = FACTOR
    values = _spread(given, own, sampling, where) if given.values is None else {"values": _values(given, own, where)}
    return Varied(path, own, also=given.also, relative=given.relative, group=given.group, **values)


def _of_cloud(given: Range, machine: Machine, where: str) -> Varied:
    """Return members of the machine's cloud: those whose numbers are given, or all."""
    members = differing(machine.origin)
    count = len(next(iter(members.values())))
    odd = sorted(given.model_fields_set - {"values", "group"})
    numbers = list(range(count)) if given.values is None else given.values
    wrong = next((one for one in numbers if not (isinstance(one, int) and 0 <= one < count)), None)
    refuse(
        where,
        (bool(odd), "." + "".join(odd[:1]), "does not fit members; give values, or nothing for all of them"),
        (wrong is not None, ".values", f"{wrong!r} is no member; give numbers from 0 to {count - 1}"),
        (not numbers, ".values", "is empty; give one or more, or leave it out for all"),
    )
    return Varied(MEMBER, NUMBER, values=tuple(map(float, numbers)), group=given.group, members=members)


def _spread(given: Range, kind: Kind, sampling: str, where: str) -> dict[str, Any]:
    """Return the ends or the mean of what varies, by the names of `Varied`."""
    normal, grid, log = given.mean is not None or given.deviation is not None, sampling == "grid", given.scale == "log"
    needed = ("mean", "deviation") if normal else ("low", "high")
    missing = next((key for key in needed if getattr(given, key) is None), "")
    both = "mean and deviation" if normal else "low and high, mean and deviation, or values"
    refuse(
        where,
        (missing != "", f".{missing}", f"is missing; give {both}"),
        (kind.whole, "", WHOLE),
        (normal and grid, ".mean", 'does not fit a grid; use sampling = "sobol" or "lhs"'),
        (normal and log, ".scale", "does not fit a mean; give low and high, or leave it out"),
        (grid and given.points is None, ".points", "is missing; say how many points the grid has, such as 8"),
    )
    written = {key: getattr(given, key) for key in ("low", "high", "mean")}
    found: dict[str, Any] = {key: kind.parse(v, f"{where}.{key}") for key, v in written.items() if v is not None}
    low, high = found.get("low", -inf), found.get("high", inf)
    inside = not normal or low < found["mean"] < high
    refuse(
        where,
        (low >= high, ".low", f"{given.low!r} is not below high, {given.high!r}; give less"),
        (not inside, ".mean", f"{given.mean!r} is not between low and high; give one that is"),
        (log and low <= 0.0, ".low", f'{given.low!r} has no logarithm; give more than zero, or scale = "linear"'),
    )
    if normal:
        return found | {"deviation": kind.difference(given.deviation, f"{where}.deviation")}
    return found | {"points": given.points, "log": log}


def _values(given: Range, kind: Kind, where: str) -> tuple[float, ...]:
    written = given.values or []
    beside = sorted(given.model_fields_set - {"values", "also", "relative", "group"})
    values = tuple(kind.parse(value, f"{where}.values.{i}") for i, value in enumerate(written))
    twice = [one for i, one in enumerate(written) if values[i] in values[:i]]
    refuse(
        where,
        (bool(beside), "." + "".join(beside[:1]), "stands beside values; give one or the other"),
        (not values, ".values", "is empty; give one value or more"),
        (bool(twice), ".values", f"{''.join(map(repr, twice[:1]))} is there twice; give it once"),
    )
    return values
