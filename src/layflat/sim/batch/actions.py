"""Kinds of action: what a batch is given in every control cycle, and how it acts."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np

from layflat.arrays import Array
from layflat.description.wrong import shown
from layflat.errors import InputError
from layflat.machine import Machine
from layflat.motion.scenario import MAX_PRESSURE, SIGNALS

FULL_OPENING_ERROR = 1e5  # error of a differential pressure at which its regulator opens the valve fully, Pa


@dataclass(frozen=True, kw_only=True)
class ActionKind:
    """Kind of action: its unit and range."""

    signal: str  # by which it acts, of `JointSignals`
    of_valve: Callable[[Array, Array, Array], Array] | None = None
    """Function from actions, centre voltages and half spans of the valves (V) to the signal; None: it is the action."""
    unit: str
    meaning: str
    limits: Callable[[Machine], tuple[Array, Array]]
    """Function from a machine to the least and the greatest value of every joint, (joints,), SI."""
    demands: bool = False  # whether the machine's control law follows it
    regulates: bool = False  # whether it is a pressure that a regulator of the batch follows

    def check(self, values: Array, limits: tuple[Array, Array], joints: tuple[str, ...], *, clip: bool) -> Array:
        """Return actions inside their range.

        Args:
            values: (arms, joints), in the unit of the kind.
            limits: least and greatest value of every joint, (joints,).
            joints: names of the joints.
            clip: whether values outside are replaced by the nearest ones inside.

        Raises:
            InputError: naming arm and joint: a value is not finite, or outside.
        """
        low, high = limits
        inside = (values >= low) & (values <= high)
        if inside.all():
            return values
        finite = np.isfinite(values)
        if clip and finite.all():
            return np.clip(values, low, high)
        arm, j = np.argwhere(~(inside if finite.all() else finite))[0]
        unit = "" if self.unit == "1" else f" {self.unit}"
        wrong = "out of range" if finite[arm, j] else "no number"
        right = f"give {low[j]:.6g} to {high[j]:.6g}{unit}" + (", or clip=True" if finite[arm, j] else "")
        what = f"{values[arm, j]:.6g}{unit} of arm {arm}, joint {joints[j]!r}, is {wrong}"
        raise InputError(what, where="action", right=right)


def _demand_limits(machine: Machine) -> tuple[Array, Array]:
    half = np.array([joint.stops.working_stroke / 2.0 for joint in machine.joints.values()])
    return -half, half


def _signal_limits(name: str) -> Callable[[Machine], tuple[Array, Array]]:
    """Return the function from a machine to the range of a signal of the table in motion/scenario.py."""

    def limits(machine: Machine) -> tuple[Array, Array]:
        row = SIGNALS[name].range
        of_signal = row(machine) if callable(row) else row
        assert of_signal is not None  # openings and voltages have one
        size = len(machine.joints)
        return np.full(size, of_signal.lower), np.full(size, of_signal.upper)

    return limits


def _pressure_limits(machine: Machine) -> tuple[Array, Array]:
    size = len(machine.joints)
    return np.full(size, -MAX_PRESSURE), np.full(size, MAX_PRESSURE)


ACTION_KINDS: Mapping[str, ActionKind] = MappingProxyType({
    "opening": ActionKind(
        signal="opening", unit="1", meaning="opening of the valve, -1 to 1", limits=_signal_limits("opening")
    ),
    "voltage": ActionKind(
        signal="opening", of_valve=lambda voltages, centre, span: (voltages - centre) / span,
        unit="V", meaning="control voltage", limits=_signal_limits("voltage"),
    ),
    "demand": ActionKind(signal="demand", unit="rad", meaning="demanded angle", limits=_demand_limits, demands=True),
    "pressure": ActionKind(
        signal="voltage", of_valve=lambda pressures, centre, span: centre + span / FULL_OPENING_ERROR * pressures,
        unit="Pa", meaning="demanded differential pressure, hose A less hose B",
        limits=_pressure_limits,
        regulates=True,
    ),
})  # fmt: skip
"""Kinds of action by name."""


def find_action(name: str) -> ActionKind:
    """Return a kind of action by name.

    Raises:
        InputError: there is no such kind.
    """
    if not isinstance(name, str) or name not in ACTION_KINDS:
        right = f"use {', '.join(ACTION_KINDS)}"
        raise InputError(f"{shown(name)} is no kind of action", where="action", right=right)
    return ACTION_KINDS[name]
