import pytest
from hypothesis import given
from hypothesis import strategies as st

from layflat.physics.stop import Stops, stop_damping, stop_energy, stop_torque

STOPS = Stops(1.0, 50.0, 1.2, 2000.0, 5.0)


@given(st.floats(-1.0, 1.0))
def test_nothing_acts_within_the_stroke(q: float) -> None:
    assert stop_torque(STOPS, q) == stop_energy(STOPS, q) == stop_damping(STOPS, q) == 0.0


@given(st.floats(1.001, 2.0))
def test_both_sides_push_back_alike(q: float) -> None:
    assert stop_torque(STOPS, q) < 0.0
    assert stop_torque(STOPS, -q) == -stop_torque(STOPS, q)
    assert stop_damping(STOPS, q) == stop_damping(STOPS, -q) == (5.0 if q > STOPS.stop_angle else 0.0)


@given(st.floats(-2.0, 2.0))
def test_torque_is_the_slope_of_the_energy(q: float) -> None:
    d = 1e-6
    slope = (stop_energy(STOPS, q + d) - stop_energy(STOPS, q - d)) / (2 * d)
    assert stop_torque(STOPS, q) == pytest.approx(-slope, abs=1e-2)
