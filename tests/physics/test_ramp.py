import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from layflat.physics.ramp import mean_above_zero


@given(st.floats(-10.0, 10.0), st.floats(-10.0, 10.0))
def test_it_is_the_mean_of_the_positive_part(a: float, b: float) -> None:
    expected = np.trapezoid(np.maximum(np.linspace(a, b, 20001), 0.0), dx=1 / 20000)
    assert mean_above_zero(a, b) == pytest.approx(expected, rel=1e-6, abs=1e-7)


def test_at_rest_on_either_side_and_on_the_edge() -> None:
    assert mean_above_zero(2.0, 2.0) == 2.0
    assert mean_above_zero(-2.0, -2.0) == 0.0
    assert mean_above_zero(0.0, 0.0) == 0.0
