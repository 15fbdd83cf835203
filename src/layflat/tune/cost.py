"""What gains cost: seconds until moves settle, over all conditions, the worst of them and the nominal ones most.

A move costs the time until the joint stays within 0.3 deg of its goal. Where it does not, it costs the whole window,
0.3 s, and 0.1 s for every 0.3 deg that error and swing remain (2 s at most). Overshoot beyond 1 deg costs 0.05 s per
degree. A run that diverges costs 5 s a move. To the mean of all moves come half the mean of the worst twentieth, and
the slowest move under nominal conditions.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from layflat.sim.metrics import BAND

if TYPE_CHECKING:
    import xarray

    from layflat.tune.conditions import Conditions

STATEMENT = (
    "The cost: seconds until moves settle within 0.3 deg, as a mean over all conditions, plus half the mean of the "
    "worst twentieth, plus the slowest move under nominal conditions; moves that never settle or overshoot cost more."
)
"""The same in a sentence, for people."""

Array = NDArray[np.float64]

NEVER, REMAINS, MOST = 0.3, 0.1, 2.0
OVERSHOOT, FREE = 0.05, 1.0
DIVERGED = 5.0
WORST, WEIGHT = 20, 0.5


def move_costs(runs: xarray.Dataset, window: float) -> Array:
    """Cost of every joint's every move, s, (run, move, joint)."""
    settling, overshoot = runs["settling"].to_numpy(), np.degrees(runs["overshoot"].to_numpy())
    remains = (np.abs(runs["steady_error"].to_numpy()) + runs["ripple"].to_numpy()) / BAND
    never = window + NEVER + np.minimum(REMAINS * remains, MOST)
    cost = np.where(np.isfinite(settling), settling, never) + OVERSHOOT * np.maximum(overshoot - FREE, 0.0)
    return np.where(np.isnan(settling), DIVERGED, cost)


def candidate_costs(runs: xarray.Dataset, by: Conditions, candidates: int) -> Array:
    """Cost of every candidate, s: its runs follow each other."""
    costs = move_costs(runs, by.window).reshape(candidates, by.runs, -1)
    nominal: Array = costs[:, : by.nominal].max(axis=2).mean(axis=1)
    ordered = np.sort(costs.reshape(candidates, -1), axis=1)
    worst: Array = ordered[:, -max(1, ordered.shape[1] // WORST) :].mean(axis=1)
    total: Array = ordered.mean(axis=1) + WEIGHT * worst + nominal
    return total
