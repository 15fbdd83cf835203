"""Machines that walk together to where little is lacked, and over all of the region where that holds.

Half of the machines at a time step along the difference of two of the other half, in some of the values of a block:
differential evolution (key terbraak2006, key vrugt2009). Or they change one to three values by themselves, so that what
they have in common by descent alone is lost. A step is taken if what is lacked afterwards is below a level: so machines
come to lie evenly over the region that a level leaves or, where looks have other noise each time, as often as they
pass. The level falls as machines get there, and those above it go on from places of others (key delmoral2012). Since a
step is refused as soon as a part of what it lacks is too much, most steps cost little: that is what libraries for
sampling do not offer.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from layflat.arrays import Array

KEPT = 0.65  # share of the machines that a new level leaves where they are
FEWEST, MOST = 3, 12  # rounds of steps at a level
TAKEN = 1.0  # steps that a machine takes at a level if there are rounds enough
LEAPS, LEAP = 0.1, 1.0  # share of steps as long as a difference: from one region to another
SPARSE = (0.1, 0.3, 1.0)  # shares of a block's values that a step changes
ALONE, WIDTHS, FEW = 0.5, (0.01, 0.5), 3  # share of steps that change few values by themselves, how far and how many
APART_WALKS, APART_ROUNDS = 100_003 * 10_007, 10_007  # seeds of the noise from walk to walk, and from round to round
APART = 1e-3  # deviation by which steps differ that would be the same
SCALE, SHORT = 2.38 / np.sqrt(2.0), 0.2  # of a step, over the root of how many values it changes; and shorter ones

Indices = NDArray[np.int64]
Lacks = Callable[[Array, int, int, Array], Array]
"""From shares (machines, unknowns), which part of the evidence, a seed of the noise and levels (machines,) to what is
lacked, (machines,); of what is above its level, a part."""


@dataclass(frozen=True)
class Block:
    """Unknowns that walk together."""

    columns: slice  # in the shares
    parts: tuple[int, ...]  # of the evidence, that depend on them
    often: float = 1.0  # how often they walk, beside the others


@dataclass
class Walk:
    """Machines on their way."""

    shares: Array  # (machines, unknowns), 0 to 1
    lacking: Array  # (machines, parts of the evidence)
    seed: int
    level: float = np.inf
    rounds: int = 0
    taken: float = 0.3  # share of the steps at the last level
    rng: np.random.Generator = field(init=False)

    def __post_init__(self) -> None:
        self.rng = np.random.default_rng(self.seed)

    @property
    def machines(self) -> int:
        """How many."""
        return len(self.shares)

    @property
    def costs(self) -> Array:
        """What each machine lacks in all, (machines,)."""
        return np.asarray(self.lacking.sum(axis=1))

    def look_again(self, lacks: Lacks) -> None:
        """Forget what was lacked: machines are looked at with other noise, or more closely."""
        self.level, self.rounds = np.inf, self.rounds + 1
        for part in range(self.lacking.shape[1]):
            self.lacking[:, part] = lacks(self.shares, part, self._noise, np.full(self.machines, np.inf))

    def keep(self, count: int) -> None:
        """Go on with those that lack least."""
        best = np.argsort(self.costs, kind="stable")[:count]
        self.shares, self.lacking = self.shares[best], self.lacking[best]

    def goes_on(self, blocks: Sequence[Block], lacks: Lacks, least: float) -> None:
        """Let the level fall, but not below `least`, and let all machines walk at it."""
        fallen, less = float(np.quantile(self.costs, KEPT)), self.costs[self.costs < self.level]
        if fallen >= self.level and len(less):
            fallen = float(less.max())  # places that many machines share would hold it up for ever
        self.level = max(least, min(self.level, fallen))
        below, above = (np.flatnonzero(which) for which in (self.costs <= self.level, self.costs > self.level))
        places = self.rng.choice(below, size=len(above))
        self.shares[above], self.lacking[above] = self.shares[places], self.lacking[places]
        often, taken = np.array([block.often for block in blocks]), list[float]()
        for _ in range(int(np.clip(TAKEN / max(self.taken, 1e-3), FEWEST, MOST))):
            self.rounds += 1
            block = blocks[self.rng.choice(len(blocks), p=often / often.sum())]
            order = self.rng.permutation(self.machines)
            for moving, others in ((order[::2], order[1::2]), (order[1::2], order[::2])):
                taken.append(self._step(block, lacks, moving, others))
        self.taken = float(np.mean(taken))

    @property
    def _noise(self) -> int:
        return self.seed * APART_WALKS + self.rounds * APART_ROUNDS

    def _step(self, block: Block, lacks: Lacks, moving: Indices, others: Indices) -> float:
        """Let some machines step along differences of others; returns the share of steps that are taken."""
        tried, lacking = self.shares[moving], self.lacking[moving]
        tried[:, block.columns] += self._way(tried[:, block.columns].shape, block, others)
        tried = np.abs((tried + 1.0) % 2.0 - 1.0)  # what steps over a bound comes back
        lacking[:, block.parts] = 0.0
        left = np.arange(len(moving))
        for part in block.parts:
            room = self.level - lacking[left].sum(axis=1)
            lacking[left, part] = lacks(tried[left], part, self._noise, room)
            left = left[lacking[left].sum(axis=1) <= self.level]
            if not len(left):
                return 0.0
        self.shares[moving[left]], self.lacking[moving[left]] = tried[left], lacking[left]
        return len(left) / len(moving)

    def _way(self, shape: tuple[int, ...], block: Block, others: Indices) -> Array:
        """Steps, (machines, values of the block)."""
        along = self._along(shape, block, others)
        return np.where(self.rng.random(len(along))[:, None] < ALONE, self._alone(shape), along)

    def _alone(self, shape: tuple[int, ...]) -> Array:
        """Change few values by themselves: what machines have in common by descent alone is lost so."""
        many, count = shape
        least, most = np.log(WIDTHS)
        width = np.exp(self.rng.uniform(least, most, many))
        places = self.rng.random(shape).argsort(axis=1)
        changed = places < np.minimum(self.rng.integers(1, FEW + 1, many), count)[:, None]
        return np.asarray(changed * width[:, None] * self.rng.standard_normal(shape))

    def _along(self, shape: tuple[int, ...], block: Block, others: Indices) -> Array:
        """Step along differences of others."""
        many, count = shape
        first, second = (self.shares[self.rng.choice(others, size=many)][:, block.columns] for _ in range(2))
        changed = self.rng.random(shape) < self.rng.choice(SPARSE, size=many)[:, None]
        changed[np.arange(many), self.rng.integers(count, size=many)] = True
        length = SCALE / np.sqrt(changed.sum(axis=1)) * self.rng.uniform(SHORT, 1.0, many)
        length = np.where(self.rng.random(many) < LEAPS, LEAP, length)[:, None]
        return np.asarray(changed * (length * (first - second) + APART * self.rng.standard_normal(shape)))


def begun(shares: Array, parts: int, lacks: Lacks, seed: int) -> Walk:
    """Return a walk from these places."""
    walk = Walk(shares.copy(), np.zeros((len(shares), parts)), seed)
    walk.look_again(lacks)
    return walk
