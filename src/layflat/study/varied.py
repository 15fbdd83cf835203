"""Axes of a study (varied values, over a distribution or on a grid), and the machines that it compares."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from math import inf
from pathlib import Path
from typing import Any

import numpy as np

from layflat.arrays import Array
from layflat.description.change import changed_all, paths, value_at
from layflat.description.tables import leaves, overlay, split_provenance
from layflat.errors import InputError
from layflat.machine import Machine, load
from layflat.machine.exchanged import member_values
from layflat.machine.loader import tables
from layflat.machine.model import build
from layflat.study.description import (
    FACTOR_QUANTITY,
    INDEX_QUANTITY,
    StudyFile,
    VariantTable,
    VariedQuantity,
    VaryTable,
    check_rules,
    varied_quantity,
)


@dataclass(frozen=True)
class Variant:
    """Machine of a study, with its name in the table; the name is empty for the only machine."""

    name: str
    machine: Machine


def load_variants(file: StudyFile, folder: Path, where: str) -> tuple[Variant, ...]:
    """Return the machines of a study.

    Args:
        file: file of the study.
        folder: folder to which paths of machine files are relative.
        where: the file, for messages.

    Raises:
        InputError: naming `where`: names or joints of the variants do not fit.
    """
    machine = load(_machine_path(file.machine, folder))
    if not file.variant:
        return (Variant("", machine),)
    names = [table.name for table in file.variant]
    if len(set(names)) < len(names):
        twice = next(name for name in names if names.count(name) > 1)
        what = f"{twice!r} is the name of two"
        raise InputError(what, where=f"{where}: variant.name", right="give each its own")
    compared = tuple(
        Variant(table.name, _build_variant(table, file.machine, folder, f"{where}: variant.{i}"))
        for i, table in enumerate(file.variant)
    )
    for i, one in enumerate(compared):
        if one.machine.arm.joints != compared[0].machine.arm.joints:
            what = f"has the joints {', '.join(one.machine.arm.joints)}"
            right = f"all variants have the same: {', '.join(compared[0].machine.arm.joints)}"
            raise InputError(what, where=f"{where}: variant.{i}", right=right)
    return compared


def _machine_path(machine: str, folder: Path) -> str:
    """Return the path of a machine file relative to the study's folder, or a built-in name as it is."""
    return str(folder / machine) if machine.endswith(".toml") else machine


def _build_variant(table: VariantTable, usual: str, folder: Path, where: str) -> Machine:
    """Return a machine of a study: its description overlaid by `set`, its numbers multiplied by `factors`.

    Raise InputError if a factor is not a number from 0 on, or its path is no number of the machine.
    """
    place = _machine_path(table.machine or usual, folder)
    plain, sources = tables(place)
    over, own = split_provenance(table.set, f"{where}.set")
    machine = build(overlay(plain, over), sources | own, f"{where}.set" if over else place)
    numbers, values = set(paths(machine)), dict[str, float]()
    for path, factor in leaves(table.factors):
        key = f"{where}.factors.{path}"
        if isinstance(factor, bool) or not isinstance(factor, (int, float)) or factor < 0:
            raise InputError(f"{factor!r} is not a factor", where=key, right="give a number such as 2.0")
        if path not in numbers:
            value_at(machine, path)
            raise InputError("is not a number", where=key, right="name a single number of the machine")
        values[path] = value_at(machine, path) * factor
    machine = changed_all(machine, values, f"{where}.factors")
    return build(machine.model_dump(mode="json"), sources | own, f"{where}.factors") if table.factors else machine


TAIL_PROBABILITY = 1e-12  # a normal distribution is cut off where less than this share of it lies beyond

MEMBER_PATH = "member"  # in place of a path: a member of the machine's cloud, by its number

WHOLE_NUMBER_TEXT = "is a whole number; give values, such as values = [10, 12]"


