"""Parameters to be identified, and how far around a description they are searched."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import inf
from typing import Any, NamedTuple

from layflat.description import Part
from layflat.description.change import value_at


@dataclass(frozen=True)
class Unknown:
    """A parameter to be identified.

    Args:
        path: where it stands in the description, "valve.conductance"; a nuisance begins with "start." or "log.".
        unit: SI, for tables.
        guess: where the search begins.
        low: least value.
        high: greatest value.
        log: whether it is searched on a logarithmic scale; then `low` is above zero.
        excitation: what a log has to contain to identify it, in one clause.
        nuisance: whether it is fitted only because the rest depends on it, as the state that a log begins in.
        floor: whether the lower bound is physical, such as zero delay, where a value may well lie.
    """

    path: str
    unit: str
    guess: float
    low: float
    high: float
    log: bool = True
    excitation: str = ""
    nuisance: bool = False
    floor: bool = False


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


def factor_range(factor: float, usual: float = 1.0, most: float = inf) -> Range:
    """A factor both ways, logarithmic; where the description says zero, from there to `usual`."""
    return lambda _, guess: (guess / factor, min(guess * factor, most), True) if guess > 0.0 else (0.0, usual, False)


def linear_range(factor: float, usual: float) -> Range:
    """As `factor_range`, but linear: what adds to something known does not change by factors."""
    return lambda _, guess: (guess / factor, guess * factor, False) if guess > 0.0 else (0.0, usual, False)


def fixed_range(low: float, high: float, *, log: bool = False) -> Range:
    """These bounds, or the description's own value where that lies beyond."""
    return lambda _, guess: (min(low, guess), max(high, guess), log)


def from_zero(most: Callable[[Any, float], float]) -> Range:
    """From zero on."""
    return lambda described, guess: (0.0, max(most(described, guess), guess), False)


def around(span: Callable[[Any], float]) -> Range:
    """As far both ways."""
    return lambda described, guess: (guess - span(described), guess + span(described), False)
