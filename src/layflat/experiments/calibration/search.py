"""Where nothing is short: machines walk down to what is nearly enough, and the best of them are asked for all claims.

Noise is other noise at every step, and in the end machines are looked at several times before a step is taken, since
luck with a few runs would lead astray. Who is asked has the claims' own noise; of those that have all findings, the one
that lacks least in many looks with other noise has them most surely.
"""

import itertools
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from layflat.arrays import Array
from layflat.experiments.calibration.effort import CLAIMED, OWN_NOISE, ROUGH, ROUGHLY_CLAIMED, SURE, Effort
from layflat.experiments.calibration.walk import Block, Walk, begun

ROUNDS = 5  # of steps at a level at most
SPREAD = 0.03  # of their shares at first, where they begin near a machine
NEARLY = 0.5  # what a machine may lack that may have all findings
STUCK, OFTEN = 0.01, 3  # share of steps below which machines are looked at again, and how often before it is in vain
ENOUGH = 2.0  # times its level at which a walk that is stuck is looked at more closely all the same
DESCENTS = 64  # seeds from a search to the next
ASKED = 16  # machines at a level
OTHERS, APART = 12, 7919  # looks with other noise by which a machine is doubted, and seeds between them
SURELY = 0.6  # what a machine may lack in these in the mean: the built-in ones lack as much

EFFORTS = ((ROUGH, 180, 1.5), (ROUGHLY_CLAIMED, 120, 0.6), (SURE, 64, 0.1))
"""How closely machines are looked at one after the other, how many of them, and down to which level."""

Parts = Callable[[Array, int, Effort], dict[str, Array]]
"""From shares (machines, unknowns), a seed of the noise and how closely to look to shortfalls by name."""

Lack = Callable[[Array, int, Effort, Array], Array]
"""From the same and each machine's level to all that it lacks, (machines,); above the level a part of it."""


@dataclass(frozen=True)
class Sought:
    """What is sought: shortfalls by name, their sum, and what a machine (unknowns,) is denied when asked for all."""

    parts: Parts
    lack: Lack
    denied: Callable[[Array], str]


@dataclass(frozen=True)
class Best:
    """The best so far: where it lies in the unknowns' ranges, what it lacks with the claims' noise, after how much."""

    shares: Array
    lacks: dict[str, float]
    rounds: int
    doubt: float = np.inf  # what it lacks in looks with other noise, in the mean
    denied: str | None = None  # the first claim that disagrees, empty if none does; None: it was not asked

    @property
    def cost(self) -> float:
        """All that it lacks."""
        return sum(self.lacks.values())

    @property
    def agrees(self) -> bool:
        """Whether it has all findings."""
        return self.denied == ""

    def surely(self, doubt: float) -> bool:
        """Whether it has them with other noise as well, but for so much."""
        return self.agrees and self.doubt <= doubt

    def beats(self, other: "Best") -> bool:
        """Whether it is better: it has all findings, or more surely, or lacks less of them."""
        if self.agrees != other.agrees:
            return self.agrees
        return self.doubt < other.doubt if self.agrees else self.cost < other.cost


def search(
    sought: Sought, first: Array | None, count: int, *, seed: int, seconds: float, doubt: float = SURELY
) -> Iterator[tuple[Best, float, float]]:
    """Seek a machine that has all findings in a cube of `count` unknowns.

    Yields the best so far, the level of the walk, and the time left (s), until a machine surely has all or the time is
    over.

    Args:
        sought: what is sought.
        first: shares near which to begin; None: anywhere.
        count: of the unknowns.
        seed: of the search and of the noise: the same machine finds the same.
        seconds: after which it ends.
        doubt: what a machine that agrees may lack in looks with other noise for the search to end.
    """
    until, best, asked = time.monotonic() + seconds, None, set[bytes]()
    for walk, closely in _descents(sought, first, count, seed):
        over = time.monotonic() > until
        for machine in np.argsort(walk.costs)[:ASKED]:
            place = walk.shares[machine]
            if place.tobytes() in asked or not (closely or best is None or (over and not best.agrees)):
                continue
            asked.add(place.tobytes())
            found = _asked(sought, walk, place)
            best = found if best is None or found.beats(best) else best
            if best.surely(doubt):
                break
        assert best is not None
        yield best, walk.level, until - time.monotonic()
        if over or best.surely(doubt):
            return


def _descents(sought: Sought, first: Array | None, count: int, seed: int) -> Iterator[tuple[Walk, bool]]:
    """Walks, level by level, the next from anywhere else when one is stuck; and whether these are close looks."""
    for number in itertools.count():
        rng = np.random.default_rng((seed, number))
        shares = rng.random((EFFORTS[0][1], count))
        if first is not None and not number:
            shares = np.clip(first + SPREAD * rng.standard_normal(shares.shape), 0.0, 1.0)
            shares[0] = first
        yield from _descent(sought, shares, seed * DESCENTS + number)


def _descent(sought: Sought, shares: Array, seed: int) -> Iterator[tuple[Walk, bool]]:
    """A walk that is looked at ever more closely, until it is stuck."""
    efforts, stuck = iter(EFFORTS), 0
    effort, _, least = next(efforts)

    def lacks(shares: Array, part: int, noise: int, level: Array) -> Array:  # noqa: ARG001  (there is one part)
        return sought.lack(shares, noise, effort, level)

    walk, blocks = begun(shares, 1, lacks, seed, ROUNDS), [Block(slice(0, shares.shape[1]), (0,))]
    yield walk, False
    while True:
        walk.goes_on(blocks, lacks, least)
        yield walk, effort is SURE
        is_stuck = walk.taken < STUCK
        in_vain = is_stuck and stuck == OFTEN
        if effort is not SURE and walk.level <= (ENOUGH * least if in_vain else least):
            effort, machines, least = next(efforts)
            stuck = 0
            walk.keep(machines)
            walk.look_again(lacks)
        elif in_vain:
            return
        elif is_stuck:
            stuck += 1
            walk.look_again(lacks)


def _asked(sought: Sought, walk: Walk, place: Array) -> Best:
    """Look at a machine closely, and ask whether it has all findings where it may, and how surely where it has."""
    lacks = {name: float(part[0]) for name, part in sought.parts(place[None], OWN_NOISE, CLAIMED).items()}
    found = Best(place.copy(), lacks, walk.rounds)
    if found.cost > NEARLY:
        return found
    found = replace(found, denied=sought.denied(place))
    return replace(found, doubt=_doubt(sought, place)) if found.agrees else found


def _doubt(sought: Sought, place: Array) -> float:
    """What a machine lacks in the mean of looks with noise that decided nothing."""
    once = replace(SURE, looks=1)
    looks = [sought.parts(place[None], OWN_NOISE + APART * (1 + number), once) for number in range(OTHERS)]
    return float(np.mean([sum(float(part[0]) for part in parts.values()) for parts in looks]))
