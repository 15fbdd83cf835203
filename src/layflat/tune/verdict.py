"""What gains are worth in the end: over conditions that no search has met, the same for every method and seed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from layflat.machine import Machine
from layflat.sim.ensemble import ensemble
from layflat.tune.conditions import Conditions, conditions
from layflat.tune.cost import candidate_costs

Array = NDArray[np.float64]

FRESH, FRESH_SEED = 256, 2_000_000_000
"""Runs that judge, and their seed."""
LIMIT = 1.5
"""Time in which the paper's arm settles, s: section 4.2."""


@dataclass(frozen=True)
class Verdict:
    """What a machine does over the fresh conditions.

    Args:
        settling: of every joint in every move of every run, s; infinite where it does not settle.
        nominal: time until both joints have settled, mean over the nominal runs, s; one a move, one joint's step each.
        cost: s.
    """

    settling: Array
    nominal: Array
    cost: float

    @property
    def worst(self) -> float:
        """Slowest of all, s."""
        return float(self.settling.max())

    @property
    def late(self) -> int:
        """How many do not settle within the limit."""
        return int((self.settling > LIMIT).sum())


def fresh(machine: Machine) -> Conditions:
    """The conditions that judge."""
    return conditions(machine, FRESH, seed=FRESH_SEED)


def verdict(machine: Machine) -> Verdict:
    """Judge a machine as it is described."""
    by = fresh(machine)
    runs = ensemble(machine, by.scenarios, by.of(1))
    settling = runs["settling"].to_numpy()
    settling = np.where(np.isnan(settling), np.inf, settling)
    nominal: Array = settling[: by.nominal].max(axis=2).mean(axis=0)
    return Verdict(settling, nominal, float(candidate_costs(runs, by, 1)[0]))
