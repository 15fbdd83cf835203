import numpy as np
import pytest

from layflat.arrays import Array
from layflat.experiments.calibration import search as found_by
from layflat.experiments.calibration.evidence import FINE, Effort


def bowl(shares: Array, seed: int, effort: Effort) -> dict[str, Array]:
    """Two shortfalls that vanish in a corner, and noise while searching."""
    noise = 0.0 if effort is FINE else 0.01 * np.random.default_rng(seed).random(len(shares))
    return {"first": np.abs(shares[:, 0] - 0.2), "rest": np.abs(shares[:, 1:] - 0.7).sum(axis=1) + noise}


def there(shares: Array) -> bool:
    return bool(sum(part[0] for part in bowl(shares[None], 0, FINE).values()) < 0.02)


def last(seed: int, seconds: float = 20.0, first: Array | None = None) -> found_by.Best:
    *_, (best, _) = found_by.search(bowl, there, first, 3, seed=seed, seconds=seconds)
    return best


def test_a_search_finds_where_nothing_is_short_and_repeats_itself() -> None:
    one, same = last(3), last(3)
    assert there(one.shares)
    assert np.array_equal(one.shares, same.shares)
    assert one.shares == pytest.approx([0.2, 0.7, 0.7], abs=0.02)


def test_a_search_may_begin_where_one_ended() -> None:
    assert last(5, first=np.array([0.2, 0.7, 0.7])).generations <= last(5).generations


def test_a_search_ends_when_its_time_is_over() -> None:
    assert len(list(found_by.search(bowl, there, None, 3, seed=1, seconds=0.0))) == 1
