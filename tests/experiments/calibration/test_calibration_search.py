import numpy as np
import pytest

from layflat.arrays import Array
from layflat.experiments.calibration.effort import CLAIMED, ROUGHLY_CLAIMED, Effort
from layflat.experiments.calibration.search import DESCENTS, NEARLY, SURELY, Best, Sought, search
from layflat.experiments.calibration.walk import APART_WALKS


def parts(shares: Array, seed: int, effort: Effort) -> dict[str, Array]:
    """Two shortfalls that vanish in a corner, and noise while searching."""
    noise = 0.0 if effort is CLAIMED else 0.01 * np.random.default_rng(seed).random(len(shares))
    return {"first": 30.0 * np.abs(shares[:, 0] - 0.2), "rest": 30.0 * np.abs(shares[:, 1:] - 0.7).sum(axis=1) + noise}


def lack(shares: Array, seed: int, effort: Effort, level: Array) -> Array:
    """As a look does that ends where too much is lacked."""
    found = parts(shares, seed, effort)
    return np.where(found["first"] > level, found["first"], found["first"] + found["rest"])


def denied(shares: Array) -> str:
    found = parts(shares[None], 0, CLAIMED)
    return "" if sum(one[0] for one in found.values()) < 0.3 else max(found, key=lambda name: found[name][0])


SOUGHT = Sought(parts, lack, denied)


def last(seed: int, seconds: float = 30.0, first: Array | None = None) -> Best:
    *_, (best, _, _) = search(SOUGHT, first, 3, seed=seed, seconds=seconds)
    return best


def test_a_search_finds_where_nothing_is_short_and_repeats_itself() -> None:
    one, same = last(3), last(3)
    assert one.agrees
    assert one.cost <= NEARLY
    assert np.array_equal(one.shares, same.shares)
    assert one.shares == pytest.approx([0.2, 0.7, 0.7], abs=0.02)


def test_a_search_may_begin_where_one_ended() -> None:
    assert last(5, first=np.array([0.2, 0.7, 0.7])).rounds <= 1


def test_a_search_ends_when_its_time_is_over() -> None:
    best, _, left = list(search(SOUGHT, None, 3, seed=1, seconds=0.0))[-1]
    assert not best.agrees
    assert best.rounds <= 1
    assert left <= 0.0


def test_a_search_that_is_stuck_begins_anew_elsewhere() -> None:
    asked = set[int]()

    def hopeless(shares: Array, seed: int, effort: Effort, level: Array) -> Array:
        number = seed // APART_WALKS % DESCENTS
        asked.add(number)
        return lack(shares, seed, effort, level) + (3.0 if number == 0 else 0.0)

    *_, (best, _, _) = search(Sought(parts, hopeless, denied), None, 3, seed=2, seconds=60.0)
    assert best.agrees
    assert asked == {0, 1}


def test_a_search_that_is_nearly_low_enough_looks_more_closely() -> None:
    asked = set[int]()

    def dull(shares: Array, seed: int, effort: Effort, level: Array) -> Array:
        asked.add(seed // APART_WALKS % DESCENTS)
        return lack(shares, seed, effort, level) + (0.8 if effort is ROUGHLY_CLAIMED else 0.0)

    *_, (best, _, _) = search(Sought(parts, dull, denied), None, 3, seed=2, seconds=60.0)
    assert best.agrees
    assert asked == {0}


def test_a_search_goes_on_until_a_machine_surely_has_all() -> None:
    soonest = last(4)
    side = np.sign(soonest.shares[0] - 0.2)

    def doubted(shares: Array, seed: int, effort: Effort) -> dict[str, Array]:
        unsure = (effort is not CLAIMED) * 1.5 * SURELY * (np.sign(shares[:, 0] - 0.2) == side)
        return parts(shares, seed, effort) | {"unsure": np.asarray(unsure)}

    def found(doubt: float) -> Best:
        *_, (best, _, _) = search(Sought(doubted, lack, denied), None, 3, seed=4, seconds=60.0, doubt=doubt)
        return best

    assert np.array_equal(found(np.inf).shares, soonest.shares)
    assert found(np.inf).doubt > SURELY >= found(SURELY).doubt
    assert found(SURELY).agrees
    assert np.sign(found(SURELY).shares[0] - 0.2) == -side
