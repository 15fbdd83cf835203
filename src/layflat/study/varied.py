"""One thing that varies: its values over the unit interval, or on a grid."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from layflat.description.change import value_at
from layflat.errors import InputError
from layflat.machine import Machine
from layflat.study.description import Range
from layflat.study.kinds import FACTOR, Kind, kind

Array = NDArray[np.float64]

EDGE = 1e-12
"""A normal distribution is cut off where less than this share of it lies beyond."""


@dataclass(frozen=True)
class Varied:
    """Something that varies, in SI units: among `values`, normally where there is a `deviation`, else evenly.

    Args:
        path: what varies.
        kind: of its values.
        low: least value; a normal distribution may have none.
        high: greatest value; likewise.
        points: on a grid.
        log: whether it is the logarithm that is spread evenly.
        values: to choose from.
        mean: of a normal distribution, before it is cut off at `low` and `high`.
        deviation: of a normal distribution.
        also: paths that vary along with it.
        relative: whether its values are factors on what the machine says.
        group: what it belongs to, where sensitivity is asked for.
    """

    path: str
    kind: Kind
    low: float | None = None
    high: float | None = None
    points: int | None = None
    log: bool = False
    values: tuple[float, ...] = ()
    mean: float | None = None
    deviation: float | None = None
    also: tuple[str, ...] = ()
    relative: bool = False
    group: str | None = None

    @property
    def paths(self) -> tuple[str, ...]:
        """Everything that it changes."""
        return (self.path, *self.also)

    def at(self, share: Array) -> Array:
        """Values that lie at shares, 0 to 1, of the distribution."""
        if self.values:
            values: Array = np.array(self.values)
            chosen: Array = values[np.minimum((share * len(values)).astype(int), len(values) - 1)]
            return chosen
        if self.deviation is not None:
            return self._normal(share)
        assert self.low is not None
        assert self.high is not None
        if self.log:
            return np.clip(self.low * (self.high / self.low) ** share, self.low, self.high)
        return np.clip(self.low + share * (self.high - self.low), self.low, self.high)

    @property
    def count(self) -> int:
        """Its values on a grid, counted."""
        return len(self.values) or self.points or 0

    def grid(self) -> Array:
        """Its values on a grid."""
        return np.array(self.values) if self.values else self.at(np.linspace(0.0, 1.0, self.points or 0))

    def thinned(self, points: int) -> Varied:
        """The same with at most so many points on a grid, spread over all of it."""
        if self.values:
            kept = np.unique(np.linspace(0, len(self.values) - 1, min(points, len(self.values))).astype(int))
            return replace(self, values=tuple(self.values[i] for i in kept))
        return replace(self, points=min(points, self.points or points))

    def canonical(self) -> dict[str, Any]:
        """How it varies, as it could stand in the file, in SI units."""
        numbers = {"low": self.low, "high": self.high, "mean": self.mean, "deviation": self.deviation}
        written = {key: self.kind.written(value) for key, value in numbers.items() if value is not None}
        noted = {"also": list(self.also), "relative": self.relative, "group": self.group}
        linked = {key: value for key, value in noted.items() if value}
        if self.values:
            return {"values": [self.kind.written(value) for value in self.values], **linked}
        scale = {} if self.deviation is not None else {"scale": "log" if self.log else "linear"}
        return written | scale | ({"points": self.points} if self.points else {}) | linked

    def _normal(self, share: Array) -> Array:
        from scipy.special import ndtr, ndtri  # noqa: PLC0415  # not needed by most studies

        assert self.mean is not None
        assert self.deviation is not None
        below = 0.0 if self.low is None else float(ndtr((self.low - self.mean) / self.deviation))
        above = 1.0 if self.high is None else float(ndtr((self.high - self.mean) / self.deviation))
        inside = np.clip(below + share * (above - below), EDGE, 1.0 - EDGE)
        values = self.mean + self.deviation * ndtri(inside)
        return np.clip(values, -np.inf if self.low is None else self.low, np.inf if self.high is None else self.high)


def applied(varied: Sequence[Varied], drawn: Mapping[str, Array], machine: Machine) -> dict[str, Array]:
    """What to set on a machine, by path (SI), from samples of what varies."""
    return {
        path: drawn[one.path] * value_at(machine, path) if one.relative else drawn[one.path]
        for one in varied
        for path in one.paths
    }


def resolved(path: str, given: Range, machine: Machine, sampling: str, where: str) -> Varied:
    """What the file says about one path and those that vary along, checked and in SI units.

    Raises:
        InputError: naming `where`, the key and the value.
    """
    if given.group is not None and sampling != "saltelli":
        raise InputError("has no effect", where=f"{where}.group", right='use sampling = "saltelli", or leave it out')
    own = kind(machine, path, where)
    others = [kind(machine, other, f"{where}.also.{i}") for i, other in enumerate(given.also)]
    if given.relative:
        settings = [name for name in (path, *given.also) if name.startswith("scenario.")]
        if settings:
            raise InputError(
                f"{settings[0]} is no number of the machine", where=f"{where}.relative", right="leave it out"
            )
        if any(other.whole for other in (own, *others)):
            raise InputError(
                "is a whole number", where=f"{where}.relative", right="give values, such as values = [10, 12]"
            )
        own = FACTOR
    else:
        odd = next((name for name, other in zip(given.also, others, strict=True) if other.unit != own.unit), None)
        if odd:
            right = "vary it by itself, or add relative = true"
            raise InputError(f"{odd!r} is of another kind", where=f"{where}.also", right=right)
    found = _resolved(path, given, own, sampling, where)
    return replace(found, also=given.also, relative=given.relative, group=given.group)


def groups(varied: Sequence[Varied]) -> dict[str, list[int]]:
    """Numbers of the things in each group, by its name in alphabetical order."""
    names = sorted({one.group for one in varied if one.group is not None})
    return {name: [i for i, one in enumerate(varied) if one.group == name] for name in names}


def _resolved(path: str, given: Range, kind: Kind, sampling: str, where: str) -> Varied:
    if given.values is not None:
        return Varied(path, kind, values=_values(given, kind, where))
    if given.mean is not None or given.deviation is not None:
        return _about_mean(path, given, kind, sampling, where)
    if given.low is None or given.high is None:
        missing = "low" if given.low is None else "high"
        raise InputError(
            "is missing", where=f"{where}.{missing}", right="give low and high, mean and deviation, or values"
        )
    if kind.whole:
        raise InputError("is a whole number", where=where, right="give values, such as values = [10, 12]")
    low, high = _ends(given, kind, where)
    if given.scale == "log" and low is not None and low <= 0.0:
        raise InputError(
            f"{given.low!r} has no logarithm", where=f"{where}.low", right='give more than zero, or scale = "linear"'
        )
    if sampling == "grid" and given.points is None:
        raise InputError("is missing", where=f"{where}.points", right="say how many points the grid has, such as 8")
    return Varied(path, kind, low, high, given.points, given.scale == "log")


def _values(given: Range, kind: Kind, where: str) -> tuple[float, ...]:
    beside = sorted(given.model_fields_set - {"values", "also", "relative", "group"})
    if beside:
        raise InputError("stands beside values", where=f"{where}.{beside[0]}", right="give one or the other")
    assert given.values is not None
    values = tuple(kind.parse(value, f"{where}.values.{i}") for i, value in enumerate(given.values))
    if not values:
        raise InputError("is empty", where=f"{where}.values", right="give one value or more")
    twice = next((i for i, value in enumerate(values) if value in values[:i]), None)
    if twice is not None:
        raise InputError(f"{given.values[twice]!r} is there twice", where=f"{where}.values", right="give it once")
    return values


def _about_mean(path: str, given: Range, kind: Kind, sampling: str, where: str) -> Varied:
    missing = "mean" if given.mean is None else "deviation" if given.deviation is None else None
    if missing:
        raise InputError("is missing", where=f"{where}.{missing}", right="give mean and deviation")
    if kind.whole:
        raise InputError("is a whole number", where=where, right="give values, such as values = [10, 12]")
    if sampling == "grid":
        raise InputError("does not fit a grid", where=f"{where}.mean", right='use sampling = "sobol" or "lhs"')
    if given.scale == "log":
        raise InputError("does not fit a mean", where=f"{where}.scale", right="give low and high, or leave it out")
    mean = kind.parse(given.mean, f"{where}.mean")
    deviation = kind.difference(given.deviation, f"{where}.deviation")
    low, high = _ends(given, kind, where)
    if (low is not None and mean <= low) or (high is not None and mean >= high):
        raise InputError(f"{given.mean!r} is not between low and high", where=f"{where}.mean", right="give one that is")
    return Varied(path, kind, low, high, mean=mean, deviation=deviation)


def _ends(given: Range, kind: Kind, where: str) -> tuple[float | None, float | None]:
    low = None if given.low is None else kind.parse(given.low, f"{where}.low")
    high = None if given.high is None else kind.parse(given.high, f"{where}.high")
    if low is not None and high is not None and low >= high:
        raise InputError(f"{given.low!r} is not below high, {given.high!r}", where=f"{where}.low", right="give less")
    return low, high
