"""What a search may turn: values of a machine with their ranges."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
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
    """One value to be found: the paths that share it, its range in a unit, and that unit in SI."""

    paths: tuple[str, ...]
    low: float
    high: float
    unit: str = ""
    si: float = 1.0

    def text(self, value: float) -> str | float:
        """The value as it is written in a description."""
        number = float(f"{value:.3g}")
        return f"{number:g} {self.unit}" if self.unit else number


@dataclass(frozen=True)
class _Gain:
    """A gain of one joint: where it stands, its range, and where a search begins that knows nothing."""

    path: str
    low: float
    high: float
    neutral: float
    unit: str
    si: float


_GAINS = (
    _Gain("far.error", 0.03, 1.0, 0.3, "V/deg", PER_DEG),
    _Gain("far.pressure", 0.3, 10.0, 2.0, "V/bar", PER_BAR),
    _Gain("near.error", 0.1, 4.0, 0.5, "V/deg", PER_DEG),
    _Gain("near.pressure", 0.3, 10.0, 1.0, "V/bar", PER_BAR),
    _Gain("near_below.error", 4.0, 40.0, 15.0, "deg", 1 / PER_DEG),
    _Gain("near_below.speed", 10.0, 200.0, 60.0, "deg/s", 1 / PER_DEG),
    _Gain("close.error", 0.3, 8.0, 1.0, "V/deg", PER_DEG),
    _Gain("close.pressure", 0.1, 10.0, 0.5, "V/bar", PER_BAR),
    _Gain("close_below.error", 0.5, 6.0, 2.0, "deg", 1 / PER_DEG),
    _Gain("close_below.speed", 1.0, 40.0, 10.0, "deg/s", 1 / PER_DEG),
    _Gain("integral", 0.2, 40.0, 2.0, "V/(deg s)", PER_DEG),
)

PHASES = {"far": (0, 1), "near": (2, 3, 4, 5), "close": (6, 7, 8, 9, 10)}
"""Which of a joint's gains each phase of a move has, the threshold below which it holds included."""

INTEGRAL_LIMIT = 0.4
"""Of a joint without gains: share of full opening."""


def gain_knobs(joint: str) -> list[Knob]:
    """The gains of one joint, phase by phase."""
    return [Knob((f"joint.{joint}.gains.{g.path}",), g.low, g.high, g.unit, g.si) for g in _GAINS]


def neutral_gains(joints: int) -> Array:
    """Gains to begin with, of so many joints, in the knobs' units."""
    return np.tile([g.neutral for g in _GAINS], joints)


def values_of(machine: Machine, knobs: Sequence[Knob]) -> Array:
    """The values that a machine has now, in the knobs' units."""
    return np.array([value_at(machine, knob.paths[0]) / knob.si for knob in knobs])


def rounded(values: Array) -> Array:
    """Values to the three digits with which they are written."""
    digits: Array = np.vectorize(lambda value: float(f"{value:.3g}"), otypes=[float])(values)
    return digits


def to_shares(knobs: Sequence[Knob], values: Array) -> Array:
    """Where values lie in the knobs' ranges, 0 to 1, counted in factors: a gain is looked for by its size."""
    low, high = _ends(knobs)
    shares: Array = np.log(np.clip(values, low, high) / low) / np.log(high / low)
    return shares


def from_shares(knobs: Sequence[Knob], shares: Array) -> Array:
    """Values from where they lie in the knobs' ranges."""
    low, high = _ends(knobs)
    values: Array = low * (high / low) ** shares
    return values


def _ends(knobs: Sequence[Knob]) -> tuple[Array, Array]:
    return np.array([knob.low for knob in knobs]), np.array([knob.high for knob in knobs])


def with_gains(machine: Machine) -> Machine:
    """The machine with neutral gains in those of its joints that have none.

    Raises:
        MachineError: it has no controller.
    """
    if machine.valve is None or machine.controller is None:
        right = "add the parts `valve` and `controller`; `layflat show paper-arm` has both"
        raise MachineError("has no controller to be tuned", where=machine.origin, right=right)
    neutral: dict[str, Any] = {"integral_limit": f"{INTEGRAL_LIMIT * machine.valve.volts_to_full!r} V"}
    for gain in _GAINS:
        table, _, key = gain.path.rpartition(".")
        (neutral.setdefault(table, {}) if table else neutral)[key] = f"{gain.neutral:g} {gain.unit}"
    for name, joint in machine.joints.items():
        if joint.gains is None:
            machine = changed(machine, f"joint.{name}.gains", PaperGainsPart.model_validate(neutral))
    return machine
