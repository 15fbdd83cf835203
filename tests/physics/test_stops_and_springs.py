"""End stops and springs on shafts."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from layflat.physics.stops_and_springs import (
    NoSpring,
    SpringParameters,
    StopParameters,
    spring_energy,
    spring_torque,
    stop_damping,
    stop_energy,
    stop_torque,
)

STOPS = StopParameters(1.0, 50.0, 1.2, 2000.0, 5.0)


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


numbers = st.floats(-30.0, 30.0)


@given(numbers, st.floats(0.0, 50.0), st.floats(-1.2, 1.2))
def test_its_torque_is_the_slope_of_its_energy(torque: float, stiffness: float, q: float) -> None:
    spring, d = SpringParameters(torque, stiffness), 1e-4
    slope = (spring_energy(spring, q + d) - spring_energy(spring, q - d)) / (2.0 * d)
    assert spring_torque(spring, q) == pytest.approx(-slope, abs=1e-6)


@given(numbers)
def test_none_changes_no_bit(torque: float) -> None:
    assert (torque + spring_torque(NoSpring(), 0.3)).hex() == torque.hex()
    assert (-0.0 + spring_torque(NoSpring(), 0.3)).hex() == (-0.0).hex()
