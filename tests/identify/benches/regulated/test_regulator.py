import pytest
from hypothesis import given
from hypothesis import strategies as st

from layflat.identify.benches.regulated.laws import (
    Regulator,
    asked_set_point,
    regulator_conductances,
    regulator_opening,
    share_in,
)
from layflat.physics.flow import laminar_slope

VALVE = Regulator(1.05, -2e4, 0.04, 2e-10, 3e-10, 5e4, 8e4, 0.3, laminar_slope(0.3))
pressures = st.floats(1e5, 8e5)


@given(pressures, pressures)
def test_only_the_side_towards_the_set_point_is_open(s: float, p: float) -> None:
    C_in, C_out = regulator_conductances(VALVE, s, p)
    assert C_in * C_out == 0.0
    assert (C_in > 0.0) == (s > p)
    assert (C_out > 0.0) == (s < p)


@pytest.mark.parametrize(
    ("error", "opening"), [(0.0, 0.0), (2.5e4, 0.5), (5e4, 1.0), (3e5, 1.0), (-4e4, -0.5), (-3e5, -1.0)]
)
def test_it_opens_in_proportion_to_the_error_up_to_its_bands(error: float, opening: float) -> None:
    assert regulator_opening(VALVE, 4e5 + error, 4e5) == pytest.approx(opening, abs=1e-12)


def test_its_gain_and_offset_count_from_ambient_pressure() -> None:
    assert asked_set_point(VALVE, 1e5, 1e5) == pytest.approx(1e5 - 2e4)
    assert asked_set_point(VALVE, 5e5, 1e5) == pytest.approx(1e5 + 1.05 * 4e5 - 2e4)


@given(st.floats(1e-5, 0.1), st.floats(1e-3, 1.0))
def test_two_half_steps_of_a_lag_make_a_whole_one(h: float, lag: float) -> None:
    half = share_in(0.5 * h, lag)
    assert 1.0 - (1.0 - half) ** 2 == pytest.approx(share_in(h, lag), rel=1e-9)
