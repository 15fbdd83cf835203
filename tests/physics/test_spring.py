"""Springs on shafts."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from layflat.physics.spring import NoSpring, Spring, spring_energy, spring_torque

numbers = st.floats(-30.0, 30.0)


@given(numbers, st.floats(0.0, 50.0), st.floats(-1.2, 1.2))
def test_its_torque_is_the_slope_of_its_energy(torque: float, stiffness: float, q: float) -> None:
    spring, d = Spring(torque, stiffness), 1e-4
    slope = (spring_energy(spring, q + d) - spring_energy(spring, q - d)) / (2.0 * d)
    assert spring_torque(spring, q) == pytest.approx(-slope, abs=1e-6)


@given(numbers)
def test_none_changes_no_bit(torque: float) -> None:
    assert (torque + spring_torque(NoSpring(), 0.3)).hex() == torque.hex()
    assert (-0.0 + spring_torque(NoSpring(), 0.3)).hex() == (-0.0).hex()
