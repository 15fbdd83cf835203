"""Model to be fitted: measured signals, unknowns, and a simulation of the signals from the unknowns.

The search for an unknown begins with its value in the description and stays within bounds.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable, Collection, Mapping, Sequence
from copy import copy
from dataclasses import dataclass
from functools import cached_property
from math import inf
from typing import Any, NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from layflat.arrays import Array
from layflat.description import Part
from layflat.description.change import value_at
from layflat.errors import InputError


@dataclass(frozen=True)
class Unknown:
    """Parameter to be identified."""

    path: str  # in the description, such as "valve.conductance"; of a nuisance "start...." or "log...."
    unit: str  # SI, for tables
    guess: float  # first value of the search
    low: float  # lower bound
    high: float  # upper bound
    log: bool = True  # searched on a logarithmic scale; then `low` is above zero
    excitation: str = ""  # clause on what a log must contain to identify it
    nuisance: bool = False  # fitted only because others depend on it, such as the first state of a log
    floor: bool = False  # the lower bound is physical, such as zero delay, and may be the right value
    ceiling: bool = False  # the same for the upper bound
    prior: tuple[float, float] | None = None  # mean and standard deviation before any log, SI; only on a linear scale


RangeRule = Callable[[Any, float], tuple[float, float, bool]]
"""Rule for lower and upper bound (SI) and a logarithmic scale, from the description and its present value."""


class ParameterSpec(NamedTuple):
    """Parameter that can be fitted: path, SI unit, rule for its range, and what a log must contain for it."""

    path: str
    unit: str
    span: RangeRule
    excitation: str
    floor: bool = False

    def unknown(self, described: Part) -> Unknown:
        """Return the unknown for a description, whose value is the first guess; a lower bound of zero is physical."""
        guess = float(value_at(described, self.path))
        low, high, log = self.span(described, guess)
        floor = self.floor or low == 0.0
        return Unknown(self.path, self.unit, guess, low, high, log, self.excitation, floor=floor)


def factor_range(factor: float, usual: float = 1.0, upper: float = inf, *, log: bool = True) -> RangeRule:
    """Return a rule for a range of a factor below and above the description's value.

    Args:
        factor: above 1.
        usual: upper bound where the description's value is zero, SI; the range then begins at zero, and is linear.
        upper: limit of the upper bound, SI.
        log: search on a logarithmic scale.
    """
    return lambda _, guess: (guess / factor, min(guess * factor, upper), log) if guess > 0.0 else (0.0, usual, False)


def fixed_range(low: float, high: float, *, log: bool = False) -> RangeRule:
    """Return a rule for fixed bounds, extended to the description's value where that lies beyond.

    Args:
        low: lower bound, SI.
        high: upper bound, SI.
        log: search on a logarithmic scale.
    """
    return lambda _, guess: (min(low, guess), max(high, guess), log)


def zero_range(upper: Callable[[Any, float], float]) -> RangeRule:
    """Return a rule for a range from zero to `upper`(description, value), SI, or to the value if that is greater."""
    return lambda described, guess: (0.0, max(upper(described, guess), guess), False)


def symmetric_range(span: Callable[[Any], float]) -> RangeRule:
    """Return a rule for a range of the description's value plus and minus `span`(description), SI."""
    return lambda described, guess: (guess - span(described), guess + span(described), False)


SLOPE_STEP = 1e-6  # half the width of a difference quotient, as a fraction of the range between the bounds


class Scaling:
    """Map of the unknowns' values (SI) to the unit interval: 0 at the lower bound, 1 at the upper one.

    Raises:
        InputError: bounds are no range, or a guess lies outside them.
    """

    def __init__(self, unknowns: Sequence[Unknown]) -> None:
        for unknown in unknowns:
            low, high, where = unknown.low, unknown.high, unknown.path
            if not (low < high and (low > 0.0 or not unknown.log)):
                raise InputError(
                    f"{low:g} to {high:g} is not a range",
                    where=where,
                    right="give low < high, and low > 0 for a log scale",
                )
            if not low <= unknown.guess <= high:
                where = f"{where}: {unknown.guess:g} {unknown.unit}"
                raise InputError("lies outside the searched range", where=where, right=f"give {low:g} to {high:g}")
        self.plain: Scaling = self  # of the unknowns themselves, where this one scales functions of them
        self.log = np.array([unknown.log for unknown in unknowns], dtype=bool)
        self.low = np.array([unknown.low for unknown in unknowns])
        self.high = np.array([unknown.high for unknown in unknowns])

    def scale(self, values: Array) -> Array:
        """Return values scaled to 0..1, (..., unknowns)."""
        with np.errstate(invalid="ignore", divide="ignore"):  # of those that are not logarithmic
            by_log = np.log(values / self.low) / np.log(self.high / self.low)
        return np.asarray(np.where(self.log, by_log, (values - self.low) / (self.high - self.low)))

    def unscale(self, scaled: Array) -> Array:
        """Return the values (SI) of scaled ones, (..., unknowns): inverse of `scale`."""
        with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
            by_log = self.low * (self.high / self.low) ** scaled
        values = np.where(self.log, by_log, self.low + scaled * (self.high - self.low))
        return np.asarray(values, dtype=np.float64)

    def to_plain(self, scaled: Array) -> tuple[Array, Array]:
        """Return scaled values in the plain scaling of the unknowns, and the Jacobian of this change.

        Args:
            scaled: scaled unknowns in this scaling, (unknowns,).

        Returns:
            The same in `plain`, (unknowns,), and its derivatives (rows) by this scaling's (columns).
        """
        if self.plain is self:
            return scaled, np.eye(len(scaled))
        step = SLOPE_STEP * np.eye(len(scaled))
        up, down = (self.plain.scale(self.unscale(scaled + sign * step)) for sign in (1.0, -1.0))
        return self.plain.scale(self.unscale(scaled)), np.asarray((up - down).T / (2.0 * SLOPE_STEP))


