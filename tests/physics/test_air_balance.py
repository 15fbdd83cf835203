"""The watch over the hoses' air against cases that can be told by hand."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from layflat.physics.air_balance import AirBelief, AirParts, follow_air
from layflat.physics.flow import laminar_slope

PARTS = AirParts(2e-4, 2e-4, 0.9, 2e-8, 0.0, 0.3, float(laminar_slope(0.3)), 0.02, 0.0, 40.0, 0.05, 14.0)
SUPPLY, EXHAUST, CYCLE = 5e5, 1e5, 0.005


def cycles(count: int, opening: float, measured: float, belief: AirBelief, angle: float = 0.0) -> AirBelief:
    for _ in range(count):
        belief = follow_air(PARTS, belief, opening, angle, measured, SUPPLY, EXHAUST, CYCLE)
    return belief


def test_a_shut_valve_keeps_the_air_and_nothing_is_amiss() -> None:
    belief = cycles(200, 0.0, 0.0, AirBelief(3e5, 3e5, 0.0, 0.0))
    assert belief == AirBelief(3e5, 3e5, 0.0, 0.0)


def test_an_open_valve_fills_a_hose_up_to_the_supply_and_empties_the_other() -> None:
    belief = cycles(400, 1.0, SUPPLY - EXHAUST, AirBelief(3e5, 3e5, 0.0, 0.0))
    assert belief.pressure_a == pytest.approx(SUPPLY, rel=1e-3)
    assert belief.pressure_b == pytest.approx(EXHAUST, rel=1e-3)
    assert abs(belief.surplus) < 0.01


@given(st.floats(0.4, 1.0), st.sampled_from([-1.0, 1.0]))
def test_a_stuck_spool_shows_the_opening_that_it_does_not_take(opening: float, sign: float) -> None:
    belief = cycles(40, sign * opening, 0.0, AirBelief(3e5, 3e5, 0.0, 0.0))
    assert -sign * belief.surplus > 0.25


def test_an_angle_that_jumps_is_not_taken_for_motion() -> None:
    before = AirBelief(3e5, 3e5, 0.0, 0.0)
    after = follow_air(PARTS, before, 0.0, 1.3, 0.0, SUPPLY, EXHAUST, CYCLE)
    assert abs(after.surplus) < 0.1
