"""Sensor noise of many runs, with all seeds hashed at once as NumPy's `SeedSequence` hashes each (oneill2015)."""

from collections.abc import Callable, Iterator
from functools import cache
from importlib.util import find_spec, module_from_spec, spec_from_file_location
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from layflat.arrays import Array
from layflat.physics.sensor import sensor_noise
from layflat.registers import interpreted
from layflat.sim.ensemble.noise import Ziggurat, fill_noise

Seeds = NDArray[np.int64]
Words = NDArray[np.uint32]

NoiseSource = Callable[[Seeds, tuple[int, int], type[np.floating[Any]]], Any]
"""Function that makes the noise of runs: `make_noise`, or its equivalent on a CUDA device."""

NO_SEED = -1
"""Value in place of a seed: a run without noise."""

BEGIN_POOL, NEXT_POOL = 0x43B0D7E5, 0x931E8875
BEGIN_WORDS, NEXT_WORDS = 0x8B51F9DD, 0x58F38DED
MIX_LEFT, MIX_RIGHT = np.uint32(0xCA01F9DD), np.uint32(0x4973F715)
POOL_WORDS, STATE_WORDS = 4, 8  # 32-bit words of the entropy pool, and of the state that is generated from it


def make_noise(seeds: Seeds, shape: tuple[int, int], number: type[np.floating[Any]]) -> Array:
    """Return standard normal samples of the sensors of runs, (cycles, joints, 2, runs).

    Args:
        seeds: seeds of the runs, (runs,); `NO_SEED` for no noise, that is zeros; if no run has noise, only one cycle of
            zeros is returned.
        shape: numbers of cycles and joints.
        number: type of the samples.
    """
    cycles, joints = shape
    if (seeds == NO_SEED).all():
        return np.zeros((1, joints, 2, len(seeds)), number)
    noise = np.empty((cycles, joints, 2, len(seeds)), number)
    if interpreted():
        for run, seed in enumerate(seeds):
            noise[..., run] = sensor_noise(None if seed == NO_SEED else int(seed), cycles, joints)
    else:
        fill_noise(seed_streams(seeds), ziggurat_tables(), noise)
    return noise


@cache
def ziggurat_tables() -> Ziggurat:
    """Return the compiler's tables of the normal distribution."""
    # Its file alone: importing the compiler takes a second, and here nothing is compiled.
    package = find_spec("numba")
    assert package is not None  # layflat depends on it
    assert package.submodule_search_locations is not None
    path = Path(package.submodule_search_locations[0], "np", "random", "_constants.py")
    spec = spec_from_file_location("layflat_ziggurat", path)
    assert spec is not None  # as of any file of Python
    assert spec.loader is not None
    tables = module_from_spec(spec)
    spec.loader.exec_module(tables)
    return Ziggurat(
        tables.ki_double,
        tables.wi_double,
        tables.fi_double,
        float(tables.ziggurat_nor_r),
        float(tables.ziggurat_nor_inv_r),
    )


def seed_streams(seeds: Seeds) -> NDArray[np.uint64]:
    """Return the initial generator of each run: state and step by halves, then whether it has noise, (5, runs)."""
    hashed = _hash_seeds(seeds)
    halves = [hashed[i] | hashed[i + 1].astype(np.uint64) << np.uint64(32) for i in range(0, STATE_WORDS, 2)]
    return np.array([*halves, (seeds != NO_SEED).astype(np.uint64)])


def _hash_seeds(seeds: Seeds) -> list[Words]:
    """Return eight 32-bit words for each seed, as `SeedSequence(seed).generate_state(8)`."""
    entropy = [(seeds & 0xFFFFFFFF).astype(np.uint32), (seeds >> 32).astype(np.uint32)]
    constants = _constants(BEGIN_POOL, NEXT_POOL)
    pool = [_hash_word(word, *next(constants)) for word in [*entropy, *[np.zeros_like(entropy[0])] * (POOL_WORDS - 2)]]
    for source in range(POOL_WORDS):
        for place in range(POOL_WORDS):
            if place != source:
                mixed = MIX_LEFT * pool[place] - MIX_RIGHT * _hash_word(pool[source], *next(constants))
                pool[place] = mixed ^ mixed >> np.uint32(16)
    constants = _constants(BEGIN_WORDS, NEXT_WORDS)
    return [_hash_word(pool[i % POOL_WORDS], *next(constants)) for i in range(STATE_WORDS)]


def _constants(first: int, factor: int) -> Iterator[tuple[np.uint32, np.uint32]]:
    """Yield each multiplier of the hash with the one after it."""
    while True:
        following = first * factor & 0xFFFFFFFF
        yield np.uint32(first), np.uint32(following)
        first = following


def _hash_word(word: Words, before: np.uint32, after: np.uint32) -> Words:
    """Return 32-bit words hashed with a multiplier and the one after it."""
    stirred: Words = (word ^ before) * after
    return stirred ^ stirred >> np.uint32(16)
