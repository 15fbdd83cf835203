"""What a controller is worth in the end: over conditions that no search has met, the same for every method and seed."""

from dataclasses import dataclass

import numpy as np
import xarray

from layflat.arrays import Array
from layflat.machine import Machine
from layflat.sim.metrics import disturbance
from layflat.sim.run import rollout_as_far
from layflat.tune.conditions import REST, Conditions, candidate_costs
from layflat.tune.search import Meet

FRESH, FRESH_SEED = 256, 2_000_000_000  # runs of the validation, and their seed
LIMIT = 1.5  # time in which the paper's arm settles, s: section 4.2
PUSHED, MORE = np.radians(3.0), 2.0
"""A joint that another one's step pushes further than this (rad), and so many times as far as before, is warned of."""


@dataclass(frozen=True)
class Validation:
    """What a machine does over the fresh conditions."""

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
        """How many do not settle within the limit."""
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
    """How far each joint is pushed by the moves of the nominal sequence in which another one is asked to move, rad."""
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
