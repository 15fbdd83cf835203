"""What a search may turn: values of a machine with their ranges."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from layflat.control.paper import PaperGainsPart
from layflat.description.change import changed, value_at
from layflat.errors import MachineError
from layflat.machine import Machine

Array = NDArray[np.float64]

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

INTEGRAL_LIMIT = 0.4
"""Of a joint without gains: share of full opening."""


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
        MachineError: it has no controller.
    """
    if machine.valve is None or machine.controller is None:
        right = "add the parts `valve` and `controller`; `layflat show paper-arm` has both"
        raise MachineError("has no controller to be tuned", where=machine.origin, right=right)
    neutral: dict[str, Any] = {"integral_limit": f"{INTEGRAL_LIMIT * machine.valve.volts_to_full!r} V"}
    for knob in GAINS:
        table, _, key = knob.paths[0].rpartition(".")
        (neutral.setdefault(table, {}) if table else neutral)[key] = knob.text(knob.neutral)
    for name, joint in machine.joints.items():
        if joint.gains is None:
            machine = changed(machine, f"joint.{name}.gains", PaperGainsPart.model_validate(neutral))
    return machine
