from math import pi, sin

import pytest
from hypothesis import given
from hypothesis import strategies as st

from layflat.control.signals import mean4, ripple4

phases = st.floats(0.0, 2 * pi)


def samples(frequency: float, phase: float, amplitude: float = 1.0) -> list[float]:
    """Four samples at 5 ms, newest first."""
    return [amplitude * sin(phase - 2 * pi * frequency * 0.005 * k) for k in range(4)]


@given(phases)
def test_the_mean_is_blind_to_the_dither(phase: float) -> None:
    assert mean4(*samples(50.0, phase)) == pytest.approx(0.0, abs=1e-12)


@given(st.floats(-1e6, 1e6))
def test_the_mean_of_a_constant_is_the_constant(x: float) -> None:
    assert mean4(x, x, x, x) == x
    assert ripple4(x, x, x, x) == 0.0


@given(phases, st.floats(0.0, 1e4))
def test_ripple_is_the_amplitude_of_the_dither(phase: float, amplitude: float) -> None:
    assert ripple4(*samples(50.0, phase, amplitude)) == pytest.approx(amplitude, rel=1e-9, abs=1e-12)


@given(st.floats(-1e3, 1e3), st.floats(-10.0, 10.0))
def test_the_mean_lags_a_ramp_by_one_and_a_half_cycles(x: float, slope: float) -> None:
    assert mean4(*[x - slope * k for k in range(4)]) == pytest.approx(x - 1.5 * slope, abs=1e-9)
