"""Machines that walk where a level lets them."""

import numpy as np
import pytest

from layflat.arrays import Array
from research.cloud.walk import Block, Walk, start_walk

BLOCKS = [Block(slice(0, 2), (0, 1), 1.0), Block(slice(2, 4), (1,), 2.0)]
LEVEL = 0.3


class Counted:
    """Two parts of evidence: the first two values, and the last two; each is a distance from the middle."""

    def __init__(self) -> None:
        self.looks: list[int] = []

    def __call__(self, shares: Array, part: int, noise: int, level: Array) -> Array:  # noqa: ARG002  (as all evidence)
        self.looks.append(part)
        return np.asarray(np.abs(shares[:, 2 * part : 2 * part + 2] - 0.5).sum(axis=1))


def spread(walk: Walk, lacks: Counted) -> Array:
    """Where machines are on a long walk, (places, unknowns)."""
    seen = []
    for _ in range(400):
        walk.goes_on(BLOCKS, lacks, LEVEL)
        seen.append(walk.shares.copy())
    return np.concatenate(seen)


def walked(lacks: Counted, rounds: int, seed: int = 1) -> Walk:
    walk = start_walk(np.random.default_rng(seed).random((64, 4)), 2, lacks, seed)
    while walk.rounds < rounds:
        walk.goes_on(BLOCKS, lacks, LEVEL)
    return walk


def test_machines_end_below_the_level_and_all_over_what_it_leaves() -> None:
    lacks = Counted()
    walk = walked(lacks, 60)
    assert walk.level == LEVEL
    assert np.all(walk.costs <= LEVEL)
    assert walk.costs == pytest.approx(sum(lacks(walk.shares, part, 0, np.zeros(64)) for part in (0, 1)))
    # Of points that lie evenly where the sum of n distances is below a level, this is the variance of each.
    found = spread(walk, lacks)
    assert found.mean(axis=0) == pytest.approx(np.full(4, 0.5), abs=0.01)
    assert found.var(axis=0) == pytest.approx(np.full(4, 2.0 * LEVEL**2 / (5 * 6)), rel=0.1)


def test_machines_that_begin_in_one_place_do_not_stay_together() -> None:
    lacks = Counted()
    walk = start_walk(np.full((64, 4), 0.5), 2, lacks, 1)
    assert spread(walk, lacks)[64 * 20 :].var(axis=0) == pytest.approx(np.full(4, 2.0 * LEVEL**2 / (5 * 6)), rel=0.1)


def test_machines_are_where_they_mostly_pass() -> None:
    def lucky(shares: Array, part: int, noise: int, level: Array) -> Array:
        rng = np.random.default_rng(noise)
        return np.asarray(rng.random(len(shares)) > shares[:, 0], dtype=float)

    walk = start_walk(np.random.default_rng(1).random((128, 1)), 1, lucky, 1)
    walk.level, seen = LEVEL, []
    for _ in range(300):
        walk.goes_on([Block(slice(0, 1), (0,))], lucky, LEVEL)
        seen.append(walk.shares.copy())
    # A place that passes with a chance of x is x times as likely: the mean is that of a density of 2 x.
    assert np.concatenate(seen)[128 * 20 :].mean() == pytest.approx(2.0 / 3.0, abs=0.02)


def test_what_a_block_does_not_touch_is_not_looked_at() -> None:
    lacks = Counted()
    walk = walked(lacks, 5)
    lacks.looks.clear()
    walk.goes_on([BLOCKS[1]], lacks, LEVEL)
    assert set(lacks.looks) == {1}


def test_the_same_seed_walks_the_same_way() -> None:
    assert np.array_equal(walked(Counted(), 30).shares, walked(Counted(), 30).shares)
    assert not np.array_equal(walked(Counted(), 30).shares, walked(Counted(), 30, seed=2).shares)


def test_those_that_lack_least_go_on() -> None:
    walk = start_walk(np.random.default_rng(1).random((64, 4)), 2, Counted(), 1)
    costs = np.sort(walk.costs)
    walk.keep(10)
    assert walk.machines == 10
    assert np.array_equal(walk.costs, costs[:10])


def test_a_level_falls_though_most_machines_share_a_place() -> None:
    shares, lacking = np.full((64, 4), 0.5), np.ones((64, 1))
    shares[:4], lacking[:4] = 0.2, 0.8
    walk = Walk(shares, lacking, seed=1, level=1.0)
    nowhere_else = lambda some, *_: np.full(len(some), 5.0)  # noqa: E731
    walk.goes_on([Block(slice(0, 4), (0,))], nowhere_else, LEVEL)
    assert walk.level == 0.8
    assert np.all(walk.shares == 0.2)
    walk.goes_on([Block(slice(0, 4), (0,))], nowhere_else, LEVEL)
    assert walk.level == 0.8
