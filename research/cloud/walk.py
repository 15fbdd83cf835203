"""Sampling of the machines with a small shortfall: a population that moves by differential evolution.

Half of the machines at a time step along the difference of two of the other half, in some of the values of a block
(key terbraak2006, key vrugt2009). Or they change one to three values independently, which removes correlations by
common descent. A step is accepted if the shortfall after it is below a level, so that machines are distributed
uniformly over the region below the level or, where every evaluation has other noise, in proportion to the probability
of passing. The level falls with the machines' shortfalls, and those above it are replaced by copies of others (key
delmoral2012). Since a step is rejected as soon as a part of its shortfall is too large, most steps cost little:
libraries for sampling do not offer that.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from layflat.arrays import Array

KEPT_FRACTION = 0.65  # of the machines that are below a new level
MIN_ROUNDS, MAX_ROUNDS = 3, 12  # of steps at a level
TARGET_STEPS = 1.0  # mean number of accepted steps of a machine at a level
LEAP_FRACTION, LEAP_LENGTH = 0.1, 1.0  # of steps between separate regions: fraction, length over the difference
CHANGED_FRACTIONS = (0.1, 0.3, 1.0)  # of a block's values that a step changes
INDEPENDENT_FRACTION = 0.5  # of steps that change few values independently
INDEPENDENT_WIDTHS, INDEPENDENT_COUNT = (0.01, 0.5), 3  # range of their standard deviations, and most values
WALK_SEED_STRIDE, ROUND_SEED_STRIDE = 100_003 * 10_007, 10_007  # of the noise, between walks and between rounds
STEP_DEVIATION = 1e-3  # of noise that is added to steps
STEP_SCALE = 2.38 / np.sqrt(2.0)  # of a step, over the root of the number of changed values
SHORT_STEP_FACTOR = 0.2  # least factor of a random shortening

Indices = NDArray[np.int64]
Lacks = Callable[[Array, int, int, Array], Array]
"""From shares (machines, unknowns), which part of the evidence, a seed of the noise and levels (machines,) to what is
lacked, (machines,); of what is above its level, a part."""


@dataclass(frozen=True)
class Block:
    """Block of unknowns that are changed together."""

    columns: slice  # in the shares
    parts: tuple[int, ...]  # of the evidence, that depend on them
    often: float = 1.0  # relative frequency of its steps


@dataclass
class Walk:
    """Population of machines that samples the region below a level."""

    shares: Array  # (machines, unknowns), 0 to 1
    lacking: Array  # (machines, parts of the evidence)
    seed: int
    level: float = np.inf
    rounds: int = 0
    taken: float = 0.3  # accepted fraction of the steps at the last level
    rng: np.random.Generator = field(init=False)

    def __post_init__(self) -> None:
        self.rng = np.random.default_rng(self.seed)

    @property
    def machines(self) -> int:
        """Number of machines."""
        return len(self.shares)

    @property
    def costs(self) -> Array:
        """Total shortfall of each machine, (machines,)."""
        return np.asarray(self.lacking.sum(axis=1))

    def look_again(self, lacks: Lacks) -> None:
        """Evaluate all machines anew, with other noise or a greater effort."""
        self.level, self.rounds = np.inf, self.rounds + 1
        for part in range(self.lacking.shape[1]):
            self.lacking[:, part] = lacks(self.shares, part, self._noise, np.full(self.machines, np.inf))

    def keep(self, count: int) -> None:
        """Continue with the machines of the least shortfall."""
        best = np.argsort(self.costs, kind="stable")[:count]
        self.shares, self.lacking = self.shares[best], self.lacking[best]

    def goes_on(self, blocks: Sequence[Block], lacks: Lacks, least: float) -> None:
        """Lower the level, not below `least`, and move all machines at it."""
        fallen, less = float(np.quantile(self.costs, KEPT_FRACTION)), self.costs[self.costs < self.level]
        if fallen >= self.level and len(less):
            fallen = float(less.max())  # copies of one machine would keep the level constant for ever
        self.level = max(least, min(self.level, fallen))
        below, above = (np.flatnonzero(which) for which in (self.costs <= self.level, self.costs > self.level))
        places = self.rng.choice(below, size=len(above))
        self.shares[above], self.lacking[above] = self.shares[places], self.lacking[places]
        often, taken = np.array([block.often for block in blocks]), list[float]()
        for _ in range(int(np.clip(TARGET_STEPS / max(self.taken, 1e-3), MIN_ROUNDS, MAX_ROUNDS))):
            self.rounds += 1
            block = blocks[self.rng.choice(len(blocks), p=often / often.sum())]
            order = self.rng.permutation(self.machines)
            for moving, others in ((order[::2], order[1::2]), (order[1::2], order[::2])):
                taken.append(self._step(block, lacks, moving, others))
        self.taken = float(np.mean(taken))

    @property
    def _noise(self) -> int:
        return self.seed * WALK_SEED_STRIDE + self.rounds * ROUND_SEED_STRIDE

    def _step(self, block: Block, lacks: Lacks, moving: Indices, others: Indices) -> float:
        """Propose and accept or reject steps of some machines; return the accepted fraction."""
        tried, lacking = self.shares[moving], self.lacking[moving]
        tried[:, block.columns] += self._way(tried[:, block.columns].shape, block, others)
        tried = np.abs((tried + 1.0) % 2.0 - 1.0)  # reflected at the bounds
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
        """Return proposed steps, (machines, values of the block)."""
        along = self._along(shape, block, others)
        return np.where(self.rng.random(len(along))[:, None] < INDEPENDENT_FRACTION, self._alone(shape), along)

    def _alone(self, shape: tuple[int, ...]) -> Array:
        """Return steps that change few values independently."""
        many, count = shape
        least, most = np.log(INDEPENDENT_WIDTHS)
        width = np.exp(self.rng.uniform(least, most, many))
        places = self.rng.random(shape).argsort(axis=1)
        changed = places < np.minimum(self.rng.integers(1, INDEPENDENT_COUNT + 1, many), count)[:, None]
        return np.asarray(changed * width[:, None] * self.rng.standard_normal(shape))

    def _along(self, shape: tuple[int, ...], block: Block, others: Indices) -> Array:
        """Return steps along differences of other machines."""
        many, count = shape
        first, second = (self.shares[self.rng.choice(others, size=many)][:, block.columns] for _ in range(2))
        changed = self.rng.random(shape) < self.rng.choice(CHANGED_FRACTIONS, size=many)[:, None]
        changed[np.arange(many), self.rng.integers(count, size=many)] = True
        length = STEP_SCALE / np.sqrt(changed.sum(axis=1)) * self.rng.uniform(SHORT_STEP_FACTOR, 1.0, many)
        length = np.where(self.rng.random(many) < LEAP_FRACTION, LEAP_LENGTH, length)[:, None]
        return np.asarray(changed * (length * (first - second) + STEP_DEVIATION * self.rng.standard_normal(shape)))


def start_walk(shares: Array, parts: int, lacks: Lacks, seed: int) -> Walk:
    """Return a walk from machines' shares, with their shortfalls evaluated."""
    walk = Walk(shares.copy(), np.zeros((len(shares), parts)), seed)
    walk.look_again(lacks)
    return walk
