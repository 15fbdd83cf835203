"""Unknowns of the calibration: values that the paper leaves open, their ranges, and the reasons for these.

The paper says how its controller was tuned (section 3): from phase to phase the gain of the error rises, markedly so
in the third, and that of the pressure falls, possibly to zero. So a gain is a multiple of that in the phase before.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from layflat.arrays import Array
from layflat.description.change import value_at
from layflat.identify.benches.hysteresis import round_weights as rounded_weights
from layflat.identify.benches.hysteresis import split_from_weights, weights_from_split
from layflat.machine import Machine
from layflat.tune.knobs import PER_BAR, PER_DEG, round_values

DEG = 1.0 / PER_DEG
JOINT_NAMES = ("large", "small")


@dataclass(frozen=True)
class Unknown:
    """Unknown value: its range in a unit, that unit in SI, and the reason for the range."""

    name: str
    low: float
    high: float
    why: str
    unit: str = ""
    si: float = 1.0
    # Paths of the values that it sets; with a machine's name and a slash before, those of that machine alone.
    paths: tuple[str, ...] = ()
    times: str = ""  # name of another unknown, of which the value is a multiple; empty: of none
    factors: tuple[float, ...] = ()  # of the value at each path; empty: 1


FADES = "from an effect within some seconds to that of the error's gain"
PHASES = "section 3: it rises from phase to phase"
PHASES_PRESSURE = "section 3: it falls from phase to phase"


def gains(joint: str) -> tuple[Unknown, ...]:
    """Return the unknown gains of a joint's controller."""

    def one(key: str, low: float, high: float, why: str, unit: str = "", si: float = 1.0, times: str = "") -> Unknown:
        over = f"{joint} {times}" if times else ""
        return Unknown(f"{joint} {key}", low, high, why, unit, si, (f"joint.{joint}.gains.{key}",), over)

    opens = "an error of 40 deg opens the valve by a tenth, or far beyond all of it"
    return (
        one("far.error", 0.01, 1.0, opens, "V/deg", PER_DEG),
        one("near.error", 1.0, 5.0, PHASES, times="far.error"),
        one("close.error", 1.2, 6.0, f"{PHASES}, markedly", times="near.error"),
        one("far.pressure", 0.25, 10.0, "high: 4 bar move it by a fifth, or far beyond its end", "V/bar", PER_BAR),
        one("near.pressure", 0.1, 1.0, PHASES_PRESSURE, times="far.pressure"),
        one("close.pressure", 0.02, 1.0, f"{PHASES_PRESSURE}, possibly to zero", times="near.pressure"),
        one("near_below.error", 3.0, 40.0, "at most the step of 40 deg", "deg", DEG),
        one("near_below.speed", 1.0, 200.0, "moderately low, from a count on", "deg/s", DEG),
        one("close_below.error", 0.4, 6.0, "almost settled", "deg", DEG),
        one("close_below.speed", 1.0, 60.0, "almost settled; one count of the converter is 1.8 deg/s", "deg/s", DEG),
        one("integral", 0.3, 40.0, FADES, "V/(deg s)", PER_DEG),
    )


def losses(key: str, low: float, high: float, why: str, unit: str = "", si: float = 1.0) -> Unknown:
    """Return an unknown of the losses, the same for both joints and the earlier actuator."""
    return Unknown(
        f"losses {key}", low, high, why, unit, si, tuple(f"joint.{joint}.losses.{key}" for joint in JOINT_NAMES)
    )


TURNS = "from one that turns the small joint by 40 deg in 1.3 s to one of 1/4 in"
DITHER = "from the spool's friction to where the valve opens by a third either way"
LEAKS = "a spool with little lap leaks 0.2 to 5 % of what it lets through when open"
VOLUME = "from tubes and fittings alone to what a full stroke displaces"
C, AMPLITUDE = "valve.conductance", "valve.dither.amplitude"
AIR = (
    Unknown(C, 0.04, 2.5, TURNS, "dm^3/(s bar)", 1e-8, (C,)),
    Unknown("leakage", 0.002, 0.05, LEAKS, paths=("valve.leakage",), times=C),
    Unknown("small dead volume", 10.0, 120.0, VOLUME, "ml", 1e-6, ("joint.small.hose.dead_volume",)),
    Unknown("large dead volume", 30.0, 360.0, VOLUME, "ml", 1e-6, ("joint.large.hose.dead_volume",)),
    Unknown("large valve", 1.0, 5.0, "valves are alike, or follow the hoses", paths=("joint.large.valve_size",)),
    Unknown(AMPLITUDE, 0.05, 0.3, DITHER, paths=(AMPLITUDE,)),
)

DAMPING = losses("damping_time", 5e-4, 0.5, "from nothing to what a sweep of 20 s would show", "s")
WITHIN = "a small motion of 6 deg is opposed less (section 4.1)"
LOSSES: Mapping[str, tuple[Unknown, ...]] = {
    "elasto-slip": (
        losses("deflections.0", 0.1, 2.0, WITHIN, "deg", DEG),
        losses("deflections.1", 0.3, 10.0, WITHIN, "deg", DEG),
        losses("deflections.2", 2.0, 30.0, WITHIN, "deg", DEG),
        losses("split.0", 0.05, 0.6, "no element has nearly all"),
        losses("split.1", 0.1, 0.9, "no element has nearly all"),
    ),
    "elasto-slip-spectrum": (
        losses("first", 0.1, 2.0, WITHIN, "deg", DEG),
        losses("last", 2.5, 60.0, WITHIN, "deg", DEG),
        losses("slope", -1.5, 1.5, "no element has nearly all, neither the first nor the last"),
    ),
    "bouc-wen": (
        losses("deflection", 0.5, 20.0, WITHIN, "deg", DEG),
        losses("beta", 0.5, 3.0, "from straight to as steep on the way back as a file may say"),
        losses("exponent", 1.0, 2.0, "what the law allows"),
    ),
}
"""Unknowns of each kind of losses; `damping_time` is one of all of them."""

