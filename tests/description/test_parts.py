"""Rules that parts of descriptions share."""

import pytest
from pydantic import ValidationError

from layflat.description import Part, ordered


class Below(Part):
    """Two values in order."""

    low: float
    high: float
    _ordered = ordered("low", "high", "low must be below high")


class AtMost(Below):
    """The same, where they may be equal."""

    _ordered = ordered("low", "high", "low must not be above high", may_equal=True)


@pytest.mark.parametrize(("part", "low", "high", "problem"), [
    (Below, 1.0, 2.0, None), (Below, 2.0, 2.0, "low must be below high"), (Below, 3.0, 2.0, "low must be below high"),
    (AtMost, 1.0, 2.0, None), (AtMost, 2.0, 2.0, None), (AtMost, 3.0, 2.0, "low must not be above high"),
])  # fmt: skip
def test_values_out_of_order_are_refused(part: type[Below], low: float, high: float, problem: str | None) -> None:
    if problem is None:
        assert part(low=low, high=high).high == high
    else:
        with pytest.raises(ValidationError, match=problem):
            part(low=low, high=high)
