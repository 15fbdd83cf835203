"""What is sought of a description: where it stands, and how far around the described value."""

from collections.abc import Callable
from dataclasses import dataclass
from math import inf
from typing import Any, NamedTuple

from layflat.description import Part
from layflat.description.change import value_at


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
    """As far both ways."""
    return lambda described, guess: (guess - span(described), guess + span(described), False)
