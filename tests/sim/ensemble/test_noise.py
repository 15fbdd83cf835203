"""Noise of many runs: numpy's bits."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from layflat.errors import InputError
from layflat.physics.sensor import sensor_noise
from layflat.sim import Scenario
from layflat.sim.ensemble import ensemble
from layflat.sim.ensemble.seeds import NO_SEED, make_noise, seed_streams

SEEDS = st.integers(0, 2**53)
TAIL = 3.6541528853610088  # of the ziggurat


@given(st.lists(SEEDS, min_size=1, max_size=20))
def test_seeds_are_hashed_as_one_by_one(seeds: list[int]) -> None:
    one_by_one = [np.random.SeedSequence(seed).generate_state(4, np.uint64) for seed in seeds]
    assert np.array_equal(seed_streams(np.array(seeds))[:4], np.transpose(one_by_one))


@given(st.lists(SEEDS | st.just(NO_SEED), min_size=1, max_size=5), st.integers(1, 40), st.integers(1, 4))
def test_a_run_has_its_own_noise_whatever_lies_beside_it(seeds: list[int], cycles: int, joints: int) -> None:
    noise = make_noise(np.array(seeds), (cycles, joints), np.float64)
    for run, seed in enumerate(seeds):
        alone = sensor_noise(None if seed == NO_SEED else seed, len(noise), joints)
        assert np.array_equal(noise[..., run], alone)


def test_the_tail_is_numpys_too() -> None:
    seeds = np.arange(200)
    noise = make_noise(seeds, (1000, 2), np.float64)
    assert np.count_nonzero(abs(noise) > TAIL) > 100
    assert np.array_equal(noise, np.stack([sensor_noise(seed, 1000, 2) for seed in range(200)], axis=-1))
    single = make_noise(seeds, (1000, 2), np.float32)
    assert np.array_equal(single, noise.astype(np.float32))


@pytest.mark.parametrize("seed", [-1.0, 0.5, 2.0**60])
def test_what_is_no_seed_is_told(seed: float) -> None:
    with pytest.raises(InputError, match="vary: seed: holds a number that is no seed; give whole numbers, 0 to"):
        ensemble("paper-arm", Scenario(duration="0.01 s"), {"seed": [0.0, seed]})
