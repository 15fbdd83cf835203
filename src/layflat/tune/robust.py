"""Plants that differ from what their controller believes of them, and the final judgement of a controller.

A controller that knows its machine has to be judged on others. These have friction and losses, conductance and supply
that differ, stick at rest, answer late, and in every second run obey another law of losses. The conditions of the final
judgement are ones that no search has met, the same for every method and seed.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import xarray

from layflat.arrays import Array
from layflat.description.change import changed_all, value_at
from layflat.machine import Machine, changed
from layflat.machine.parts import Joint
from layflat.physics.friction.stribeck import StribeckPart
from layflat.physics.hysteresis.bouc_wen import BoucWenPart
from layflat.sim.metrics import disturbance
from layflat.sim.run import rollout_as_far
from layflat.tune.conditions import REST, Conditions, candidate_costs
from layflat.tune.search import Meet

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


FRESH, FRESH_SEED = 256, 2_000_000_000  # runs of the validation, and their seed
LIMIT = 1.5  # time in which the paper's arm settles, s: section 4.2
PUSHED, MORE = np.radians(3.0), 2.0
"""A joint that another one's step pushes further than this (rad), and so many times as far as before, is warned of."""


@dataclass(frozen=True)
class Validation:
    """Results of a machine over the fresh conditions."""

    settling: Array  # of every joint, or of the tip, in every move of every run, s; infinite where it does not settle
    nominal: Array  # time until all joints have settled in each move, one joint's step each, mean of nominal runs, s
    cost: float  # s
    response: "xarray.Dataset"  # the first nominal run, with its trace
    pushed: dict[str, float]  # how far a joint is pushed by another one's step in it, rad, by both in words

    @property
    def worst(self) -> float:
        """Slowest of all, s."""
        return float(self.settling.max())

    @property
    def late(self) -> int:
        """Return how many do not settle within the limit."""
        return int((self.settling > LIMIT).sum())


def fresh(meet: Meet) -> Conditions:
    """Return the conditions of the validation."""
    return meet(FRESH, FRESH_SEED)


def validate(machine: Machine, meet: Meet) -> Validation:
    """Simulate a machine as it is described over the fresh conditions."""
    by = fresh(meet)
    runs = by.simulate(machine, by.of(1))
    settling = by.measure.settling(runs)
    settling = np.where(np.isnan(settling), np.inf, settling)
    nominal: Array = settling[: by.nominal].max(axis=2).mean(axis=0)
    response = rollout_as_far(machine, scenario=by.scenarios[0], seed=int(by.vary["seed"][0]))
    cost, pushed = float(candidate_costs(runs, by, 1)[0]), _pushed(machine, response, by.window)
    return Validation(settling, nominal, cost, response, pushed)


def _pushed(machine: Machine, response: xarray.Dataset, window: float) -> dict[str, float]:
    """Angle by which each joint is pushed in moves of the nominal sequence that another one is asked for, rad."""
    names, last, found = list(machine.joints), float(response["time"][-1]), dict[str, float]()
    for number, mover in enumerate(names):
        since = REST + window * number
        for name in names if since < last else ():
            if name != mover:
                what = f"{name} joint pushed by {'another' if len(names) > 2 else f'the {mover}'} one"
                found[what] = max(disturbance(response, name, since, since + window), found.get(what, 0.0))
    return found


def warnings(before: Validation | None, after: Validation) -> list[str]:
    """Return a sentence for each joint that another one's step pushes much further than before."""
    said = []
    for what, now in after.pushed.items():
        was = 0.0 if before is None else before.pushed.get(what, 0.0)
        if now > PUSHED and now > MORE * was:
            than = "" if before is None else f", {np.degrees(was):.1f} deg before"
            said.append(
                f"Coupling: {what} by {np.degrees(now):.1f} deg{than}. Only settling counts in the cost; where the "
                "path matters keep the gains of before, or tune from them (--from current)."
            )
    return said
