"""Ways to look for gains: all at once, or phase by phase as the paper does."""

from __future__ import annotations

from collections.abc import Callable
from math import ceil

from layflat.errors import InputError
from layflat.machine import Machine
from layflat.tune.knobs import PHASES, Knob, gain_knobs
from layflat.tune.search import GENERATIONS, Part, Stage

AT_ONCE = (Stage(40, 8), Stage(50, 16), Stage(20, 32))
AT_ONCE_POPULATION = 32
PHASE, PHASE_POPULATION = Stage(20, 16), 16


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
    """One joint at a time, one phase of its moves after the other, from far to close. Source: the paper, section 3."""
    phases = [(joint, phase) for joint in machine.joints for phase in PHASES]
    wanted = PHASE.generations * len(phases) if generations is None else generations
    if wanted < len(phases):
        right = f"give {len(phases)} or more: one for each of three phases of {len(phases) // 3} joint(s)"
        raise InputError(f"{wanted} is too few", where="--generations", right=right)
    each, more = divmod(wanted, len(phases))
    own = len(gain_knobs(""))
    return [
        Part(
            f"{joint} joint, phase {phase}",
            tuple(own * (i // len(PHASES)) + place for place in PHASES[phase]),
            PHASE_POPULATION,
            (Stage(each + (i < more), PHASE.runs),),
        )
        for i, (joint, phase) in enumerate(phases)
    ]


METHODS: dict[str, Callable[[Machine, int | None], list[Part]]] = {"global": at_once, "phases": by_phases}
"""Parts of a search by the method's name, from a machine and, where given, the generations in all."""


def parts(machine: Machine, method: str, generations: int | None = None) -> list[Part]:
    """What is looked for, in order.

    Raises:
        InputError: no such method, or generations that make no sense.
    """
    if method not in METHODS:
        raise InputError(f"{method!r} is no method", where="--method", right=f"give {' or '.join(METHODS)}")
    if generations is not None and not 1 <= generations < GENERATIONS:
        right = f"give 1 to {GENERATIONS - 1}"
        raise InputError(f"{generations} is out of range", where="--generations", right=right)
    return METHODS[method](machine, generations)
