"""Settling of the tip under a controller, its rest and its repeats: on the arm that it knows, and on others."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple, get_args

import numpy as np
from numpy.typing import ArrayLike

from layflat.arrays import Array
from layflat.control.tracking.description import PartOfLaw, TrackingControllerPart
from layflat.description.change import changed_all, value_at
from layflat.experiments.beyond.moves import POSTURES, REST, sequences, steps
from layflat.machine import Machine
from layflat.motion.optimal import time_optimal
from layflat.motion.path import JointLine
from layflat.motion.scenario import Scenario
from layflat.sim import rollout
from layflat.sim.ensemble import ensemble
from layflat.sim.repeats import learnt_error_ratio
from layflat.tune.robust import plants, robust_set

MOVES = 5  # after each other, where what is learnt counts
HEAVIEST = 2.0  # payload that a planar arm may carry, kg: the paper's
TWICE = 2.0  # an arm in space is described with half of the greatest
SPREAD = 0.3  # standard deviation of an unknown payload over the greatest


@dataclass(frozen=True)
class Settling:
    """Settling times of the tip under one law, s; infinite where it did not settle in `moves.PAUSE`."""

    law: str
    case: str
    times: Array

    @property
    def median(self) -> float:
        """Their median."""
        return float(np.median(self.times))

    @property
    def late(self) -> float:
        """The time within which 95 of 100 settle."""
        return float(np.quantile(self.times, 0.95, method="higher"))

    @property
    def unsettled(self) -> int:
        """Return how many did not settle."""
        return int((~np.isfinite(self.times)).sum())


NOMINAL, LATE, ROBUST = "as described", "a control cycle of delay, known", "plants that differ"
FIRST, LATER = "payload unknown, first move", "payload unknown, later moves"
BOTH = "plants that differ, payload unknown"


def nominal(law: str, machine: Machine, runs: int) -> Settling:
    """Return how a machine's own controller does on it."""
    return Settling(law, NOMINAL, _times(machine, sequences(machine, 1), _each(runs), machine)[:, 0])


def late(law: str, machine: Machine, runs: int) -> Settling:
    """Return the same with valves that answer a control cycle late."""
    delay = value_at(machine, "valve.delay") + machine.cycle
    return Settling(law, LATE, nominal(law, changed_all(machine, {"valve.delay": delay}), runs).times)


def robust(law: str, machine: Machine, runs: int, *, unknown_payload: bool = False) -> Settling:
    """Return how it does on plants that differ from the machine (see `tune.robust`)."""
    driver, draw, found = unsure(machine) if unknown_payload else machine, np.random.default_rng(3), []
    for other in robust_set(machine, runs):
        count = len(other.vary["valve.delay"])
        vary: dict[str, ArrayLike] = _each(count) | dict(other.vary)
        if unknown_payload:
            vary["scenario.payload"] = draw.uniform(0.0, heaviest(machine), count)
        found.append(_times(other.machine, sequences(machine, 1), vary, driver)[:, 0])
    return Settling(law, BOTH if unknown_payload else ROBUST, np.concatenate(found))


def unknown_payload(law: str, machine: Machine, runs: int, *, gravity: float = 0.0) -> tuple[Settling, Settling]:
    """Return the first move with a payload that the controller does not know, and those after the first two."""
    arm = changed_all(unsure(machine), {"arm.gravity": gravity} if gravity else {})
    vary: dict[str, ArrayLike] = _each(runs)
    vary["scenario.payload"] = np.random.default_rng(12).uniform(0.0, heaviest(machine), runs)
    times = _times(arm, sequences(machine, MOVES), vary, arm)
    return Settling(law, FIRST, times[:, 0]), Settling(law, LATER, times[:, 2:].ravel())


def unsure(machine: Machine) -> Machine:
    """Return the machine with a controller that does not know its payload, where it can estimate it."""
    if not isinstance(machine.controller, TrackingControllerPart):
        return machine
    most = heaviest(machine)
    return changed_all(machine, {"arm.payload": most / 2, "controller.payload_spread": SPREAD * most})


def heaviest(machine: Machine) -> float:
    """Return the greatest payload that an arm is to carry, kg."""
    return TWICE * machine.arm.payload if machine.arm.own_links else HEAVIEST


def ablations(machine: Machine, runs: int) -> list[Settling]:
    """Return how the tracking law does on plants that differ without each of its parts in turn."""
    found = []
    for part in get_args(PartOfLaw):
        lacking = changed_all(machine, {"controller.without": (part,)})
        found.append(robust(f"tracking, without {part}", lacking, runs))
    return found


def _each(runs: int) -> dict[str, ArrayLike]:
    return {"scenario": np.arange(runs) % POSTURES, "seed": np.arange(runs)}


def _times(machine: Machine, scenarios: Sequence[Scenario], vary: Mapping[str, ArrayLike], driver: Machine) -> Array:
    runs = ensemble(machine, scenarios, vary, controller=driver, metrics=("tip_settling",))
    found: Array = runs["tip_settling"].to_numpy()
    return np.where(np.isnan(found), np.inf, found)


SETTLED = 2.5  # time after the step from which the arm has to rest, s


class Resting(NamedTuple):
    """Motion of an arm at rest."""

    moved: float  # greatest way of any joint, rad
    air: float  # share of the air that it takes with its dither on all the time


def resting(machine: Machine, seconds: float) -> Resting:
    """Return what a machine does in so many seconds after a move."""
    moved, air = _at_rest(machine, seconds)
    _, always = _at_rest(changed_all(machine, {"valve.dither.least": 1.0}), min(seconds, 10.0))
    return Resting(moved, air / always)


def _at_rest(machine: Machine, seconds: float) -> tuple[float, float]:
    """Greatest way, rad, and air taken, kg/s."""
    before, after = steps(machine)[0]
    demand = [(0.0, before.tolist()), (REST, after.tolist())]
    run = rollout(machine, demand, duration=REST + SETTLED + seconds, seed=1)
    first = round((REST + SETTLED) / machine.cycle)
    angles, air = run["angle"].to_numpy()[first:], run["air_taken"].sum("joint").to_numpy()[first:]
    return float(np.abs(angles - angles[0]).max()), float(air[-1] - air[0]) / seconds


REPEATS = 5


def learnt_ratio(machine: Machine, count: int) -> float:
    """Return the median error along time-optimal steps after five repeats, over that before them.

    Each of so many plants that differ from the machine makes a step of its own; errors are rms of the true tip.
    """
    found = []
    for plant, (before, after) in zip(plants(machine, count), steps(machine) * count, strict=False):
        motion = time_optimal(machine, JointLine(before, after))
        found.append(learnt_error_ratio(machine, plant, motion, REPEATS))
    return float(np.median(found))
