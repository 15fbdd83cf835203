"""Noise of many runs from seeds, hashed all at once: as numpy's `SeedSequence` does it one by one (oneill2015)."""

from collections.abc import Callable, Iterator
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from layflat.arrays import Array
from layflat.lanes import interpreted
from layflat.physics.noise import sensor_noise
from layflat.sim.ensemble.noise import Ziggurat, fill

Seeds = NDArray[np.int64]
Words = NDArray[np.uint32]

Make = Callable[[Seeds, tuple[int, int], type[np.floating[Any]]], Any]
"""What makes noise: `noise_of`, or the same on a device."""

CALM = -1
"""In place of a seed: a run without noise."""

BEGIN_POOL, NEXT_POOL = 0x43B0D7E5, 0x931E8875
BEGIN_WORDS, NEXT_WORDS = 0x8B51F9DD, 0x58F38DED
MIX_LEFT, MIX_RIGHT = np.uint32(0xCA01F9DD), np.uint32(0x4973F715)
POOL, WORDS = 4, 8  # numbers of 32 bits that a seed is spread over, and that are made of them


def noise_of(seeds: Seeds, shape: tuple[int, int], number: type[np.floating[Any]]) -> Array:
    """Noise of runs in so many (cycles, joints): (cycles, joints, 2, runs); one cycle of zeros where all are calm."""
    cycles, joints = shape
    if (seeds == CALM).all():
        return np.zeros((1, joints, 2, len(seeds)), number)
    noise = np.empty((cycles, joints, 2, len(seeds)), number)
    if interpreted():
        for run, seed in enumerate(seeds):
            noise[..., run] = sensor_noise(None if seed == CALM else int(seed), cycles, joints)
    else:
        fill(streams(seeds), ziggurat(), noise)
    return noise


@cache
def ziggurat() -> Ziggurat:
    """The compiler's own tables."""
    from numba.np.random import _constants as tables  # noqa: PLC0415  # it takes long to load

    return Ziggurat(
        tables.ki_double,
        tables.wi_double,
        tables.fi_double,
        float(tables.ziggurat_nor_r),
        float(tables.ziggurat_nor_inv_r),
    )


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
