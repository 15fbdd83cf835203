"""Unknowns of the cloud: all values that the paper leaves open, calibrated ones and assumed ones of wider ranges.

What a value may be at most is told by its range and why; factors between joints are those of the assumed values.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import accumulate
from typing import Any

import numpy as np

from layflat.arrays import Array
from layflat.machine import Machine, load
from research.calibration.unknowns import (
    AIR,
    DAMPING,
    DEG,
    JOINT_NAMES,
    LOSSES,
    Unknown,
    as_text,
    as_written,
    gains,
    to_shares,
    to_values,
    values_of,
)
from research.cloud.walk import Block


def per_joint(
    key: str, low: float, high: float, why: str, unit: str = "", si: float = 1.0, small: float = 1.0
) -> Unknown:
    """Return an unknown of both joints, with a factor of the small one."""
    return Unknown(
        key, low, high, why, unit, si, tuple(f"joint.{joint}.{key}" for joint in JOINT_NAMES), factors=(1.0, small)
    )


def plain(path: str, low: float, high: float, why: str, unit: str = "", si: float = 1.0) -> Unknown:
    """Return an unknown of the machine as a whole."""
    return Unknown(path, low, high, why, unit, si, (path,))


TWICE = "half to twice what is usual"
ASSUMED = (
    plain("valve.critical_ratio", 0.15, 0.5, "sharp edges to rounded ports (ISO 6358)"),
    plain("valve.overlap", 0.005, 0.06, "nearly zero-lapped to what dither has to bridge"),
    plain("valve.natural_frequency", 40.0, 160.0, "direct solenoid spools", "Hz"),
    plain("valve.damping_ratio", 0.4, 1.4, TWICE),
    plain("valve.friction", 0.02, 0.1, TWICE),
    plain("angle_sensor.noise", 0.004, 0.04, "a tenth of a count to one", "deg", DEG),
    plain("pressure_sensor.noise", 0.2, 2.5, "a tenth of a count to one", "mbar", 100.0),
    plain("controller.drift_time", 6.0, 14.0, "slow beside any move, and soon enough to take over a drift", "s"),
    plain("controller.rest_time", 0.1, 0.4, TWICE, "s"),
    plain(
        "controller.load_pressure",
        0.4,
        1.2,
        "half of what is usual, and less than what an offset load of 40 % needs",
        "bar",
        1e5,
    ),
    plain("arm.elbow", 60.0, 120.0, "the paper does not give it", "deg", DEG),
    per_joint("hose.compliance", 0.8, 5.0, "woven hose hardly stretches", "ml/bar", 1e-11, small=0.35),
    per_joint("hose.wall_conductance", 0.3, 3.0, "from dry to wet walls", "W/K", small=0.42),
    per_joint("losses.pressure_free", 0.05, 0.5, "the share falls with pressure, how far is not said"),
    per_joint("brake.viscous", 0.02, 0.15, "plain bearings to sealed ones", "N m s/rad", small=0.4),
    per_joint("link.rotor_inertia", 0.002, 0.008, "two cams, shaft and brake disk", "kg m^2", small=0.25),
)
SHELL = Unknown(
    "shell", 0.54, 0.64, "8 % at 3 bar, read to half a percent",
    paths=tuple(f"paper-arm/joint.{joint}.cover.loss_factor" for joint in JOINT_NAMES),
)  # fmt: skip
WEBBING = Unknown(
    "webbing", 0.06, 0.078, "21 % at 3 bar, read to one percent",
    paths=("earlier-actuator/joint.small.strap.loss_fraction",),
)  # fmt: skip


ALONE, ARM = 0, 1  # parts of the evidence: what joints do alone, and what the arm does


@dataclass(frozen=True)
class Group:
    """Group of unknowns: the machine whose description they change, and the evidence that depends on them."""

    machine: str
    unknowns: tuple[Unknown, ...]
    parts: tuple[int, ...]  # of the evidence, those first that reject most at the least cost
    often: float  # relative frequency of their steps: higher for more unknowns


GROUPS = (
    Group("paper-arm", (*AIR, *LOSSES["elasto-slip"], DAMPING, *ASSUMED, SHELL), (ARM, ALONE), 0.45),
    Group("earlier-actuator", (WEBBING,), (ALONE,), 0.05),
    Group("paper-small-joint", gains("small"), (ALONE,), 0.2),
    Group("paper-arm", (*gains("large"), *gains("small")), (ARM,), 0.3),
)
NAMES = tuple(dict.fromkeys(group.machine for group in GROUPS))
_ENDS = tuple(accumulate(len(group.unknowns) for group in GROUPS))
BLOCKS = tuple(
    Block(slice(end - len(group.unknowns), end), group.parts, group.often)
    for group, end in zip(GROUPS, _ENDS, strict=True)
)


def values(shares: Array, part: int) -> dict[str, Array]:
    """Numbers (SI) by path of machines (machines, unknowns), for a part of the evidence, as their file says them.

    A limit cycle may hang on the fourth digit.
    """
    found: dict[str, Array] = {}
    for group, block in zip(GROUPS, BLOCKS, strict=True):
        if part in group.parts:
            found |= as_written(group.unknowns, to_values(group.unknowns, shares[:, block.columns]))
    return found


def texts(shares: Array) -> dict[str, dict[str, Any]]:
    """Return the changed values of a member (unknowns,) as in a description, by machine and path."""
    found: dict[str, dict[str, Any]] = {}
    for group, block in zip(GROUPS, BLOCKS, strict=True):
        said = as_text(group.unknowns, to_values(group.unknowns, shares[block.columns]))
        own = found.setdefault(group.machine, {})
        own |= {path.removeprefix(f"{group.machine}/"): text for path, text in said.items()}
    return found


def excluded_values(groups: Sequence[Group] = GROUPS) -> list[str]:
    """Return a line for each value of the built-in machines that is outside its range."""
    lines = []
    for group in groups:
        for one, value in zip(group.unknowns, values_of(load(group.machine), group.unknowns), strict=True):
            if not one.low <= value <= one.high:
                unit = f" {one.unit}" if one.unit and not one.times else ""
                said = f"the built-in value, {value:.3g}{unit}, lies outside {one.low:g} to {one.high:g}{unit}"
                lines.append(f"{group.machine}: {one.name}: {said}")
    return lines


def place(machines: Mapping[str, Machine]) -> Array:
    """Return the shares of machines by their names, (unknowns,), cut to the ranges."""
    parts = [to_shares(group.unknowns, values_of(machines[group.machine], group.unknowns)) for group in GROUPS]
    return np.concatenate(parts)


def built_in_shares() -> Array:
    """Return the shares of the built-in machines, (unknowns,)."""
    return place({name: load(name) for name in NAMES})
