"""What a search may turn, values of a machine with their ranges; and methods: all at once, or phase by phase."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import cycle
from math import ceil
from typing import Any

import numpy as np

from layflat.arrays import Array
from layflat.control.paper import PaperGainsPart
from layflat.description.change import changed, value_at
from layflat.errors import InputError, MachineError
from layflat.machine import Machine
from layflat.machine.gains import check_papers_law

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


GAINS = (
    Knob(("far.error",), 0.03, 1.0, "V/deg", PER_DEG, 0.3),
    Knob(("far.pressure",), 0.3, 10.0, "V/bar", PER_BAR, 2.0),
    Knob(("near.error",), 0.1, 4.0, "V/deg", PER_DEG, 0.5),
    Knob(("near.pressure",), 0.3, 10.0, "V/bar", PER_BAR, 1.0),
    Knob(("near_below.error",), 4.0, 40.0, "deg", 1 / PER_DEG, 15.0),
    Knob(("near_below.speed",), 10.0, 200.0, "deg/s", 1 / PER_DEG, 60.0),
    Knob(("close.error",), 0.3, 8.0, "V/deg", PER_DEG, 1.0),
    Knob(("close.pressure",), 0.1, 10.0, "V/bar", PER_BAR, 0.5),
    Knob(("close_below.error",), 0.5, 6.0, "deg", 1 / PER_DEG, 2.0),
    Knob(("close_below.speed",), 1.0, 40.0, "deg/s", 1 / PER_DEG, 10.0),
    Knob(("integral",), 0.2, 40.0, "V/(deg s)", PER_DEG, 2.0),
)
"""Gains of a joint, by their paths below its `gains`."""

PHASES = {"far": (0, 1), "near": (2, 3, 4, 5), "close": (6, 7, 8, 9, 10)}
"""Which of a joint's gains each phase of a move has, the threshold below which it holds included."""

INTEGRAL_LIMIT = 0.4  # of a joint without gains: share of full opening


def gain_knobs(joint: str) -> list[Knob]:
    """Return the gains of one joint, phase by phase."""
    return [replace(knob, paths=tuple(f"joint.{joint}.gains.{path}" for path in knob.paths)) for knob in GAINS]


def neutral_gains(joints: int) -> Array:
    """Return gains to begin with, of so many joints, in the knobs' units."""
    return np.tile([knob.neutral for knob in GAINS], joints)


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


def with_gains(machine: Machine) -> Machine:
    """Return the machine with neutral gains in those of its joints that have none.

    Raises:
        MachineError: it has no controller, or another than the paper's.
    """
    if machine.valve is None or machine.controller is None:
        right = "add the parts `valve` and `controller`; `layflat show paper-arm` has both"
        raise MachineError("has no controller to be tuned", where=machine.origin, right=right)
    check_papers_law(machine, "tuning")
    neutral: dict[str, Any] = {"integral_limit": f"{INTEGRAL_LIMIT * machine.valve.volts_to_full!r} V"}
    for knob in GAINS:
        table, _, key = knob.paths[0].rpartition(".")
        (neutral.setdefault(table, {}) if table else neutral)[key] = knob.text(knob.neutral)
    for name, joint in machine.joints.items():
        if joint.gains is None:
            machine = changed(machine, f"joint.{name}.gains", PaperGainsPart.model_validate(neutral))
    return machine


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


AT_ONCE = (Stage(40, 8), Stage(50, 16), Stage(20, 32))
AT_ONCE_POPULATION = 32
PHASE, PHASE_POPULATION, ROUNDS = Stage(6, 16), 10, 5


def knobs_of(machine: Machine) -> list[Knob]:
    """The gains of all joints, joint by joint."""
    return [knob for name in machine.joints for knob in gain_knobs(name)]


def at_once(machine: Machine, generations: int | None) -> list[Part]:
    """All gains of all joints at the same time; of fewer generations every stage has its share."""
    usual = sum(stage.generations for stage in AT_ONCE)
    wanted = usual if generations is None else generations
    ends = [ceil(wanted * sum(s.generations for s in AT_ONCE[: i + 1]) / usual) for i in range(len(AT_ONCE))]
    stages = tuple(Stage(end - begin, stage.runs) for stage, begin, end in zip(AT_ONCE, [0, *ends], ends, strict=False))
    return [Part("all gains", tuple(range(len(knobs_of(machine)))), AT_ONCE_POPULATION, stages)]


def by_phases(machine: Machine, generations: int | None) -> list[Part]:
    """One joint at a time, one phase of its moves after the other, from far to close; then again, joint by joint.

    Source: the paper, section 3. It does not say how often one goes round: once is not enough, since while one joint is
    looked at for the first time the other does not settle at all.
    """
    phases = [(joint, places) for joint in range(len(machine.joints)) for places in PHASES.items()]
    a_round, own, names = PHASE.generations * len(phases), len(gain_knobs("")), list(machine.joints)
    wanted = ROUNDS * a_round if generations is None else generations
    return [
        Part(
            f"round {number // len(phases) + 1}, {names[joint]} joint, {phase}",
            tuple(own * joint + place for place in places),
            PHASE_POPULATION,
            (Stage(min(PHASE.generations, wanted - number * PHASE.generations), PHASE.runs),),
        )
        for number, (joint, (phase, places)) in zip(
            range(ceil(wanted / PHASE.generations)), cycle(phases), strict=False
        )
    ]


METHODS: dict[str, Callable[[Machine, int | None], list[Part]]] = {"global": at_once, "phases": by_phases}
"""Parts of a search by the method's name, from a machine and, where given, the generations in all."""


def parts(machine: Machine, method: str, generations: int | None = None) -> list[Part]:
    """What is looked for, in order (InputError: no such method, or generations that make no sense)."""
    if method not in METHODS:
        raise InputError(f"unknown method {method!r}", where="--method", right=f"give {' or '.join(METHODS)}")
    if generations is not None and not 1 <= generations < GENERATIONS:
        right = f"give 1 to {GENERATIONS - 1}"
        raise InputError(f"{generations} is out of range", where="--generations", right=right)
    return METHODS[method](machine, generations)
