from math import cos, pi, sin

import pytest
from hypothesis import given
from hypothesis import strategies as st

from layflat.physics.driver import advance_dither, start_dither

H = 2.5e-4


@given(st.floats(0.0, 3600.0), st.floats(5.0, 200.0))
def test_dither_starts_where_its_time_says(t: float, f: float) -> None:
    dither = start_dither(f, t, H)
    # The phase after an hour is known to the rounding of its number of cycles.
    assert dither.sine == pytest.approx(sin(2 * pi * f * (t + 0.5 * H)), abs=1e-9)
    assert dither.cosine == pytest.approx(cos(2 * pi * f * (t + 0.5 * H)), abs=1e-9)


@given(st.floats(5.0, 200.0), st.integers(1, 100))
def test_turning_keeps_to_the_sine(f: float, n: int) -> None:
    dither = start_dither(f, 0.0, H)
    for _ in range(n):
        dither = advance_dither(dither)
    assert dither.sine == pytest.approx(sin(2 * pi * f * (n + 0.5) * H), abs=1e-11)
    assert dither.cosine == pytest.approx(cos(2 * pi * f * (n + 0.5) * H), abs=1e-11)