Flags = NDArray[np.bool_]

FITTED_FRACTION = 2.0 / 3.0  # of a log, fitted where no other log is used for validation


@dataclass(frozen=True)
class ModelOutput:
    """Measured signal that is compared with the simulated one."""

    name: str  # such as "angle large"
    unit: str  # SI
    log: str  # name of its log
    time: Array  # s, (samples,)
    measured: Array  # SI, (samples,), NaN where nothing was measured
    fitted: Flags  # (samples,), True for a sample that is fitted, False for validation
    scale: float  # divisor of errors, SI: the noise, or the error that matters
    driven_by: Array | None = (
        None  # input with most influence, (samples,): errors of a good model don't correlate with it
    )


class Model(ABC):
    """Bench that can be simulated for any values of its unknowns."""

    unknowns: tuple[Unknown, ...]  # like the outputs, fixed after construction
    outputs: tuple[ModelOutput, ...]
    remarks: tuple[str, ...] = ()  # sentences for the report on the model's structure
    cross_validated: bool = False  # unknowns are chosen, and errors estimated, by leaving logs out

    @abstractmethod
    def simulate(self, values: Array) -> Array:
        """Simulate freely from the first state of the logs, with their inputs only.

        Args:
            values: values of the unknowns in SI, a candidate a row: (candidates, unknowns).

        Returns:
            All outputs, one after the other, (candidates, samples); NaN where a candidate diverged.
        """

    def project(self, scaled: Array, triangle: Array) -> Array:  # noqa: ARG002  # what overriding models need
        """Return the nearest scaled values that a description can have; default: the same.

        Args:
            scaled: found by the search, see `scaling`.
            triangle: weights of the distance: `triangle` times a change of `scaled` has the norm of the change of all
                residuals, the priors' among them.
        """
        return scaled

    def starts(self) -> Array:
        """Return more starts of the search, (starts, unknowns) in SI; the guess comes first in any case."""
        return np.empty((0, len(self.unknowns)))

    def mirrored_values(self, values: Array) -> Array:  # noqa: ARG002  # what overriding models need
        """Return values far from the estimates that may predict as well, for the search to compare; default: none.

        Args:
            values: values of the unknowns in SI, (unknowns,).

        Returns:
            The same with some of them changed, (mirrors, unknowns); always as many, in the same order.
        """
        return np.empty((0, len(self.unknowns)))

    def continuations(self) -> Sequence[Sequence["Model"]]:
        """Return sequences of models of the same unknowns and outputs, to be fitted in turn, the easiest first.

        Several such continuations, of the same last model, are tried one after the other until one explains the logs.
        The last model gives values and intervals; what the values predict is simulated by this model itself.
        """
        return ((self,),)

    def tracking_model(self) -> "Model | None":
        """Return the model that predicts with feedback of the logs, where a free one diverges even with right values.

        Default: None, as most do not.
        """
        return None

    def simpler_models(self) -> "Mapping[str, Model]":
        """Return models of the same logs with fewer unknowns, by name, the simplest first; default: none."""
        return {}

    def hold(self, paths: Collection[str]) -> Self:
        """Return a copy in which some unknowns keep the values of the description."""
        other = copy(self)
        other.unknowns = tuple(unknown for unknown in self.unknowns if unknown.path not in paths)
        for name in ("guess", "scaling"):
            other.__dict__.pop(name, None)
        return other

    def described_values(self, values: Array) -> dict[str, float]:
        """Return the description's values (SI) by path from those of the unknowns, without nuisances."""
        columns = self.columns(values)
        return {unknown.path: float(columns[unknown.path]) for unknown in self.unknowns if not unknown.nuisance}

    def columns(self, values: Array) -> dict[str, Array]:
        """Return the values of each unknown, a number or (candidates,), by its path, of `values`, (..., unknowns)."""
        return dict(zip((unknown.path for unknown in self.unknowns), values.T, strict=True))

    @cached_property
    def scaling(self) -> Scaling:
        """Coordinates of the search; default: the unknowns themselves, scaled between their bounds.

        A model that knows functions of its unknowns in which its outputs are closer to linear scales those.
        """
        return Scaling(self.unknowns)

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
        """Mask of the samples that are fitted and not NaN, (all samples,)."""
        return np.concatenate([output.fitted & np.isfinite(output.measured) for output in self.outputs])

    @cached_property
    def slices(self) -> tuple[slice, ...]:
        """Slice of each output among all samples."""
        ends = np.cumsum([len(output.measured) for output in self.outputs]).tolist()
        return tuple(slice(end - len(output.measured), end) for end, output in zip(ends, self.outputs, strict=True))
