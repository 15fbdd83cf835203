"""The tracking law: its settings, tuned on plants that differ from what it believes of them."""

import numpy as np

from layflat.control.tracking.description import QUICKEST, TrackingControllerPart
from layflat.description.change import value_at
from layflat.machine import Machine
from layflat.tune.conditions import NOMINAL, TIP, Conditions, Spread, sequences
from layflat.tune.knobs import Knob, Part, Stage, Tunable, split
from layflat.tune.robust import STATEMENT, robust_set

RANGES = {
    "torque_errors": (0.004, 0.2),
    "pressure_trust": (0.2, 1.0),
    "angle_errors": (0.7, 8.0),
    "valve_share": (0.2, 1.0),
    "reserve": (0.05, 0.6),
    "load_spread": (0.005, 0.1),
    "load_wander": (0.01, 1.0),
    "friction_spread": (0.05, 0.6),
}
"""Ranges of the settings that say what the law trusts, and what it spares; others say what is wanted of it."""

SLOWEST = 0.25  # bandwidth over the greatest that a control cycle allows

STAGES = (Stage(15, 32), Stage(15, 64), Stage(10, 128))
POPULATION = 16
UNKNOWN = 2.0  # standard deviations by which a payload that is not known may be off


def knobs_of(machine: Machine) -> list[Knob]:
    """Return the settings; neutral are those of a description that says nothing of them."""
    usual = {name: field.default for name, field in TrackingControllerPart.model_fields.items()}
    most = QUICKEST / machine.cycle
    bandwidth = Knob(("controller.bandwidth",), SLOWEST * most, most, "1/s", neutral=min(usual["bandwidth"], most))
    others = [Knob((f"controller.{name}",), *ends, neutral=usual[name]) for name, ends in RANGES.items()]
    return [bandwidth, *others]


def at_once(machine: Machine, generations: int | None) -> list[Part]:
    """All settings at the same time."""
    return [Part("all settings", tuple(range(len(knobs_of(machine)))), POPULATION, split(STAGES, generations))]


def conditions(machine: Machine, runs: int, spread: Spread | None, seed: int) -> Conditions:
    """Return runs on plants of the robust set; the first are nominal. A payload that is not known differs, too."""
    window, nominal = (spread or Spread()).window, max(1, runs // NOMINAL)
    groups, draw = robust_set(machine, runs - nominal, seed=seed), np.random.default_rng(seed)
    counts = [len(of.vary["valve.delay"]) for of in groups]
    usual = {
        path: machine.supply.pressure_gauge if path == "scenario.supply" else value_at(groups[0].machine, path)
        for path in groups[0].vary
    }
    vary = {path: np.concatenate([np.full(nominal, usual[path]), *(of.vary[path] for of in groups)]) for path in usual}
    off = UNKNOWN * value_at(machine, "controller.payload_spread")
    if off > 0.0:
        payload = machine.arm.payload + off * draw.uniform(-1.0, 1.0, runs)
        payload[:nominal] = machine.arm.payload
        vary["scenario.payload"] = np.maximum(payload, 0.0)
    scenarios = sequences(machine, window)
    moved = np.arange(runs) % len(scenarios)
    moved[:nominal] = 0
    vary |= {"seed": seed + np.arange(runs, dtype=float), "scenario": moved.astype(float)}
    which = np.repeat(np.arange(len(groups), dtype=np.int64), [counts[0] + nominal, *counts[1:]])
    return Conditions(scenarios, vary, nominal, window, TIP, tuple(of.machine for of in groups), which)


def spread_of(by: Conditions, machine: Machine) -> str:
    """Return in words how conditions differ from run to run."""
    payload = by.vary.get("scenario.payload")
    if payload is None:
        return f"{STATEMENT}; {machine.arm.payload:g} kg, known; none of the rest known to the controller"
    return f"{STATEMENT}; {payload.min():.2g} to {payload.max():.2g} kg; none of it known to the controller"


TUNABLE = Tunable("settings", lambda machine: machine, knobs_of, {"global": at_once}, conditions, spread_of)
