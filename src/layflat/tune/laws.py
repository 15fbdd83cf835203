"""Control laws that can be tuned, by name, with their knobs, search methods and conditions.

The gains of the paper's law are tuned all at once, or phase by phase as in the paper; the settings of the tracking law
are tuned on plants that differ from its model of them.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from itertools import cycle
from math import ceil
from typing import Any

import numpy as np

from layflat.control.paper import PaperGainsPart
from layflat.control.tracking import MAX_BANDWIDTH, TrackingControllerPart
from layflat.description.change import changed, value_at
from layflat.errors import MachineError
from layflat.machine import Machine
from layflat.tune.conditions import (
    RUNS_PER_NOMINAL,
    TIP_MEASURE,
    ConditionRanges,
    Conditions,
    assign_sequences,
    sample_conditions,
    sequence_scenarios,
)
from layflat.tune.knobs import PER_BAR, PER_DEG, Knob, Method, SearchPart, SearchStage, TunableLaw, split_generations
from layflat.tune.robust import ROBUST_SET_TEXT, robust_plant_groups

GAIN_KNOBS = (
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

PHASE_GAINS = {"far": (0, 1), "near": (2, 3, 4, 5), "close": (6, 7, 8, 9, 10)}
"""Indices in `GAIN_KNOBS` of the gains of each phase of a move, with the threshold below which the phase holds."""

INTEGRAL_LIMIT = 0.4  # of a joint without gains, as a fraction of full opening


def joint_gain_knobs(joint: str) -> list[Knob]:
    """Return the knobs of one joint's gains, phase by phase."""
    return [replace(knob, paths=tuple(f"joint.{joint}.gains.{path}" for path in knob.paths)) for knob in GAIN_KNOBS]


def all_gain_knobs(machine: Machine) -> list[Knob]:
    """Return the knobs of all joints' gains, joint by joint."""
    return [knob for name in machine.joints for knob in joint_gain_knobs(name)]


def with_neutral_gains(machine: Machine) -> Machine:
    """Return a copy in which joints without gains have the neutral gains of `GAIN_KNOBS`, with an integral limit.

    The limit is `INTEGRAL_LIMIT` of full opening.
    """
    limit = f"{INTEGRAL_LIMIT * value_at(machine, 'valve.volts_to_full')!r} V"
    neutral: dict[str, Any] = {"integral_limit": limit}
    for knob in GAIN_KNOBS:
        table, _, key = knob.paths[0].rpartition(".")
        (neutral.setdefault(table, {}) if table else neutral)[key] = knob.text(knob.neutral)
    for name, joint in machine.joints.items():
        if joint.gains is None:
            machine = changed(machine, f"joint.{name}.gains", PaperGainsPart.model_validate(neutral))
    return machine


def integral_limits(machine: Machine) -> Mapping[str, tuple[str, str]]:
    """Return value and reason of the integral's limit, by path, for joints without gains."""
    limit = f"{INTEGRAL_LIMIT * value_at(machine, 'valve.volts_to_full'):g} V"
    return {
        f"joint.{name}.gains.integral_limit": (limit, f"{100 * INTEGRAL_LIMIT:g} % of full opening")
        for name, joint in machine.joints.items()
        if joint.gains is None
    }


GLOBAL_STAGES = (SearchStage(40, 8), SearchStage(50, 16), SearchStage(20, 32))
GLOBAL_POPULATION = 32
PHASE_STAGE, PHASE_POPULATION, PHASE_ROUNDS = SearchStage(6, 16), 10, 5


def search_all_knobs(
    name: str, knobs: Callable[[Machine], list[Knob]], population: int, stages: Sequence[SearchStage]
) -> Method:
    """Return the method that varies all knobs of all joints at the same time.

    Args:
        name: name of the part.
        knobs: function from a machine to its knobs.
        population: candidates per generation.
        stages: stages of the search.
    """
    return lambda machine, generations: [
        SearchPart(name, tuple(range(len(knobs(machine)))), population, split_generations(stages, generations))
    ]


def search_by_phases(machine: Machine, generations: int | None) -> list[SearchPart]:
    """Return the parts of the paper's method: joint by joint, phase by phase from far to close, in several rounds.

    Source: the paper, section 3. It does not give the number of rounds: one is not enough, since the other joint does
    not settle at all while the first one is tuned. The last part may have fewer generations than the others.
    """
    phases = [(joint, gains) for joint in range(len(machine.joints)) for gains in PHASE_GAINS.items()]
    per_round, per_joint, names = PHASE_STAGE.generations * len(phases), len(GAIN_KNOBS), list(machine.joints)
    total = PHASE_ROUNDS * per_round if generations is None else generations
    return [
        SearchPart(
            f"round {number // len(phases) + 1}, {names[joint]} joint, {phase}",
            tuple(per_joint * joint + gain for gain in gains),
            PHASE_POPULATION,
            (SearchStage(min(PHASE_STAGE.generations, total - number * PHASE_STAGE.generations), PHASE_STAGE.runs),),
        )
        for number, (joint, (phase, gains)) in zip(
            range(ceil(total / PHASE_STAGE.generations)), cycle(phases), strict=False
        )
    ]


def describe_paper_conditions(by: Conditions, machine: Machine) -> str:  # noqa: ARG001  (signature of `TunableLaw.spread`)
    """Return the ranges of the conditions in words."""
    payload = by.vary["arm.payload"].max()
    return (
        f"payload up to {payload:.3g} kg, supply ±10 %, losses of hoses and straps ±30 %, "
        "centres of the valves off by up to 0.1 V, other noise"
    )


