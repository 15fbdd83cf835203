from math import cos, pi, sin

import pytest
from hypothesis import given
from hypothesis import strategies as st

from layflat.physics.trig import sincos, wrap_angle


@given(st.floats(-pi, pi))
def test_sine_and_cosine_to_1e_12(x: float) -> None:
    s, c = sincos(x)
    assert s == pytest.approx(sin(x), abs=1e-12)
    assert c == pytest.approx(cos(x), abs=1e-12)


@given(st.floats(1e-300, 1e-3))
def test_small_sines_keep_their_digits(x: float) -> None:
    assert sincos(x)[0] == pytest.approx(sin(x), rel=1e-14)


def test_zero_is_exact() -> None:
    assert sincos(0.0) == (0.0, 1.0)


@given(st.floats(-40.0, 40.0))
def test_angles_come_within_half_a_turn(x: float) -> None:
    near = wrap_angle(x)
    assert abs(near) <= pi + 1e-12
    assert cos(near - x) == pytest.approx(1.0, abs=1e-12)
    assert near.hex() == x.hex() or abs(x) > pi - 1e-9
