"""Where nothing is short: a population is annealed over all that is open, and CMA-ES goes on from its best machines."""

import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from layflat.arrays import Array
from layflat.experiments.calibration.annealing import Population, anneal
from layflat.experiments.calibration.evidence import CAREFUL, FINE, ROUGH, Effort
from layflat.extras import module

MACHINES, WARM = 200, 0.4  # of the population, and the temperature at which the best of them are taken
CANDIDATES, WIDTH = 40, 0.06  # of a generation, and their spread at first
KEEPS = 10  # candidates that were best by luck or merit, to be tried again with other noise
EVERY = 25  # generations from one such trial to the next
TRIALS = 2  # noises of a trial
NEARLY = 0.5  # all shortfalls, margins included, below which a machine may have all findings
STALE = 150  # generations without a better trial after which a climb ends

Shortfalls = Callable[[Array, int, Effort], dict[str, Array]]
"""From shares (machines, unknowns), a seed of the noise, and how closely to look, to shortfalls by name."""

Agrees = Callable[[Array], bool]
"""Whether a machine (unknowns,) has all findings."""


@dataclass(frozen=True)
class Best:
    """The best so far: where it lies in the unknowns' ranges, what it lacks (mean over noises), and after how much."""

    shares: Array
    lacks: dict[str, float]
    generations: int

    @property
    def cost(self) -> float:
        """All that it lacks."""
        return sum(self.lacks.values())


@dataclass
class _Climb:
    """A search from one place."""

    strategy: Any
    best: Best
    kept: list[tuple[float, Array]] = field(default_factory=list)  # the best candidates since the last trial
    generations: int = 0
    better: int = 0  # generations when a trial last found something better

    def goes_on(self, shortfalls: Shortfalls, seed: int, done: int) -> None:
        """Try one generation, and now and then the best candidates again."""
        asked = self.strategy.ask()
        costs = _total(shortfalls(np.array(asked), seed * 100_003 + done, CAREFUL)).tolist()
        self.strategy.tell(asked, costs)
        self.generations += 1
        self.kept = sorted([*self.kept, *zip(costs, asked, strict=True)], key=lambda one: one[0])[:KEEPS]
        if self.generations % EVERY == 0:
            tried = _tried(shortfalls, [share for _, share in self.kept], seed, done)
            self.kept = []
            if tried.cost < self.best.cost:
                self.best, self.better = tried, self.generations

    @property
    def ended(self) -> bool:
        """Whether there is nothing more to expect."""
        return bool(self.strategy.stop()) or self.generations - self.better >= STALE


def search(
    shortfalls: Shortfalls, agrees: Agrees, first: Array | None, count: int, *, seed: int, seconds: float
) -> Iterator[tuple[Best, float]]:
    """Seek a machine that lacks nothing in a cube of `count` unknowns; yields the best so far, and the time left (s).

    It ends where the best has all findings.

    Args:
        shortfalls: what machines lack.
        agrees: whether a machine has all findings; asked where nearly nothing is short.
        first: where to begin; None: anywhere.
        count: of the unknowns.
        seed: of the search and of the noise: the same machine finds the same.
        seconds: after which it ends.
    """
    until, rng, done = time.monotonic() + seconds, np.random.default_rng(seed), 0
    starts = [first] if first is not None else list[Array]()
    for population in _annealed(shortfalls, count, seed) if first is None else ():
        starts, done = _best_first(population), population.moves
        yield Best(starts[0], _parts(shortfalls(starts[0][None], seed, CAREFUL), 0), done), until - time.monotonic()
        if time.monotonic() > until:
            return
    best = nothing = Best(starts[0], {"nothing tried yet": np.inf}, done)
    while starts:
        climb = _Climb(_strategy(starts.pop(0), rng), nothing)
        before = best.cost
        while not climb.ended:
            climb.goes_on(shortfalls, seed, done := done + 1)
            if climb.generations % EVERY == 0:
                better, best = climb.best.cost < best.cost, min(best, climb.best, key=lambda one: one.cost)
                yield best, until - time.monotonic()
                if better and best.cost <= NEARLY and agrees(best.shares):
                    return
            if time.monotonic() > until:
                return
        # What was found is looked at again, as long as that helps.
        starts = [best.shares, *starts] if best.cost < before else starts


def _annealed(shortfalls: Shortfalls, count: int, seed: int) -> Iterator[Population]:
    """Populations until one is warm."""

    def costs(shares: Array, noise: int) -> Array:
        return _total(shortfalls(shares, noise, ROUGH))

    for population in anneal(costs, count, machines=MACHINES, seed=seed, coldest=WARM):
        yield population
        if population.temperature <= WARM:
            return


def _best_first(population: Population) -> list[Array]:
    """Machines of a population by what they lack, each once."""
    _, places = np.unique(population.costs, return_index=True)
    return list(population.shares[places])


def _strategy(first: Array, rng: np.random.Generator) -> Any:
    cma = module("calibrate", "cma", where="calibration")
    options = {"seed": int(rng.integers(1, 2**31)), "popsize": CANDIDATES, "bounds": [0.0, 1.0], "verbose": -9}
    return cma.CMAEvolutionStrategy(np.clip(first, 0.02, 0.98), WIDTH, options)


def _total(parts: dict[str, Array]) -> Array:
    return np.asarray(np.sum(list(parts.values()), axis=0))


def _tried(shortfalls: Shortfalls, shares: Sequence[Array], seed: int, done: int) -> Best:
    """Return the best of some candidates over noises that the search has not met, with the default step."""
    found = [shortfalls(np.array(shares), 1_000_003 * seed + trial, FINE) for trial in range(TRIALS)]
    mean = {name: np.mean([one[name] for one in found], axis=0) for name in found[0]}
    least = int(np.argmin(_total(mean)))
    return Best(np.asarray(shares[least]), _parts(mean, least), done)


def _parts(found: dict[str, Array], machine: int) -> dict[str, float]:
    return {name: float(parts[machine]) for name, parts in found.items()}