@dataclass(frozen=True)
class StudyAxis:
    """An axis of a study, in SI units: among `values`, normally where there is a `std`, else evenly."""

    path: str
    kind: VariedQuantity  # of its values
    low: float = -inf  # a normal distribution may have no ends
    high: float = inf
    points: int | None = None  # on a grid
    log: bool = False  # whether it is the logarithm that is spread evenly
    values: tuple[float, ...] = ()  # to choose from
    mean: float = 0.0  # of a normal distribution, before it is cut off at `low` and `high`
    std: float = 0.0  # of a normal distribution
    also: tuple[str, ...] = ()  # paths that vary along with it
    relative: bool = False  # whether its values are factors on what the machine says
    group: str | None = None  # what it belongs to, where sensitivity is asked for
    # Of a number of a cloud's member: what each member sets, by path (SI).
    members: Mapping[str, Array] = field(default_factory=dict, compare=False)

    @property
    def paths(self) -> tuple[str, ...]:
        """Paths of the numbers that it sets: those of a cloud's member, or its own and `also`."""
        return tuple(self.members) or (self.path, *self.also)

    def quantiles(self, levels: Array) -> Array:
        """Return the values at cumulative probabilities, 0 to 1, of the distribution; `values` are equally probable."""
        if self.values:
            count = len(self.values)
            chosen: Array = np.array(self.values)[np.minimum((levels * count).astype(int), count - 1)]
            return chosen
        if self.std:
            from scipy.special import ndtr, ndtri  # noqa: PLC0415  # not needed by most studies

            below, above = (float(ndtr((end - self.mean) / self.std)) for end in (self.low, self.high))
            inside = np.clip(below + levels * (above - below), TAIL_PROBABILITY, 1.0 - TAIL_PROBABILITY)
            values = self.mean + self.std * ndtri(inside)
        elif self.log:
            values = self.low * (self.high / self.low) ** levels
        else:
            values = self.low + levels * (self.high - self.low)
        return np.clip(values, self.low, self.high)

    @property
    def count(self) -> int:
        """Number of its values on a grid."""
        return len(self.values) or self.points or 0

    def grid(self) -> Array:
        """Return its values on a grid."""
        return np.array(self.values) if self.values else self.quantiles(np.linspace(0.0, 1.0, self.points or 0))

    def thinned(self, points: int) -> "StudyAxis":
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
            return {"values": [self.kind.format(value) for value in self.values], **linked}
        numbers = {key: value for key, value in (("low", self.low), ("high", self.high)) if abs(value) < inf}
        numbers |= {"mean": self.mean, "std": self.std} if self.std else {}
        scale = {} if self.std else {"scale": "log" if self.log else "linear"}
        return {key: self.kind.format(value) for key, value in numbers.items()} | scale | linked


def machine_values(varied: Sequence[StudyAxis], drawn: Mapping[str, Array], machine: Machine) -> dict[str, Array]:
    """Return the values to set on a machine, by path (SI).

    Args:
        varied: axes of the study.
        drawn: one value per sample, by the axis's path.
        machine: machine whose values relative axes scale.
    """
    values = {}
    for axis in varied:
        for path in axis.paths:
            samples = axis.members[path][drawn[axis.path].astype(int)] if axis.members else drawn[axis.path]
            values[path] = samples * value_at(machine, path) if axis.relative else samples
    return values


def group_axes(varied: Sequence[StudyAxis]) -> dict[str, list[int]]:
    """Return the indices of the axes in each group, by its name in alphabetical order."""
    names = sorted({axis.group for axis in varied if axis.group is not None})
    return {name: [i for i, axis in enumerate(varied) if axis.group == name] for name in names}


def resolve_axis(path: str, table: VaryTable, machine: Machine, sampling: str, where: str) -> StudyAxis:
    """Return the axis of a path, in SI units.

    Args:
        path: path that varies.
        table: its table in the file.
        machine: machine of the study.
        sampling: sampling of the study.
        where: the key, for messages.

    Raises:
        InputError: naming `where`: keys are missing or contradict each other.
    """
    if path == MEMBER_PATH:
        return _cloud_axis(table, machine, where)
    quantity = varied_quantity(machine, path, where)
    others = [varied_quantity(machine, other, f"{where}.also.{i}") for i, other in enumerate(table.also)]
    setting = next((name for name in (path, *table.also) if name.startswith("scenario.")), "")
    odd = next((name for name, other in zip(table.also, others, strict=True) if other.unit != quantity.unit), "")
    whole, relative = any(other.whole for other in (quantity, *others)), table.relative
    check_rules(
        where,
        (
            table.group is not None and sampling != "saltelli",
            ".group",
            'has no effect; use sampling = "saltelli", or leave it out',
        ),
        (relative and setting != "", ".relative", f"{setting} is not a number of the machine; leave it out"),
        (relative and whole, ".relative", WHOLE_NUMBER_TEXT),
        (not relative and odd != "", ".also", f"{odd!r} is of another kind; vary it by itself, or add relative = true"),
    )
    if table.relative:
        quantity = FACTOR_QUANTITY
    values = (
        _read_distribution(table, quantity, sampling, where)
        if table.values is None
        else {"values": _read_values(table, quantity, where)}
    )
    return StudyAxis(path, quantity, also=table.also, relative=table.relative, group=table.group, **values)


