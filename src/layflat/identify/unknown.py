"""Unknowns of a description: described value, bounds, and value as a share of the way between them."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import inf
from typing import Any, NamedTuple

import numpy as np

from layflat.arrays import Array
from layflat.description import Part
from layflat.description.change import value_at
from layflat.errors import InputError


@dataclass(frozen=True)
class Unknown:
    """A parameter to be identified."""

    path: str  # where it stands in the description, "valve.conductance"; a nuisance begins with "start." or "log."
    unit: str  # SI, for tables
    guess: float  # where the search begins
    low: float  # least value
    high: float  # greatest value
    log: bool = True  # whether it is searched on a logarithmic scale; then `low` is above zero
    excitation: str = ""  # what a log has to contain to identify it, in one clause
    nuisance: bool = False  # fitted only because the rest depends on it, as the state that a log begins in
    floor: bool = False  # whether the lower bound is physical, such as zero delay, where a value may well lie
    ceiling: bool = False  # the same of the upper bound
    prior: tuple[float, float] | None = None  # mean and standard deviation before any log (SI), not of logarithmic ones


Range = Callable[[Any, float], tuple[float, float, bool]]
"""Bounds (SI) from the description and its present value, and whether the search is logarithmic."""


class ParameterSpec(NamedTuple):
    """A parameter that can be fitted: where it stands, its unit, its range, and what a log must contain for it."""

    path: str
    unit: str
    span: Range
    excitation: str
    floor: bool = False

    def unknown(self, described: Part) -> Unknown:
        """Return the unknown that begins with the value of a description; a lower bound of zero is physical."""
        guess = float(value_at(described, self.path))
        low, high, log = self.span(described, guess)
        floor = self.floor or low == 0.0
        return Unknown(self.path, self.unit, guess, low, high, log, self.excitation, floor=floor)


def factor_range(factor: float, usual: float = 1.0, most: float = inf, *, log: bool = True) -> Range:
    """A factor both ways; where the description says zero, from there to `usual`."""
    return lambda _, guess: (guess / factor, min(guess * factor, most), log) if guess > 0.0 else (0.0, usual, False)


def fixed_range(low: float, high: float, *, log: bool = False) -> Range:
    """These bounds, or the description's own value where that lies beyond."""
    return lambda _, guess: (min(low, guess), max(high, guess), log)


def from_zero(most: Callable[[Any, float], float]) -> Range:
    """From zero on."""
    return lambda described, guess: (0.0, max(most(described, guess), guess), False)


def around(span: Callable[[Any], float]) -> Range:
    """Return bounds that are as far both ways."""
    return lambda described, guess: (guess - span(described), guess + span(described), False)


NEAR = 1e-6  # share by which it is seen how shares change by others


class Shares:
    """Values in SI as shares, 0 at the lower bound and 1 at the upper; raise InputError if a guess lies outside."""

    def __init__(self, unknowns: Sequence[Unknown]) -> None:
        for one in unknowns:
            if not (one.low < one.high and (one.low > 0.0 or not one.log)):
                raise InputError(f"{one.low:g} to {one.high:g} is not a range", where=one.path, right="give low < high")
            if not one.low <= one.guess <= one.high:
                where = f"{one.path}: {one.guess:g} {one.unit}"
                raise InputError("lies outside what is searched", where=where, right=f"{one.low:g} to {one.high:g}")
        self.own: Shares = self  # shares of the unknowns themselves, where these are of others
        self.log = np.array([one.log for one in unknowns], dtype=bool)
        self.low = np.array([one.low for one in unknowns])
        self.high = np.array([one.high for one in unknowns])

    def of(self, values: Array) -> Array:
        """Shares of values, (..., unknowns)."""
        with np.errstate(invalid="ignore", divide="ignore"):  # of those that are not logarithmic
            by_log = np.log(values / self.low) / np.log(self.high / self.low)
        return np.asarray(np.where(self.log, by_log, (values - self.low) / (self.high - self.low)))

    def values(self, shares: Array) -> Array:
        """Values of shares, (..., unknowns)."""
        with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
            by_log = self.low * (self.high / self.low) ** shares
        found = np.where(self.log, by_log, self.low + shares * (self.high - self.low))
        return np.asarray(found, dtype=np.float64)

    def as_own(self, shares: Array) -> tuple[Array, Array]:
        """Shares as those of the unknowns themselves, and how much these (rows) change by them (columns)."""
        if self.own is self:
            return shares, np.eye(len(shares))
        away = NEAR * np.eye(len(shares))
        up, down = (self.own.of(self.values(shares + way * away)) for way in (1.0, -1.0))
        return self.own.of(self.values(shares)), np.asarray((up - down).T / (2.0 * NEAR))
