"""Ways to look for gains: all at once, or phase by phase as the paper does."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import cycle
from math import ceil

from layflat.errors import InputError
from layflat.machine import Machine
from layflat.tune.knobs import PHASES, Knob, gain_knobs

GENERATIONS = 10_000
"""At most; each has a seed of its own."""


@dataclass(frozen=True)
class Stage:
    """So many generations, of candidates that are each judged by so many runs (a power of two)."""

    generations: int
    runs: int


@dataclass(frozen=True)
class Part:
    """What is looked for at a time.

    Args:
        name: for people.
        knobs: places, among all knobs, of those that are turned; the others stay as they are.
        population: candidates of a generation.
        stages: few runs first, more later.
    """

    name: str
    knobs: tuple[int, ...]
    population: int
    stages: tuple[Stage, ...]


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
    """What is looked for, in order.

    Raises:
        InputError: no such method, or generations that make no sense.
    """
    if method not in METHODS:
        raise InputError(f"unknown method {method!r}", where="--method", right=f"give {' or '.join(METHODS)}")
    if generations is not None and not 1 <= generations < GENERATIONS:
        right = f"give 1 to {GENERATIONS - 1}"
        raise InputError(f"{generations} is out of range", where="--generations", right=right)
    return METHODS[method](machine, generations)