def _cloud_axis(table: VaryTable, machine: Machine, where: str) -> StudyAxis:
    """Return the axis of members of the machine's cloud: those whose indices are listed, or all.

    Raises:
        InputError: an index is not a member's, the list is empty, or another key than `group` stands beside it.
    """
    members = member_values(machine.origin)
    count = len(next(iter(members.values())))
    odd = sorted(table.model_fields_set - {"values", "group"})
    numbers = list(range(count)) if table.values is None else table.values
    wrong = next((one for one in numbers if not (isinstance(one, int) and 0 <= one < count)), None)
    check_rules(
        where,
        (bool(odd), "." + "".join(odd[:1]), "does not fit members; give values, or nothing for all of them"),
        (wrong is not None, ".values", f"{wrong!r} is no member; give numbers from 0 to {count - 1}"),
        (not numbers, ".values", "is empty; give one or more, or leave it out for all"),
    )
    return StudyAxis(MEMBER_PATH, INDEX_QUANTITY, values=tuple(map(float, numbers)), group=table.group, members=members)


def _read_distribution(table: VaryTable, kind: VariedQuantity, sampling: str, where: str) -> dict[str, Any]:
    """Return the parameters of a distribution, by the fields of `StudyAxis`; raise InputError for the first mistake."""
    normal, grid, log = table.mean is not None or table.std is not None, sampling == "grid", table.scale == "log"
    needed = ("mean", "std") if normal else ("low", "high")
    missing = next((key for key in needed if getattr(table, key) is None), "")
    both = "mean and std" if normal else "low and high, mean and std, or values"
    check_rules(
        where,
        (missing != "", f".{missing}", f"is missing; give {both}"),
        (kind.whole, "", WHOLE_NUMBER_TEXT),
        (normal and grid, ".mean", 'does not fit a grid; use sampling = "sobol" or "lhs"'),
        (normal and log, ".scale", "does not fit a mean; give low and high, or leave it out"),
        (grid and table.points is None, ".points", "is missing; say how many points the grid has, such as 8"),
    )
    written = {key: getattr(table, key) for key in ("low", "high", "mean")}
    parameters: dict[str, Any] = {key: kind.parse(v, f"{where}.{key}") for key, v in written.items() if v is not None}
    low, high = parameters.get("low", -inf), parameters.get("high", inf)
    inside = not normal or low < parameters["mean"] < high
    check_rules(
        where,
        (low >= high, ".low", f"{table.low!r} is not below high, {table.high!r}; give less"),
        (not inside, ".mean", f"{table.mean!r} is not between low and high; give one that is"),
        (log and low <= 0.0, ".low", f'{table.low!r} has no logarithm; give more than zero, or scale = "linear"'),
    )
    if normal:
        return parameters | {"std": kind.difference(table.std, f"{where}.std")}
    return parameters | {"points": table.points, "log": log}


def _read_values(table: VaryTable, kind: VariedQuantity, where: str) -> tuple[float, ...]:
    """Return the listed `values` of an axis in SI units; raise InputError for an empty list, repeats or other keys."""
    written = table.values or []
    beside = sorted(table.model_fields_set - {"values", "also", "relative", "group"})
    values = tuple(kind.parse(value, f"{where}.values.{i}") for i, value in enumerate(written))
    twice = [one for i, one in enumerate(written) if values[i] in values[:i]]
    check_rules(
        where,
        (bool(beside), "." + "".join(beside[:1]), "stands beside values; give one or the other"),
        (not values, ".values", "is empty; give one value or more"),
        (bool(twice), ".values", f"{''.join(map(repr, twice[:1]))} is there twice; give it once"),
    )
    return values
