"""Tuned values of a machine with their ranges (knobs), the parts of a search, and the definition of a tunable law."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from math import ceil

import numpy as np

from layflat.arrays import Array
from layflat.description.change import value_at
from layflat.errors import InputError
from layflat.machine import Machine
from layflat.tune.conditions import ConditionRanges, Conditions

PER_DEG, PER_BAR = 180.0 / np.pi, 1e-5


@dataclass(frozen=True)
class Knob:
    """Value to be tuned, which one or more paths of the description share."""

    paths: tuple[str, ...]
    low: float  # of its range, in `unit`
    high: float
    unit: str = ""
    si: float = 1.0  # factor from `unit` to SI
    neutral: float = 0.0  # start that does not depend on the machine, in `unit`

    def text(self, value: float) -> str | float:
        """Return the value as it is written in a description: three significant digits, with any unit."""
        number = float(f"{value:.3g}")
        return f"{number:g} {self.unit}" if self.unit else number


def neutral_values(knobs: Sequence[Knob]) -> Array:
    """Return start values that do not depend on the machine, in the knobs' units."""
    return np.array([knob.neutral for knob in knobs])


def current_values(machine: Machine, knobs: Sequence[Knob]) -> Array:
    """Return the values of a machine, in the knobs' units."""
    return np.array([value_at(machine, knob.paths[0]) / knob.si for knob in knobs])


def round_values(values: Array) -> Array:
    """Return values rounded to three significant digits, as they are written."""
    return np.array([float(f"{value:.3g}") for value in np.ravel(values)]).reshape(np.shape(values))


def values_to_fractions(knobs: Sequence[Knob], values: Array) -> Array:
    """Return the logarithmic positions of values in the knobs' ranges, 0 to 1; values outside are clipped."""
    low, high = _knob_limits(knobs)
    return np.asarray(np.log(np.clip(values, low, high) / low) / np.log(high / low))


def fractions_to_values(knobs: Sequence[Knob], fractions: Array) -> Array:
    """Return values at logarithmic positions in the knobs' ranges, 0 to 1."""
    low, high = _knob_limits(knobs)
    return np.asarray(low * (high / low) ** fractions)


def _knob_limits(knobs: Sequence[Knob]) -> Array:
    return np.array([(knob.low, knob.high) for knob in knobs]).T


MAX_GENERATIONS = 10_000  # each has a seed of its own


@dataclass(frozen=True)
class SearchStage:
    """Stage of a search with a constant number of runs per candidate."""

    generations: int
    runs: int  # by which each candidate is judged: a power of two


@dataclass(frozen=True)
class SearchPart:
    """Part of a search in which some of the knobs are varied."""

    name: str  # in words
    knobs: tuple[int, ...]  # indices of the varied knobs; the others stay constant
    population: int  # candidates per generation
    stages: tuple[SearchStage, ...]  # with increasing numbers of runs


def split_generations(stages: Sequence[SearchStage], generations: int | None) -> tuple[SearchStage, ...]:
    """Return stages scaled to a total number of generations; None: unchanged."""
    default = sum(stage.generations for stage in stages)
    total = default if generations is None else generations
    ends = [ceil(total * sum(s.generations for s in stages[: i + 1]) / default) for i in range(len(stages))]
    return tuple(
        SearchStage(end - begin, stage.runs) for stage, begin, end in zip(stages, [0, *ends], ends, strict=False)
    )


Method = Callable[[Machine, int | None], list[SearchPart]]
"""Function from a machine and the total number of generations (None: default) to the parts of a search."""


@dataclass(frozen=True)
class TunableLaw:
    """Control law that can be tuned: its knobs, search methods and conditions."""

    values: str  # name of the tuned values in words, such as "gains"
    with_neutral_values: Callable[[Machine], Machine]
    """Returns the machine with a value at every knob, neutral where it has none."""
    knobs: Callable[[Machine], list[Knob]]
    methods: Mapping[str, Method]
    conditions: Callable[[Machine, int, ConditionRanges | None, int], Conditions]
    """Returns the conditions of candidates from machine, number of runs (a power of two), ranges and seed."""
    spread: Callable[[Conditions, Machine], str]
    """Returns the ranges of the conditions in words."""
    clouds: bool = False  # whether one controller can be tuned for all machines of a cloud
    complete: Callable[[Machine], Mapping[str, tuple[str, str]]] = lambda machine: {}  # noqa: ARG005
    """Returns text and reason, by path, of values that a machine lacks and that are not tuned."""

    def parts(self, machine: Machine, method: str, generations: int | None = None) -> list[SearchPart]:
        """Return the parts of a search, in order.

        Args:
            machine: machine to be tuned.
            method: name of the search method.
            generations: number in all; default: as many as the method needs.

        Raises:
            InputError: there is no such method, or the number of generations is out of range.
        """
        if method not in self.methods:
            right = f"give {' or '.join(self.methods)}"
            raise InputError(f"unknown method {method!r} for {self.values}", where="method", right=right)
        if generations is not None and not 1 <= generations < MAX_GENERATIONS:
            right = f"give 1 to {MAX_GENERATIONS - 1}"
            raise InputError(f"{generations} is out of range", where="generations", right=right)
        return self.methods[method](machine, generations)
