"""What a search may turn: values of a machine with their ranges."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from layflat.machine import Machine
from layflat.machine.change import value_at

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
    _Gain("far.error", 0.1, 1.0, 0.3, "V/deg", PER_DEG),
    _Gain("near.error", 0.1, 2.0, 0.5, "V/deg", PER_DEG),
    _Gain("close.error", 0.1, 4.0, 1.0, "V/deg", PER_DEG),
    _Gain("far.pressure", 0.0, 6.0, 2.0, "V/bar", PER_BAR),
    _Gain("near.pressure", 0.0, 6.0, 1.0, "V/bar", PER_BAR),
    _Gain("close.pressure", 0.0, 4.0, 0.5, "V/bar", PER_BAR),
    _Gain("near_below.error", 5.0, 30.0, 15.0, "deg", 1 / PER_DEG),
    _Gain("near_below.speed", 10.0, 150.0, 60.0, "deg/s", 1 / PER_DEG),
    _Gain("close_below.error", 0.3, 4.0, 2.0, "deg", 1 / PER_DEG),
    _Gain("close_below.speed", 2.0, 30.0, 10.0, "deg/s", 1 / PER_DEG),
    _Gain("integral", 0.0, 20.0, 2.0, "V/(deg s)", PER_DEG),
)


def gain_knobs(joint: str) -> list[Knob]:
    """The gains of one joint."""
    return [Knob((f"joint.{joint}.gains.{g.path}",), g.low, g.high, g.unit, g.si) for g in _GAINS]


def neutral_gains(joints: int) -> Array:
    """Gains to begin with, of so many joints, in the knobs' units."""
    return np.tile([g.neutral for g in _GAINS], joints)


def values_of(machine: Machine, knobs: Sequence[Knob]) -> Array:
    """The values that a machine has now, in the knobs' units."""
    return np.array([value_at(machine, knob.paths[0]) / knob.si for knob in knobs])
