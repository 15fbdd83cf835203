"""Running sums of what stands side by side."""

from typing import Any

import numpy as np
import pytest

from layflat.jit import kernel
from layflat.lanes import Lanes, abreast, apart, sums_from, sums_up_to


@kernel
def both_ways(items: Any) -> Any:
    side = abreast(items)
    return apart(sums_up_to(side, items), items), apart(sums_from(side, items), items)


@pytest.mark.parametrize("n", range(1, 9))
def test_each_item_has_all_before_or_after_it_added(n: int) -> None:
    items = tuple(np.random.default_rng(n).normal(size=n).tolist())
    before, after = both_ways(items)
    assert before == pytest.approx(np.cumsum(items))
    assert after == pytest.approx(np.cumsum(items[::-1])[::-1])
    plain = both_ways.py_func(items) if hasattr(both_ways, "py_func") else both_ways(items)
    assert (before, after) == plain, "the same bits"


def test_what_is_added_to_nothing_keeps_its_bits() -> None:
    assert np.signbit(both_ways((-0.0, 1.0))[0][0])


def test_items_of_several_lanes() -> None:
    items = (Lanes((1.0, 10.0)), Lanes((2.0, 20.0)), Lanes((3.0, 30.0)))
    assert sums_up_to(abreast(items), items) == (1.0, 10.0, 3.0, 30.0, 6.0, 60.0)
    assert sums_from(abreast(items), items) == (6.0, 60.0, 5.0, 50.0, 3.0, 30.0)
