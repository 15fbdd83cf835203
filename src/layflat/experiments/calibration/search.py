"""Where nothing is short: CMA-ES over what is open, from several places, of which the better half goes on each time."""

import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from itertools import repeat
from typing import Any

import numpy as np

from layflat.arrays import Array
from layflat.extras import module

POPULATION, WIDTH, NARROW = 40, 0.3, 0.06  # candidates, and their spread at first, and near what was found
STARTS, HEAD = 4, 75  # places where a search begins, and generations before the worse half of them ends
KEEPS = 10  # candidates that were best by luck or merit, to be tried again with other noise
EVERY = 25  # generations from one such trial to the next
TRIALS = 2  # noises of a trial
ENOUGH = 0.02  # what is left of all shortfalls where a search may end
STALE = 200  # generations without a better trial after which a search begins anew

Shortfalls = Callable[[Array, int, bool], dict[str, Array]]
"""From shares (machines, unknowns), a seed of the noise, and whether to take fine steps, to shortfalls by name."""


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
        costs = _total(shortfalls(np.array(asked), seed * 100_003 + done, False)).tolist()
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


def _turns(climbs: list[_Climb]) -> Iterator[_Climb]:
    """Which climb goes on, generation by generation: all of them at first, then the better half, at last the best."""
    while len(climbs) > 1:
        for climb in climbs:
            yield from repeat(climb, HEAD)
        climbs = sorted(climbs, key=lambda one: one.best.cost)[: len(climbs) // 2]
    while not climbs[0].ended:
        yield climbs[0]


def search(
    shortfalls: Shortfalls, first: Array | None, count: int, *, seed: int, seconds: float
) -> Iterator[tuple[Best, float]]:
    """Seek the least shortfall over a cube of `count` unknowns; yields the best so far, and the time left (s).

    Args:
        shortfalls: what machines lack.
        first: where to begin; None: anywhere.
        count: of the unknowns.
        seed: of the search and of the noise: the same machine finds the same.
        seconds: after which it ends.
    """
    until, rng, done = time.monotonic() + seconds, np.random.default_rng(seed), 0
    best = nothing = Best(np.full(count, 0.5), {"nothing found yet": np.inf}, 0)
    start = first
    while True:
        places = list(rng.uniform(0.15, 0.85, (STARTS, count))) if start is None else [start]
        width, before = WIDTH if start is None else NARROW, best
        for climb in _turns([_Climb(_strategy(place, width, rng), nothing) for place in places]):
            if time.monotonic() > until:
                return
            climb.goes_on(shortfalls, seed, done := done + 1)
            if climb.generations % EVERY == 0:
                best = min(best, climb.best, key=lambda one: one.cost)
                yield best, until - time.monotonic()
            if best.cost <= ENOUGH:
                return
        # What was found is looked at more closely, as long as that helps; then it begins anywhere.
        start = best.shares if best.cost < before.cost else None


def _strategy(first: Array, width: float, rng: np.random.Generator) -> Any:
    cma = module("tune", "cma", where="calibration")
    options = {"seed": int(rng.integers(1, 2**31)), "popsize": POPULATION, "bounds": [0.0, 1.0], "verbose": -9}
    return cma.CMAEvolutionStrategy(np.clip(first, 0.02, 0.98), width, options)


def _total(parts: dict[str, Array]) -> Array:
    return np.asarray(np.sum(list(parts.values()), axis=0))


def _tried(shortfalls: Shortfalls, shares: Sequence[Array], seed: int, done: int) -> Best:
    """Return the best of some candidates over noises that the search has not met, with the default step."""
    found = [shortfalls(np.array(shares), 1_000_003 * seed + trial, True) for trial in range(TRIALS)]
    mean = {name: np.mean([one[name] for one in found], axis=0) for name in found[0]}
    least = int(np.argmin(_total(mean)))
    return Best(np.asarray(shares[least]), {name: float(parts[least]) for name, parts in mean.items()}, done)
