"""What is fitted: measured signals, the unknowns, and a simulation of the one from the other."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from math import inf
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from layflat.arrays import Array
from layflat.description import Part
from layflat.description.change import value_at

Flags = NDArray[np.bool_]

FITTED = 2.0 / 3.0  # share of a log that is fitted where no other log is there for validation


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


@dataclass(frozen=True)
class Output:
    """A measured signal that is compared with the simulated one."""

    name: str  # such as "angle large"
    unit: str  # SI
    log: str  # the log that it was read from
    time: Array  # s, (samples,)
    measured: Array  # (samples,), not a number where nothing was measured
    fitted: Flags  # (samples,), whether a sample is fitted; otherwise it is for validation
    scale: float  # what an error is divided by: the noise, or how large an error matters
    driven_by: Array | None = None  # input that moves it most, (samples,): errors of a good model don't follow it


class Model(ABC):
    """A bench that can be simulated for any values of what is unknown."""

    unknowns: tuple[Unknown, ...]  # as the outputs fixed once it is made
    outputs: tuple[Output, ...]
    remarks: tuple[str, ...] = ()  # what the logs say of the model's structure, in sentences for the report

    @abstractmethod
    def simulate(self, values: Array) -> Array:
        """Run freely from what the logs begin with: only inputs of the logs are given.

        Args:
            values: of the unknowns in SI, a candidate a row: (candidates, unknowns).

        Returns:
            All outputs, one after the other, (candidates, samples); not numbers where a candidate diverged.
        """

    def possible(self, values: Array) -> Array:
        """Return the candidates, (candidates, unknowns), that `simulate` takes these for; default: these."""
        return values

    def starts(self) -> Array:
        """Where else the search may begin, (starts, unknowns) in SI; the guess comes first in any case."""
        return np.empty((0, len(self.unknowns)))

    def continuations(self) -> Sequence[Sequence["Model"]]:
        """Models of the same unknowns and outputs through which the search goes, from the easiest on.

        Several such continuations, of the same last model, are tried one after the other until one explains the logs.
        The last model gives values and intervals; what the values predict is simulated by this model itself.
        """
        return ((self,),)

    def led(self) -> "Model | None":
        """What predicts in its place where this one runs away from its logs, even with right values, and says so.

        Default: None, as most do not.
        """
        return None

    def written(self, values: Array) -> dict[str, float]:
        """What values of the unknowns (SI) make of the description, by its paths; items of lists by their number."""
        columns = self.columns(values)
        return {one.path: float(columns[one.path]) for one in self.unknowns if not one.nuisance}

    def columns(self, values: Array) -> dict[str, Array]:
        """Return what stands in the last axis of `values`, a row or (candidates, unknowns), by the unknowns' paths."""
        return dict(zip((unknown.path for unknown in self.unknowns), values.T, strict=True))

    @cached_property
    def guess(self) -> Array:
        """Guessed values, (unknowns,)."""
        return np.array([unknown.guess for unknown in self.unknowns])

    @cached_property
    def measured(self) -> Array:
        """All that was measured, one output after the other."""
        return np.concatenate([output.measured for output in self.outputs])

    @cached_property
    def used(self) -> Flags:
        """Which samples are fitted."""
        return np.concatenate([output.fitted & np.isfinite(output.measured) for output in self.outputs])

    @cached_property
    def slices(self) -> tuple[slice, ...]:
        """Where each output stands among all samples."""
        ends = np.cumsum([len(output.measured) for output in self.outputs]).tolist()
        return tuple(slice(end - len(output.measured), end) for end, output in zip(ends, self.outputs, strict=True))


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
