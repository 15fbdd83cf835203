"""The watch over the hoses' air against cases that can be told by hand."""

from math import inf

import pytest
from hypothesis import given
from hypothesis import strategies as st

from layflat.physics.air_balance import AirEstimate, AirParts, follow_air
from layflat.physics.flow import laminar_slope

PARTS = AirParts(2e-4, 2e-4, 0.9, 2e-8, 0.0, inf, 0.3, float(laminar_slope(0.3)), 0.02, 0.0, 40.0, 0.05, 14.0)
SUPPLY, EXHAUST, CYCLE = 5e5, 1e5, 0.005


def cycles(count: int, opening: float, measured: float, estimate: AirEstimate, angle: float = 0.0) -> AirEstimate:
    for _ in range(count):
        estimate = follow_air(PARTS, estimate, opening, angle, measured, SUPPLY, EXHAUST, CYCLE)
    return estimate


def test_a_shut_valve_keeps_the_air_and_nothing_is_amiss() -> None:
    estimate = cycles(200, 0.0, 0.0, AirEstimate(3e5, 3e5, 0.0, 0.0))
    assert estimate == AirEstimate(3e5, 3e5, 0.0, 0.0)


def test_an_open_valve_fills_a_hose_up_to_the_supply_and_empties_the_other() -> None:
    estimate = cycles(400, 1.0, SUPPLY - EXHAUST, AirEstimate(3e5, 3e5, 0.0, 0.0))
    assert estimate.pressure_a == pytest.approx(SUPPLY, rel=1e-3)
    assert estimate.pressure_b == pytest.approx(EXHAUST, rel=1e-3)
    assert abs(estimate.residual) < 0.01


@given(st.floats(0.4, 1.0), st.sampled_from([-1.0, 1.0]))
def test_a_stuck_spool_shows_the_opening_that_it_does_not_take(opening: float, sign: float) -> None:
    estimate = cycles(40, sign * opening, 0.0, AirEstimate(3e5, 3e5, 0.0, 0.0))
    assert -sign * estimate.residual > 0.25


def test_an_angle_that_jumps_is_not_taken_for_motion() -> None:
    before = AirEstimate(3e5, 3e5, 0.0, 0.0)
    after = follow_air(PARTS, before, 0.0, 1.3, 0.0, SUPPLY, EXHAUST, CYCLE)
    assert abs(after.residual) < 0.1


@given(st.floats(0.005, 3600.0), st.floats(-1.0, 1.0), st.floats(-2e5, 2e5))
def test_a_pause_leaves_pressures_that_can_be(elapsed: float, opening: float, measured: float) -> None:
    before = AirEstimate(3e5, 3e5, 0.0, 0.0)
    after = follow_air(PARTS, before, opening, 0.0, measured, SUPPLY, EXHAUST, elapsed)
    assert 0.5 * EXHAUST <= after.pressure_a <= 1.5 * SUPPLY
    assert 0.5 * EXHAUST <= after.pressure_b <= 1.5 * SUPPLY
