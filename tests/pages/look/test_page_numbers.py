"""Whatever a browser sends is a finite number, or none."""

import math
from typing import Any

import pytest

from layflat.pages.look.theme import clamp_number, finite_number


@pytest.mark.parametrize("value", [None, "", "3", "nan", True, [1.0], {"value": 1}, math.nan, math.inf, 10**400])
def test_what_is_no_number_is_none(value: Any) -> None:
    assert finite_number(value) is None
    assert clamp_number(value, 0.0, 1.0, 0.5) == 0.5


def test_numbers_are_kept_and_brought_inside_limits() -> None:
    assert finite_number(3) == 3.0
    assert [clamp_number(value, 2.0, 60.0, 15.0) for value in (-5, 2, 7.5, 1e9)] == [2.0, 2.0, 7.5, 60.0]
