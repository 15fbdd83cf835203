from math import exp

import pytest
from hypothesis import given
from hypothesis import strategies as st

from layflat.identify.benches.regulated.laws import LaggingFriction, next_level, settled_level, share_in

angles = st.floats(-1.5, 1.5)


@given(angles, st.floats(-3.0, 3.0))
def test_friction_is_positive_wherever_the_joint_is(q: float, fade: float) -> None:
    assert settled_level(LaggingFriction(0.2, fade, 3.0), q) > 0.0


def test_without_fade_it_is_coulomb_friction() -> None:
    friction = LaggingFriction(0.2, 0.0, 3.0)
    assert next_level(friction, 0.2, 1.2, 0.5) == 0.2


@given(angles)
def test_a_joint_that_stays_settles_exponentially(q: float) -> None:
    friction, h, F = LaggingFriction(0.2, 0.9, 2.0), 1e-3, 0.5
    for _ in range(3000):
        F = next_level(friction, F, q, share_in(h, friction.lag))
    settled = settled_level(friction, q)
    assert pytest.approx(settled + (0.5 - settled) * exp(-3.0 / 2.0), rel=1e-9) == F
