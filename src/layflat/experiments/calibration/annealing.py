"""Many machines at once, drawn towards where little is short: all over the ranges at first, then ever closer together.

Sequential Monte Carlo (key delmoral2006): the temperature falls so that most machines stay worth keeping; these are
drawn again by what they are worth, and moved by differential evolution (key terbraak2006) with emcee (key
foremanmackey2013).
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.optimize import brentq
from scipy.special import ndtr

from layflat.arrays import Array
from layflat.extras import module

HOT = 1e3  # temperature to begin with; a shortfall counts as its share of the temperature
WORST = 100.0  # shortfalls count up to this
KEPT = 0.7  # effective share of machines that a new temperature leaves
MOVES = (4, 16)  # fewest and most moves at a temperature
MOVED = 1.2  # moves that are accepted at a temperature, for each machine
APART = 1e-6  # deviates by which machines that are drawn several times differ
SNOOKER = 0.2  # share of moves along a line to another machine

Costs = Callable[[Array, int], Array]
"""From shares (machines, unknowns) and a seed of the noise to what machines lack in all, (machines,)."""


@dataclass(frozen=True)
class Population:
    """Machines at a temperature."""

    temperature: float
    shares: Array  # (machines, unknowns)
    costs: Array  # (machines,)
    moves: int  # since the beginning


@dataclass
class _Target:
    """Log of the probability of normal deviates, the least where much is short."""

    costs: Costs
    seed: int
    temperature: float = HOT
    asked: int = 0

    def of(self, deviates: Array) -> Array:
        """Logs of probability, and costs, (machines, 2)."""
        self.asked += 1
        found = np.minimum(self.costs(ndtr(deviates), self.seed * 100_003 + self.asked), WORST)
        return np.stack([self.log(deviates, found), found], axis=1)

    def log(self, deviates: Array, costs: Array) -> Array:
        """The log of the probability of deviates that have these costs."""
        return np.asarray(-0.5 * np.square(deviates).sum(axis=1) - costs / self.temperature)


def anneal(costs: Costs, count: int, *, machines: int, seed: int, coldest: float) -> Iterator[Population]:
    """Yield populations at falling temperatures, down to the coldest; at that they go on for ever.

    Args:
        costs: what machines lack.
        count: of the unknowns, whose shares are drawn evenly at first.
        machines: in a population, more than twice the unknowns.
        seed: of all draws and of the noise.
        coldest: temperature.
    """
    emcee = module("calibrate", "emcee", where="calibration")
    rng, target = np.random.default_rng(seed), _Target(costs, seed)
    moves = [(emcee.moves.DEMove(), 1.0 - SNOOKER), (emcee.moves.DESnookerMove(), SNOOKER)]
    sampler = emcee.EnsembleSampler(machines, count, target.of, moves=moves, vectorize=True, blobs_dtype=float)
    sampler.random_state = np.random.RandomState(seed).get_state()  # emcee knows no other
    deviates = rng.standard_normal((machines, count))
    found, steps, accepted = target.of(deviates)[:, 1], 0, 0.3
    while True:
        drawn, target.temperature = _cooled(found, target.temperature, coldest, rng)
        # No two at one place: a line through both is what a move needs.
        deviates, found = deviates[drawn] + APART * rng.standard_normal(deviates.shape), found[drawn]
        begin = emcee.State(deviates, log_prob=target.log(deviates, found), blobs=found)
        sampler.reset()
        asked = int(np.clip(MOVED / max(accepted, 0.02), *MOVES))
        state: Any = sampler.run_mcmc(begin, asked, skip_initial_state_check=True)
        steps, accepted = steps + asked, float(sampler.acceptance_fraction.mean())
        deviates, found = state.coords, np.asarray(state.blobs).ravel()
        yield Population(target.temperature, ndtr(deviates), found, steps)


def _cooled(costs: Array, temperature: float, coldest: float, rng: np.random.Generator) -> tuple[Array, float]:
    """Draw machines again at a lower temperature: which of them, and the temperature."""

    def worth(inverse: float) -> Array:
        weights = np.exp(-(inverse - 1.0 / temperature) * (costs - costs.min()))
        return np.asarray(weights / weights.sum())

    def too_many(inverse: float) -> float:
        return float(1.0 / np.square(worth(inverse)).sum() / len(costs) - KEPT)

    hot, cold = 1.0 / temperature, 1.0 / coldest
    inverse = cold if too_many(cold) >= 0.0 else brentq(too_many, hot, cold)
    places = (rng.random() + np.arange(len(costs))) / len(costs)
    drawn = np.minimum(np.searchsorted(np.cumsum(worth(inverse)), places), len(costs) - 1)
    return drawn, 1.0 / inverse
