"""Plants that differ from what their controller believes of them: the set that a robust controller has to stand.

A controller that knows its machine has to be judged on others. These have friction and losses, conductance and supply
that differ, stick at rest, answer late, and in every second run obey another law of losses.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from layflat.arrays import Array
from layflat.description.change import changed_all, value_at
from layflat.machine import Machine, changed
from layflat.machine.parts import Joint
from layflat.physics.friction.stribeck import StribeckPart
from layflat.physics.hysteresis.bouc_wen import BoucWenPart

STATEMENT = (
    "friction and losses ±30 %, conductance and supply ±20 %, friction at rest 1 to 1.5 times that in motion, "
    "up to a control cycle of delay, and in every second run another law of losses (Bouc and Wen's)"
)
"""The set in words, for people."""

FRICTION, AIR, STATIC = 0.3, 0.2, 1.5
STRIBECK = "2 deg/s"  # velocity at which half of what friction at rest is above that in motion is gone
DEFLECTION = "1 deg"  # of the other law of losses


@dataclass(frozen=True)
class Differing:
    """Plants of one kind of machine: the machine, and what of it differs from run to run (numbers by path, SI)."""

    machine: Machine
    vary: Mapping[str, Array]


def robust_set(machine: Machine, runs: int, *, seed: int = 0) -> list[Differing]:
    """Return so many plants that differ from a machine, half of them with another law of losses.

    Args:
        machine: what the controller believes, with spool valves.
        runs: how many.
        seed: of what differs.
    """
    half, draw = runs // 2, np.random.default_rng(seed)
    sticking = _sticking(machine)
    return [
        Differing(sticking, _differing(sticking, runs - half, draw)),
        Differing(_other_losses(sticking), _differing(sticking, half, draw)),
    ]


def plants(machine: Machine, count: int, *, seed: int = 0) -> list[Machine]:
    """Return so many plants of the `robust_set`, as machines of their own."""
    found = []
    for of in robust_set(machine, count, seed=seed):
        paths = {"supply.pressure_gauge" if path == "scenario.supply" else path: of.vary[path] for path in of.vary}
        rows = zip(*(numbers.tolist() for numbers in paths.values()), strict=True)
        found += [changed_all(of.machine, dict(zip(paths, row, strict=True))) for row in rows]
    return found


def _sticking(machine: Machine) -> Machine:
    """Return the machine with friction that may be greater at rest, where nothing is said of it."""
    for name, joint in machine.joints.items():
        if joint.friction is None or joint.friction.kind == "coulomb":
            sticks = StribeckPart(kind="stribeck", static_ratio=1.0, velocity=STRIBECK)
            machine = changed(machine, f"joint.{name}.friction", sticks)
    return machine


def _other_losses(machine: Machine) -> Machine:
    for name, joint in machine.joints.items():
        kept = joint.losses.model_dump(include={"reference_pressure_gauge", "pressure_free", "damping_time"})
        units = {"reference_pressure_gauge": "Pa", "damping_time": "s"}
        given = {key: f"{value!r} {units[key]}" if key in units else value for key, value in kept.items()}
        machine = changed(machine, f"joint.{name}.losses", BoucWenPart(kind="bouc-wen", deflection=DEFLECTION, **given))
    return machine


def _differing(machine: Machine, runs: int, draw: np.random.Generator) -> dict[str, Array]:
    found: dict[str, Array] = {}
    for name, joint in machine.joints.items():
        for path in ("brake.torque", *_losses(joint)):
            key = f"joint.{name}.{path}"
            found[key] = value_at(machine, key) * draw.uniform(1.0 - FRICTION, 1.0 + FRICTION, runs)
        if isinstance(joint.friction, StribeckPart):
            found[f"joint.{name}.friction.static_ratio"] = draw.uniform(1.0, STATIC, runs)
    found["valve.conductance"] = value_at(machine, "valve.conductance") * draw.uniform(1.0 - AIR, 1.0 + AIR, runs)
    found["scenario.supply"] = machine.supply.pressure_gauge * draw.uniform(1.0 - AIR, 1.0 + AIR, runs)
    found["valve.delay"] = value_at(machine, "valve.delay") + draw.uniform(0.0, machine.cycle, runs)
    return found


def _losses(joint: Joint) -> list[str]:
    parts = {"hose": joint.hose.loss_share, "strap": joint.strap.loss_share}
    return [f"{part}.loss_share" for part, share in parts.items() if share > 0.0]
