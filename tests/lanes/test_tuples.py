from typing import Any, NamedTuple

import numpy as np
import pytest

from layflat.jit import by_kind, composition, kernel, law
from layflat.lanes import Lanes, each, gather, slots, zero_if_finite


class Share(NamedTuple):
    of: float


class Twice(NamedTuple):
    of: float


@law
def taken(share: Any, number: float) -> Any:
    return share.of * number


@law
def doubled(twice: Any, number: float) -> Any:
    return 2.0 * number + twice.of


taking = by_kind({Share: taken, Twice: doubled})


@law
def both(share: Any, number: float) -> Any:
    return Share(share.of + number), share.of * number


@composition
def all_of_them(shares: Any, numbers: Any) -> Any:
    products = each(taking, shares, numbers)
    after, again = each(both, shares, numbers)
    kept = slots(again)
    return products, after, gather(shares, kept)


@kernel
def run(shares: Any, row: Any) -> Any:
    return all_of_them(shares, gather(shares, row))


def test_a_law_goes_through_the_items_of_tuples() -> None:
    shares, row = (Share(0.5), Share(0.25), Share(3.0)), np.array([2.0, 8.0, 1.0, 99.0])
    expected = ((1.0, 2.0, 3.0), (Share(2.5), Share(8.25), Share(4.0)), (1.0, 2.0, 3.0))
    assert run(shares, row) == expected
    assert all_of_them(shares, gather(shares, row)) == expected


def test_one_item_is_a_tuple_of_one_and_the_kind_picks_the_law() -> None:
    found = run((Share(0.5),), np.array([4.0]))
    assert found == ((2.0,), (Share(4.5),), (2.0,))
    assert each(taking, (Twice(1.0),), (4.0,)) == (9.0,)


def test_items_may_be_lanes() -> None:
    after, product = each(both, (Share(Lanes((1.0, 2.0))),), (Lanes((3.0, 4.0)),))  # type: ignore[arg-type]
    assert after == (Share(Lanes((4.0, 6.0))),)  # type: ignore[arg-type]
    assert product == (Lanes((3.0, 8.0)),)


@kernel
def flaw(shares: Any, number: float) -> Any:
    return zero_if_finite((shares, (number, number)))


@pytest.mark.parametrize("number", [0.0, -1e308, np.inf, -np.inf, np.nan])
def test_one_number_that_is_not_finite_is_found_wherever_it_stands(number: float) -> None:
    good = (Share(0.5), Share(1e308))
    for shares, last in ((good, number), ((Share(0.5), Share(number)), 1.0), ((Share(number), Share(0.5)), 1.0)):
        expected = 0.0 if np.isfinite(number) else np.nan
        assert np.array_equal(flaw(shares, last), expected, equal_nan=True)
        assert np.array_equal(zero_if_finite((shares, (last, last))), expected, equal_nan=True)
    assert np.array_equal(zero_if_finite((Lanes((1.0, number)), Lanes((2.0, 3.0)))), (0.0, expected), equal_nan=True)