STARTS: Mapping[str, dict[str, Any]] = {
    "elasto-slip": {"deflections": ("0.3 deg", "2 deg", "12 deg"), "weights": (0.3, 0.3, 0.4)},
    "elasto-slip-spectrum": {"first": "0.3 deg", "last": "20 deg", "elements": 6},
    "bouc-wen": {"deflection": "3 deg"},
}
"""Initial description of each kind, whose numbers the unknowns replace."""


def to_values(unknowns: Sequence[Unknown], shares: Array) -> Array:
    """Return values in the unknowns' units from their positions in their ranges (shares), 0 to 1.

    The scale is logarithmic, in a range that reaches below zero linear.
    """
    low, high, linear = _ranges(unknowns)
    shares = np.clip(shares, 0.0, 1.0)
    by_factor = low * np.where(linear, 1.0, high / low) ** shares
    return np.where(linear, low + (high - low) * shares, by_factor)


def to_shares(unknowns: Sequence[Unknown], values: Array) -> Array:
    """Return the positions in their ranges (shares), 0 to 1, of values in the unknowns' units."""
    low, high, linear = _ranges(unknowns)
    values = np.clip(values, low, high)
    by_factor = np.log(np.where(linear, 1.0, values / low)) / np.log(np.where(linear, 2.0, high / low))
    return np.where(linear, (values - low) / (high - low), by_factor)


def _ranges(unknowns: Sequence[Unknown]) -> tuple[Array, Array, Array]:
    low, high = np.array([(one.low, one.high) for one in unknowns]).T
    return low, high, low <= 0.0


def by_path(unknowns: Sequence[Unknown], values: Array) -> dict[str, Any]:
    """Return the values (SI) by path, of one machine (unknowns,) or of many (machines, unknowns)."""
    found: dict[str, Any] = {}
    named: dict[str, Any] = {}
    for one, column in zip(unknowns, np.moveaxis(values, -1, 0), strict=True):
        named[one.name] = column * (named[one.times] if one.times else one.si)
        factors = one.factors or (1.0,) * len(one.paths)
        found |= {path: factor * named[one.name] for path, factor in zip(one.paths, factors, strict=True)}
    return _with_weights(found)


def _with_weights(found: dict[str, Any]) -> dict[str, Any]:
    """Return values with weights of elements in place of their splits of the loss."""
    plain = {path: value for path, value in found.items() if ".split." not in path}
    for losses in sorted({path.partition(".split.")[0] for path in found} - set(plain)):
        weights = weights_from_split(np.stack([found[f"{losses}.split.{i}"] for i in range(2)], axis=-1))
        if weights.ndim == 1:
            plain[f"{losses}.weights"] = rounded_weights(weights)
        else:
            plain |= {f"{losses}.weights.{i}": weights[:, i] for i in range(weights.shape[-1])}
    return plain


def values_in(machine: Machine, found: Mapping[str, Any]) -> dict[str, Any]:
    """Return the values whose paths a machine has: not those of other joints, or of another machine alone."""
    others = tuple(f"joint.{name}." for name in JOINT_NAMES if name not in machine.joint)
    own = {path.removeprefix(f"{machine.name}/"): value for path, value in found.items()}
    return {path: value for path, value in own.items() if "/" not in path and not (others and path.startswith(others))}


def values_of(machine: Machine, unknowns: Sequence[Unknown]) -> Array:
    """Return the values that a machine has now, in the unknowns' units."""
    named = {one.name: _present_value(machine, one.paths[0]) for one in unknowns}
    return np.array([named[one.name] / (named[one.times] if one.times else one.si) for one in unknowns])


def _present_value(machine: Machine, path: str) -> float:
    losses, _, place = path.rpartition("/")[2].partition(".split.")
    if place:
        return float(split_from_weights(np.array(value_at(machine, f"{losses}.weights")))[int(place)])
    return float(value_at(machine, losses))


def as_text(unknowns: Sequence[Unknown], values: Array) -> dict[str, Any]:
    """Return the values of unknowns (unknowns,) as in a description, to three digits, by path."""
    units, found = _units(unknowns), by_path(unknowns, values)
    return {path: _text(value, units[path]) if path in units else list(value) for path, value in found.items()}


def as_written(unknowns: Sequence[Unknown], values: Array) -> dict[str, Array]:
    """Return the values (SI) of machines (machines, unknowns) by path, to the digits of their descriptions."""
    units, found = _units(unknowns), by_path(unknowns, values)
    return found | {path: one.si * round_values(found[path] / one.si) for path, one in units.items() if path in found}


def _units(unknowns: Sequence[Unknown]) -> dict[str, Unknown]:
    """Return by path the unknown whose unit its value has: for a multiple, that of which it is one."""
    named = {one.name: one for one in unknowns}
    units: dict[str, Unknown] = {}
    for one in unknowns:
        root = one
        while root.times:
            root = named[root.times]
        units |= dict.fromkeys(one.paths, root)
    return units


def _text(value: float, unit: Unknown) -> str | float:
    number = float(round_values(np.array(value / unit.si)))
    return f"{number:g} {unit.unit}" if unit.unit else number
