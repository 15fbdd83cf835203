"""The paper's law: gains of its phases, tuned all at once or as in the paper."""

from collections.abc import Mapping
from dataclasses import replace
from itertools import cycle
from math import ceil
from typing import Any

from layflat.control.paper import PaperGainsPart
from layflat.description.change import changed, value_at
from layflat.machine import Machine
from layflat.tune.conditions import Conditions, Spread, conditions
from layflat.tune.knobs import PER_BAR, PER_DEG, Knob, Part, Stage, Tunable, split

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


def knobs_of(machine: Machine) -> list[Knob]:
    """Return the gains of all joints, joint by joint."""
    return [knob for name in machine.joints for knob in gain_knobs(name)]


def with_gains(machine: Machine) -> Machine:
    """Return the machine with neutral gains in those of its joints that have none."""
    limit = f"{INTEGRAL_LIMIT * value_at(machine, 'valve.volts_to_full')!r} V"
    neutral: dict[str, Any] = {"integral_limit": limit}
    for knob in GAINS:
        table, _, key = knob.paths[0].rpartition(".")
        (neutral.setdefault(table, {}) if table else neutral)[key] = knob.text(knob.neutral)
    for name, joint in machine.joints.items():
        if joint.gains is None:
            machine = changed(machine, f"joint.{name}.gains", PaperGainsPart.model_validate(neutral))
    return machine


def integral_limits(machine: Machine) -> Mapping[str, tuple[str, str]]:
    """Return the integral's limit, and why, of those joints that have no gains."""
    limit = f"{INTEGRAL_LIMIT * value_at(machine, 'valve.volts_to_full'):g} V"
    return {
        f"joint.{name}.gains.integral_limit": (limit, f"{100 * INTEGRAL_LIMIT:g} % of full opening")
        for name, joint in machine.joints.items()
        if joint.gains is None
    }


AT_ONCE = (Stage(40, 8), Stage(50, 16), Stage(20, 32))
AT_ONCE_POPULATION = 32
PHASE, PHASE_POPULATION, ROUNDS = Stage(6, 16), 10, 5


def at_once(machine: Machine, generations: int | None) -> list[Part]:
    """All gains of all joints at the same time."""
    return [Part("all gains", tuple(range(len(knobs_of(machine)))), AT_ONCE_POPULATION, split(AT_ONCE, generations))]


def by_phases(machine: Machine, generations: int | None) -> list[Part]:
    """One joint at a time, one phase of its moves after the other, from far to close; then again, joint by joint.

    Source: the paper, section 3. It does not say how often one goes round: once is not enough, since while one joint is
    looked at for the first time the other does not settle at all.
    """
    phases = [(joint, places) for joint in range(len(machine.joints)) for places in PHASES.items()]
    a_round, own, names = PHASE.generations * len(phases), len(GAINS), list(machine.joints)
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


def spread_of(by: Conditions, machine: Machine) -> str:  # noqa: ARG001  (as of all laws)
    """Return in words how conditions differ from run to run."""
    most = by.vary["arm.payload"].max()
    return (
        f"payload up to {most:.3g} kg, supply ±10 %, losses of hoses and straps ±30 %, centres of the valves off by up "
        "to 0.1 V, other noise"
    )


def _conditions(machine: Machine, runs: int, spread: Spread | None, seed: int) -> Conditions:
    return conditions(machine, runs, spread, seed)


TUNABLE = Tunable(
    "gains",
    with_gains,
    knobs_of,
    {"global": at_once, "phases": by_phases},
    _conditions,
    spread_of,
    clouds=True,
    complete=integral_limits,
)
