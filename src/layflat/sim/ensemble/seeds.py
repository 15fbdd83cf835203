"""Seeds of the noise of many runs, hashed all at once: as numpy's `SeedSequence` does it, one by one (oneill2015)."""

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

Seeds = NDArray[np.int64]
Words = NDArray[np.uint32]

CALM = -1
"""In place of a seed: a run without noise."""

BEGIN_POOL, NEXT_POOL = 0x43B0D7E5, 0x931E8875
BEGIN_WORDS, NEXT_WORDS = 0x8B51F9DD, 0x58F38DED
MIX_LEFT, MIX_RIGHT = np.uint32(0xCA01F9DD), np.uint32(0x4973F715)
POOL, WORDS = 4, 8  # numbers of 32 bits that a seed is spread over, and that are made of them


def streams(seeds: Seeds) -> NDArray[np.uint64]:
    """With what the generator of each run begins: state and step, then whether there is one, (5, runs)."""
    hashed = _hashed(seeds)
    halves = [hashed[i] | hashed[i + 1].astype(np.uint64) << np.uint64(32) for i in range(0, WORDS, 2)]
    return np.array([*halves, (seeds != CALM).astype(np.uint64)])


def _hashed(seeds: Seeds) -> list[Words]:
    """Eight numbers of 32 bits for each seed, as `SeedSequence(seed).generate_state(8)`."""
    entropy = [(seeds & 0xFFFFFFFF).astype(np.uint32), (seeds >> 32).astype(np.uint32)]
    constants = _constants(BEGIN_POOL, NEXT_POOL)
    pool = [_stirred(word, *next(constants)) for word in [*entropy, *[np.zeros_like(entropy[0])] * (POOL - 2)]]
    for source in range(POOL):
        for place in range(POOL):
            if place != source:
                mixed = MIX_LEFT * pool[place] - MIX_RIGHT * _stirred(pool[source], *next(constants))
                pool[place] = mixed ^ mixed >> np.uint32(16)
    constants = _constants(BEGIN_WORDS, NEXT_WORDS)
    return [_stirred(pool[i % POOL], *next(constants)) for i in range(WORDS)]


def _constants(first: int, factor: int) -> Iterator[tuple[np.uint32, np.uint32]]:
    """Each constant of a chain and the one after it."""
    while True:
        following = first * factor & 0xFFFFFFFF
        yield np.uint32(first), np.uint32(following)
        first = following


def _stirred(word: Words, before: np.uint32, after: np.uint32) -> Words:
    stirred: Words = (word ^ before) * after
    return stirred ^ stirred >> np.uint32(16)
