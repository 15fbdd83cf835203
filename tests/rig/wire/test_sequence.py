from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from layflat.rig.wire.sequence import ROUND, following, is_later

numbers = st.integers(0, ROUND - 1)


@given(numbers, st.integers(1, ROUND // 2 - 1))
def test_what_follows_is_later_and_never_the_other_way_round(number: int, steps: int) -> None:
    later = (number + steps) % ROUND
    assert is_later(later, number)
    assert not is_later(number, later)


@given(numbers)
def test_a_number_is_not_later_than_itself(number: int) -> None:
    assert not is_later(number, number)
    assert is_later(following(number), number)
    assert is_later(number, None)
