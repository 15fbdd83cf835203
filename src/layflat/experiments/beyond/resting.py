"""What an arm does at rest: how far it moves, and what air it takes."""

from typing import NamedTuple

import numpy as np

from layflat.description.change import changed_all
from layflat.experiments.beyond.moves import REST, steps
from layflat.machine import Machine
from layflat.sim import rollout

SETTLED = 2.5  # time after the step from which the arm has to rest, s


class Resting(NamedTuple):
    """What an arm at rest does."""

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
