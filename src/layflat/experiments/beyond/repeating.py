"""How much better a repeated move is done: see `motion.learning`."""

import numpy as np

from layflat.experiments.beyond.moves import steps
from layflat.machine import Machine
from layflat.motion.optimal import time_optimal
from layflat.motion.path import JointLine
from layflat.sim.repeats import learnt_error_ratio
from layflat.tune.robust import plants

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
