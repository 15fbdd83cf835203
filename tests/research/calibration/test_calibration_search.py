import numpy as np
import pytest

from layflat.arrays import Array
from research.calibration.effort import CLAIM_EFFORT, SINGLE_EFFORT, EvaluationEffort
from research.calibration.search import (
    CLAIM_CHECK_LEVEL,
    DESCENT_COUNT,
    MAX_DESCENTS,
    MAX_RESIDUAL,
    BestMachine,
    SearchTarget,
    noise_seed,
    search,
)

UNKNOWNS = 8
CORNER = np.array([0.2, *(UNKNOWNS - 1) * [0.7]])


def parts(shares: Array, seed: int, effort: EvaluationEffort) -> dict[str, Array]:
    """Two shortfalls that vanish in a corner, and noise while searching."""
    noise = 0.0 if effort is CLAIM_EFFORT else 0.01 * np.random.default_rng(seed).random(len(shares))
    return {"first": 30.0 * np.abs(shares[:, 0] - 0.2), "rest": 30.0 * np.abs(shares[:, 1:] - 0.7).sum(axis=1) + noise}


def lack(shares: Array, seed: int, effort: EvaluationEffort, level: Array) -> Array:
    """As a look does that ends where too much is lacked."""
    found = parts(shares, seed, effort)
    return np.where(found["first"] > level, found["first"], found["first"] + found["rest"])


def denied(shares: Array) -> str:
    found = parts(shares[None], 0, CLAIM_EFFORT)
    return "" if sum(one[0] for one in found.values()) < 0.3 else max(found, key=lambda name: found[name][0])


SOUGHT = SearchTarget(parts, lack, denied)


def number_of(seed: int) -> int:
    """Number of a descent in its search, by the noise that it has."""
    return seed // noise_seed(1, 0) % MAX_DESCENTS


def last(seed: int, seconds: float = 30.0, first: Array | None = None) -> BestMachine:
    *_, (best, _, _) = search(SOUGHT, first, UNKNOWNS, seed=seed, seconds=seconds)
    return best


def test_a_search_finds_where_nothing_is_short_and_repeats_itself() -> None:
    one, same = last(3), last(3)
    assert one.agrees
    assert one.cost <= CLAIM_CHECK_LEVEL
    assert np.array_equal(one.shares, same.shares)
    assert one.shares == pytest.approx(CORNER, abs=0.02)


def test_a_search_may_begin_where_one_ended() -> None:
    assert last(5, first=CORNER).generation == 0


def test_a_search_ends_when_its_time_is_over() -> None:
    best, _, left = list(search(SOUGHT, None, UNKNOWNS, seed=1, seconds=0.0))[-1]
    assert not best.agrees
    assert best.generation <= 10
    assert left <= 0.0


def test_a_search_that_is_stuck_begins_anew_elsewhere() -> None:
    asked = set[int]()

    def led_astray(shares: Array, seed: int, effort: EvaluationEffort, level: Array) -> Array:
        asked.add(number_of(seed))
        return lack(1.0 - shares if number_of(seed) <= DESCENT_COUNT else shares, seed, effort, level)

    *_, (best, _, _) = search(SearchTarget(parts, led_astray, denied), None, UNKNOWNS, seed=2, seconds=60.0)
    assert best.agrees
    assert asked == set(range(1, 1 + 2 * DESCENT_COUNT))


def test_those_of_whose_middle_little_is_lacked_go_on() -> None:
    closely = list[int]()

    def uneven(shares: Array, seed: int, effort: EvaluationEffort, level: Array) -> Array:
        if effort is SINGLE_EFFORT:
            closely.append(number_of(seed))
        return lack(shares if number_of(seed) == 2 else 1.0 - shares, seed, effort, level)

    *_, (best, _, _) = search(SearchTarget(parts, uneven, denied), None, UNKNOWNS, seed=2, seconds=60.0)
    assert best.agrees
    assert set(closely) == {2}


def test_a_search_goes_on_until_a_machine_surely_has_all() -> None:
    def doubted(shares: Array, seed: int, effort: EvaluationEffort) -> dict[str, Array]:
        unsure = (effort is not CLAIM_EFFORT) * 1.5 * MAX_RESIDUAL * (np.abs(shares[:, 0] - 0.2) > 2e-5)
        return parts(shares, seed, effort) | {"unsure": np.asarray(unsure)}

    def found(doubt: float) -> BestMachine:
        *_, (best, _, _) = search(
            SearchTarget(doubted, lack, denied), None, UNKNOWNS, seed=4, seconds=60.0, doubt=doubt
        )
        return best

    soonest, surest = found(np.inf), found(MAX_RESIDUAL)
    assert soonest.agrees
    assert surest.agrees
    assert soonest.doubt > MAX_RESIDUAL >= surest.doubt
    assert (surest.descent, surest.generation) > (soonest.descent, soonest.generation)
