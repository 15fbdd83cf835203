"""Values of a machine that a search may turn, with their ranges; its parts; and conditions by which it is judged."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from math import ceil

import numpy as np

from layflat.arrays import Array
from layflat.description.change import value_at
from layflat.errors import InputError
from layflat.machine import Machine
from layflat.tune.conditions import Conditions, Spread

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
    """Part of the search that is done at a time."""

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


Methods = Mapping[str, Callable[[Machine, int | None], list[Part]]]
"""Parts of a search by the method's name, from a machine and, where given, the generations in all."""


@dataclass(frozen=True)
class Tunable:
    """Knobs and judgement of a control law that is tuned."""

    values: str  # name of what is tuned, for people
    begun: Callable[[Machine], Machine]
    """Yields the machine with a value at every knob, neutral where it has none."""
    knobs: Callable[[Machine], list[Knob]]
    methods: Methods
    conditions: Callable[[Machine, int, Spread | None, int], Conditions]
    """`conditions(machine, runs, spread, seed)` yields what candidates are judged by; runs: a power of two."""
    spread: Callable[[Conditions, Machine], str]
    """Yields, in words, how conditions differ from run to run."""
    clouds: bool = False  # whether one controller may be tuned for all machines of a cloud
    complete: Callable[[Machine], Mapping[str, tuple[str, str]]] = lambda machine: {}  # noqa: ARG005
    """Yields text and reason, by path, of what a machine needs besides."""

    def parts(self, machine: Machine, method: str, generations: int | None = None) -> list[Part]:
        """Return what is looked for, in order (InputError: no such method, or generations that make no sense)."""
        if method not in self.methods:
            right = f"give {' or '.join(self.methods)}"
            raise InputError(f"unknown method {method!r} for {self.values}", where="--method", right=right)
        if generations is not None and not 1 <= generations < GENERATIONS:
            right = f"give 1 to {GENERATIONS - 1}"
            raise InputError(f"{generations} is out of range", where="--generations", right=right)
        return self.methods[method](machine, generations)