PAPER_TUNING = TunableLaw(
    "gains",
    with_neutral_gains,
    all_gain_knobs,
    {
        "global": search_all_knobs("all gains", all_gain_knobs, GLOBAL_POPULATION, GLOBAL_STAGES),
        "phases": search_by_phases,
    },
    sample_conditions,
    describe_paper_conditions,
    clouds=True,
    complete=integral_limits,
)


SETTING_RANGES = {
    "torque_errors": (0.004, 0.2),
    "observer_gain": (0.2, 1.0),
    "angle_errors": (0.7, 8.0),
    "valve_fraction": (0.2, 1.0),
    "reserve": (0.05, 0.6),
    "load_std": (0.005, 0.1),
    "load_drift": (0.01, 1.0),
    "friction_std": (0.05, 0.6),
}
"""Ranges of the tuned settings; the others define the required behaviour."""

MIN_BANDWIDTH_FRACTION = 0.25  # of the greatest bandwidth that a control cycle allows

SETTING_STAGES = (SearchStage(15, 32), SearchStage(15, 64), SearchStage(10, 128))
SETTING_POPULATION = 16
PAYLOAD_DEVIATIONS = 2.0  # range of an unknown payload either way, in its standard deviations


def setting_knobs(machine: Machine) -> list[Knob]:
    """Return the knobs of the settings; their neutral values are the defaults of a description."""
    defaults = {name: field.default for name, field in TrackingControllerPart.model_fields.items()}
    highest = MAX_BANDWIDTH / machine.cycle
    bandwidth = Knob(
        ("controller.bandwidth",),
        MIN_BANDWIDTH_FRACTION * highest,
        highest,
        "1/s",
        neutral=min(defaults["bandwidth"], highest),
    )
    others = [Knob((f"controller.{name}",), *ends, neutral=defaults[name]) for name, ends in SETTING_RANGES.items()]
    return [bandwidth, *others]


def sample_robust_conditions(machine: Machine, runs: int, spread: ConditionRanges | None, seed: int) -> Conditions:
    """Return conditions with plants of the robust set, and varied payload if the controller does not know it.

    Args:
        machine: nominal plant, and model of the controller.
        runs: number of runs, of which the first are nominal.
        spread: ranges, of which only the window is used; default: that of `ConditionRanges`.
        seed: seed of the plants.
    """
    window, nominal = (spread or ConditionRanges()).window, max(1, runs // RUNS_PER_NOMINAL)
    groups, draw = robust_plant_groups(machine, runs - nominal, seed=seed), np.random.default_rng(seed)
    counts = [len(group.vary["valve.delay"]) for group in groups]
    nominal_values = {
        path: machine.supply.pressure_gauge if path == "scenario.supply" else value_at(groups[0].machine, path)
        for path in groups[0].vary
    }
    vary = {
        path: np.concatenate([np.full(nominal, value), *(group.vary[path] for group in groups)])
        for path, value in nominal_values.items()
    }
    deviation = PAYLOAD_DEVIATIONS * value_at(machine, "controller.payload_std")
    if deviation > 0.0:
        payload = machine.arm.payload + deviation * draw.uniform(-1.0, 1.0, runs)
        payload[:nominal] = machine.arm.payload
        vary["scenario.payload"] = np.maximum(payload, 0.0)
    scenarios = sequence_scenarios(machine, window)
    vary |= assign_sequences(len(scenarios), runs, nominal, seed)
    which = np.repeat(np.arange(len(groups), dtype=np.int64), [counts[0] + nominal, *counts[1:]])
    return Conditions(scenarios, vary, nominal, window, TIP_MEASURE, tuple(group.machine for group in groups), which)


def describe_robust_conditions(by: Conditions, machine: Machine) -> str:
    """Return the ranges of the conditions in words."""
    payload = by.vary.get("scenario.payload")
    if payload is None:
        return f"{ROBUST_SET_TEXT}; {machine.arm.payload:g} kg, known; none of the rest known to the controller"
    return f"{ROBUST_SET_TEXT}; {payload.min():.2g} to {payload.max():.2g} kg; none of it known to the controller"


TRACKING_TUNING = TunableLaw(
    "settings",
    lambda machine: machine,
    setting_knobs,
    {"global": search_all_knobs("all settings", setting_knobs, SETTING_POPULATION, SETTING_STAGES)},
    sample_robust_conditions,
    describe_robust_conditions,
)


TUNABLE_LAWS = {"paper": PAPER_TUNING, "tracking": TRACKING_TUNING}


def tunable_law(machine: Machine) -> TunableLaw:
    """Return the tuning of a machine's control law.

    Raises:
        MachineError: the machine has no controller, or one that can't be tuned.
    """
    if machine.valve is None or machine.controller is None:
        right = "add the parts `valve` and `controller`; `layflat machine show paper-arm` has both"
        raise MachineError("has no controller to be tuned", where=machine.origin, right=right)
    name = machine.control_law.name
    if name not in TUNABLE_LAWS:
        raise MachineError(
            f"control law {name!r} can't be tuned",
            where=f"{machine.origin}: controller.kind",
            right=f"give one of {', '.join(TUNABLE_LAWS)}",
        )
    return TUNABLE_LAWS[name]
