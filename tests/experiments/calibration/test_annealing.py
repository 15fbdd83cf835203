"""Populations that are annealed find the distribution that they are asked for."""

import numpy as np
import pytest
from scipy.special import ndtri
from scipy.stats import norm

from layflat.arrays import Array
from layflat.experiments.calibration.annealing import Population, anneal

COLDEST = 0.2


def bowl(shares: Array, seed: int) -> Array:
    """A cost whose machines at a temperature have normal deviates: their variances are known."""
    return np.asarray(np.square(ndtri(shares[:, 0]) - 1.0))


def last(seed: int, populations: int = 60) -> list[Population]:
    found = []
    for population in anneal(bowl, 3, machines=100, seed=seed, coldest=COLDEST):
        found.append(population)
        if len(found) == populations:
            break
    return found


def test_the_coldest_population_is_spread_as_it_must_be() -> None:
    cold = [one for one in last(1) if one.temperature == COLDEST]
    deviates = ndtri(np.concatenate([one.shares for one in cold[5:]]))
    variance = 1.0 / (1.0 + 2.0 / COLDEST)
    mean = variance * 2.0 / COLDEST
    assert deviates[:, 0].mean() == pytest.approx(mean, abs=0.05)
    assert deviates[:, 0].var() == pytest.approx(variance, rel=0.2)
    # What the cost does not ask for stays as it was drawn.
    assert norm.cdf(deviates[:, 1:]).mean() == pytest.approx(0.5, abs=0.05)
    assert deviates[:, 1:].var() == pytest.approx(1.0, rel=0.25)


def test_temperatures_fall_and_the_same_seed_draws_the_same() -> None:
    one, same = last(3, 8), last(3, 8)
    temperatures = [population.temperature for population in one]
    assert temperatures == sorted(temperatures, reverse=True)
    assert all(np.array_equal(a.shares, b.shares) for a, b in zip(one, same, strict=True))
    assert one[-1].costs == pytest.approx(bowl(one[-1].shares, 0), abs=1e-4)
