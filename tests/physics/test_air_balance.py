"""The watch over the hoses' air against cases that can be told by hand."""

from math import inf

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from layflat.physics.air import REFERENCE_DENSITY
from layflat.physics.air_balance import REFERENCE_PRESSURE, AirEstimate, AirObserverParameters, update_air_estimate
from layflat.physics.flow import laminar_slope

PARTS = AirObserverParameters(
    2e-4, 2e-4, 0.9, 2e-8, 0.0, inf, 0.3, float(laminar_slope(0.3)), 0.02, 0.0, 40.0, 0.05, 14.0
)
SUPPLY, EXHAUST, CYCLE = 5e5, 1e5, 0.005


def cycles(count: int, opening: float, measured: float, estimate: AirEstimate, angle: float = 0.0) -> AirEstimate:
    for _ in range(count):
        estimate = update_air_estimate(PARTS, estimate, opening, angle, measured, SUPPLY, EXHAUST, CYCLE)
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
    after = update_air_estimate(PARTS, before, 0.0, 1.3, 0.0, SUPPLY, EXHAUST, CYCLE)
    assert abs(after.residual) < 0.1


@given(st.floats(0.005, 3600.0), st.floats(-1.0, 1.0), st.floats(-2e5, 2e5))
def test_a_pause_leaves_pressures_that_can_be(elapsed: float, opening: float, measured: float) -> None:
    before = AirEstimate(3e5, 3e5, 0.0, 0.0)
    after = update_air_estimate(PARTS, before, opening, 0.0, measured, SUPPLY, EXHAUST, elapsed)
    assert 0.5 * EXHAUST <= after.pressure_a <= 1.5 * SUPPLY
    assert 0.5 * EXHAUST <= after.pressure_b <= 1.5 * SUPPLY


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_pressures_stay_above_half_of_the_exhausts(side: float) -> None:
    estimate = cycles(400, 0.0, side * 3e6, AirEstimate(3e5, 3e5, 0.0, 0.0))
    assert min(estimate.pressure_a, estimate.pressure_b) == 0.5 * EXHAUST


def rate(parts: AirObserverParameters, opening: float, angle: float = 0.0) -> tuple[float, float]:
    """How fast the estimates of both hoses change at first, Pa/s."""
    elapsed, before = 1e-6, AirEstimate(3e5, 2.5e5, 0.0, 0.0)
    after = update_air_estimate(parts, before, opening, elapsed * angle, 5e4, SUPPLY, EXHAUST, elapsed)
    return (after.pressure_a - 3e5) / elapsed, (after.pressure_b - 2.5e5) / elapsed


@pytest.mark.parametrize("opening", [-0.3, 0.01, 0.25])
def test_dither_lets_through_what_its_openings_do_in_the_mean(opening: float) -> None:
    dither = 0.15
    dithered = rate(PARTS._replace(dither=dither), opening)
    places = opening + dither * (np.arange(2000) + 0.5 - 1000) / 1000
    mean = np.mean([rate(PARTS, place) for place in places], axis=0)
    assert dithered == pytest.approx(mean, rel=1e-3)


def test_a_tube_lets_through_what_two_resistances_in_series_do() -> None:
    through = PARTS.conductance
    narrowed = rate(PARTS._replace(line_conductance=0.5 * through), 1.0)
    assert narrowed == pytest.approx(np.array(rate(PARTS, 1.0)) / np.sqrt(5.0), rel=1e-3)


def test_a_valve_that_is_asked_for_more_than_full_opening_opens_fully() -> None:
    assert rate(PARTS, 1.5) == rate(PARTS, 1.0)
    assert rate(PARTS, 1.0) != pytest.approx(rate(PARTS, 0.9), rel=0.05)


def test_a_leak_is_there_with_the_valve_shut() -> None:
    leaks = PARTS._replace(leakage=0.1 * PARTS.conductance)
    # Both paths of both hoses: what comes from the supply less what goes to the exhaust.
    whole = np.add(rate(PARTS, 1.0), rate(PARTS, -1.0))
    assert rate(leaks, 0.0) == pytest.approx(0.1 * whole, rel=1e-3)


def test_a_joint_that_turns_expands_the_air_of_one_hose_and_compresses_the_other() -> None:
    velocity = 2.0
    volume = PARTS.dead_volume + PARTS.torque_constant * PARTS.neutral
    turning = np.array([-3e5, 2.5e5]) * PARTS.torque_constant * velocity / volume
    assert rate(PARTS, 0.0, velocity) == pytest.approx(turning, rel=1e-3)
    assert rate(PARTS, 0.0, 10.0 * PARTS.fastest) == pytest.approx(turning * PARTS.fastest / velocity, rel=1e-3)


@pytest.mark.parametrize("angle", [PARTS.neutral, -PARTS.neutral, 1.5, -1.5, 2.4, -2.4])
def test_a_hose_that_is_all_peeled_has_its_dead_volume_and_beyond_at_least_half_of_it(angle: float) -> None:
    elapsed, opening = 1e-6, 1.0
    after = update_air_estimate(PARTS, AirEstimate(3e5, 3e5, angle, 0.0), opening, angle, 0.0, SUPPLY, EXHAUST, elapsed)
    free = PARTS.dead_volume + PARTS.torque_constant * (PARTS.neutral + np.array([angle, -angle]))
    volumes = np.maximum(free, 0.5 * PARTS.dead_volume)
    grows, falls = (after.pressure_a - 3e5) * volumes[0], (3e5 - after.pressure_b) * volumes[1]
    middle = update_air_estimate(PARTS, AirEstimate(3e5, 3e5, 0.0, 0.0), opening, 0.0, 0.0, SUPPLY, EXHAUST, elapsed)
    even = PARTS.dead_volume + PARTS.torque_constant * PARTS.neutral
    assert (grows, falls) == pytest.approx(
        ((middle.pressure_a - 3e5) * even, (3e5 - middle.pressure_b) * even), rel=1e-3
    )


def test_the_residual_is_the_pull_of_the_measured_difference_over_what_an_open_valve_lets_in() -> None:
    elapsed, angle, difference = 1e-6, 0.4, 2e4
    parts = PARTS._replace(smoothing=elapsed)
    after = update_air_estimate(
        parts, AirEstimate(3e5, 3e5, angle, 0.0), 0.0, angle, difference, SUPPLY, EXHAUST, elapsed
    )
    volumes = parts.dead_volume + parts.torque_constant * (parts.neutral + np.array([angle, -angle]))
    # Air that comes in at the speed of sound raises the pressure by p_0 C p_s / V a second (ISO 6358).
    full = np.mean(1.185 * 287.05 * 293.15 * parts.conductance * SUPPLY / volumes)
    assert after.residual == pytest.approx(parts.follow * difference / full, rel=1e-4)


@given(st.floats(0.1, 1.0))
def test_air_taken_from_the_supply_is_what_the_hoses_gained(opening: float) -> None:
    parts, estimate = PARTS._replace(follow=0.0), AirEstimate(2e5, EXHAUST, 0.1, 0.0)
    for _ in range(100):
        estimate = update_air_estimate(parts, estimate, opening, 0.1, 0.0, SUPPLY, EXHAUST, CYCLE)
    volume = parts.dead_volume + parts.torque_constant * (parts.neutral + 0.1)
    gained = REFERENCE_DENSITY * (estimate.pressure_a - 2e5) * volume / REFERENCE_PRESSURE
    assert gained > 0.0
    assert estimate.taken == pytest.approx(gained, rel=1e-9)
