"""Where nothing is short: CMA-ES over what is open, restarted until it is found or the time is over."""

import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from layflat.arrays import Array
from layflat.extras import module

POPULATION, WIDTH, NARROW = 40, 0.3, 0.06  # candidates, and their spread at first, and near what was found
KEEPS = 12  # candidates that were best by luck or merit, to be tried again with other noise
EVERY = 25  # generations from one such trial to the next
TRIALS = 3  # noises of a trial
ENOUGH = 0.02  # what is left of all shortfalls where a search may end
STALE = 150  # generations without a better trial after which a search begins anew

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
    until = time.monotonic() + seconds
    rng, done = np.random.default_rng(seed), 0
    best, start, width = Best(np.full(count, 0.5), {"nothing found yet": np.inf}, 0), first, WIDTH
    while time.monotonic() < until and best.cost > ENOUGH:
        strategy = _strategy(rng.uniform(0.15, 0.85, count) if start is None else start, width, rng)
        kept, better, found = list[tuple[float, Array]](), done, False
        while time.monotonic() < until and not strategy.stop() and done - better < STALE:
            asked = strategy.ask()
            costs = _total(shortfalls(np.array(asked), seed * 100_003 + done, False))
            strategy.tell(asked, costs.tolist())
            done += 1
            kept = sorted([*kept, *zip(costs.tolist(), asked, strict=True)], key=lambda one: one[0])[:KEEPS]
            if done % EVERY == 0:
                tried = _tried(shortfalls, [share for _, share in kept], seed, done)
                kept = []
                if tried.cost < best.cost:
                    best, better, found = tried, done, True
                yield best, until - time.monotonic()
                if best.cost <= ENOUGH:
                    return
        # What was found is looked at more closely, as long as that helps; then it begins anywhere.
        start, width = (best.shares, NARROW) if found else (None, WIDTH)


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
