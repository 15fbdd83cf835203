"""What a search may turn: values of a machine with their ranges, and the parts of a search in which they are turned."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import ceil

import numpy as np

from layflat.arrays import Array
from layflat.description.change import value_at
from layflat.machine import Machine

PER_DEG, PER_BAR = 180.0 / np.pi, 1e-5


@dataclass(frozen=True)
class Knob:
    """One value to be found: paths that share it, its range in a unit, that unit in SI, and a neutral start."""

    paths: tuple[str, ...]
    low: float
    high: float
    unit: str = ""
    si: float = 1.0
    neutral: float = 0.0

    def text(self, value: float) -> str | float:
        """Return the value as it is written in a description."""
        number = float(f"{value:.3g}")
        return f"{number:g} {self.unit}" if self.unit else number


def neutral_values(knobs: Sequence[Knob]) -> Array:
    """Return values to begin with that know nothing of the machine, in the knobs' units."""
    return np.array([knob.neutral for knob in knobs])


def values_of(machine: Machine, knobs: Sequence[Knob]) -> Array:
    """Return the values that a machine has now, in the knobs' units."""
    return np.array([value_at(machine, knob.paths[0]) / knob.si for knob in knobs])


def rounded(values: Array) -> Array:
    """Return values to the three digits with which they are written."""
    return np.array([float(f"{value:.3g}") for value in np.ravel(values)]).reshape(np.shape(values))


def to_shares(knobs: Sequence[Knob], values: Array) -> Array:
    """Return where values lie in the knobs' ranges, 0 to 1, counted in factors: a gain is looked for by its size."""
    low, high = _ends(knobs)
    return np.asarray(np.log(np.clip(values, low, high) / low) / np.log(high / low))


def from_shares(knobs: Sequence[Knob], shares: Array) -> Array:
    """Return values from where they lie in the knobs' ranges."""
    low, high = _ends(knobs)
    return np.asarray(low * (high / low) ** shares)


def _ends(knobs: Sequence[Knob]) -> Array:
    return np.array([(knob.low, knob.high) for knob in knobs]).T


GENERATIONS = 10_000  # at most; each has a seed of its own


@dataclass(frozen=True)
class Stage:
    """So many generations, of candidates that are each judged by so many runs (a power of two)."""

    generations: int
    runs: int


@dataclass(frozen=True)
class Part:
    """What is looked for at a time."""

    name: str  # for people
    knobs: tuple[int, ...]  # places, among all knobs, of those that are turned; the others stay as they are
    population: int  # candidates of a generation
    stages: tuple[Stage, ...]  # few runs first, more later


def split(stages: Sequence[Stage], generations: int | None) -> tuple[Stage, ...]:
    """Return stages of so many generations in all, each with its share of them; None: as they are."""
    usual = sum(stage.generations for stage in stages)
    wanted = usual if generations is None else generations
    ends = [ceil(wanted * sum(s.generations for s in stages[: i + 1]) / usual) for i in range(len(stages))]
    return tuple(Stage(end - begin, stage.runs) for stage, begin, end in zip(stages, [0, *ends], ends, strict=False))
