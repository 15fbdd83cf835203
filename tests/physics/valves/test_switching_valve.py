from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from layflat.physics.valves.switching import (
    SwitchState,
    duty,
    move_pair,
    pair_opening,
    shut,
    start_carrier,
    switch_on_and_off,
    turn_carrier,
)
from tests.physics.plants import PAIR

SWITCH, T = PAIR.switch, 1.0 / PAIR.frequency
SHUT = SwitchState(0.0, 0.0)
shares = st.floats(0.0, 1.0)


def opened(D: float, steps: int, periods: int = 1) -> tuple[SwitchState, float]:
    """State after some periods of the carrier in steps, from shut, and the integral of the opening in the last one."""
    state, total = SHUT, 0.0
    for _ in range(periods):
        total = 0.0
        for k in range(steps):
            state, mean = switch_on_and_off(SWITCH, state, D, k / steps, 1 / steps, T / steps)
            total += mean * T / steps
    return state, total


def plain(D: float, instants: int = 20000) -> float:
    """The same integral by the smallest of steps, from shut."""
    c, x, total, h = 0.0, 0.0, 0.0, T / instants
    for k in range(instants):
        on = (k + 0.5) / instants < D
        if on and c >= 1.0:
            x = min(x + h / SWITCH.opening_time, 1.0)
        if not on and c <= 0.0:
            x = max(x - h / SWITCH.closing_time, 0.0)
        c = min(c + h / SWITCH.opening_delay, 1.0) if on else max(c - h / SWITCH.closing_delay, 0.0)
        total += x * h
    return total


@pytest.mark.parametrize("D", [0.0, 0.08, 0.13, 0.2, 0.5, 0.95, 1.0])
def test_a_period_is_that_of_the_finest_steps(D: float) -> None:
    assert opened(D, 57)[1] == pytest.approx(plain(D), abs=2e-3 * T)


@pytest.mark.parametrize("D", [0.15, 0.2, 0.5, 0.8])
def test_a_pulse_is_late_by_the_delays_and_half_the_ways(D: float) -> None:
    late = SWITCH.opening_delay + 0.5 * SWITCH.opening_time
    longer = SWITCH.closing_delay + 0.5 * SWITCH.closing_time
    on = D * T
    if on >= SWITCH.opening_delay + SWITCH.opening_time:
        assert opened(D, 40)[1] == pytest.approx(on - late + longer, rel=1e-9)
    else:
        assert opened(D, 40)[1] < on - late + longer + 1e-4


def test_a_pulse_shorter_than_the_delay_opens_nothing() -> None:
    assert opened(0.99 * SWITCH.opening_delay / T, 33)[1] == 0.0
    assert opened(1.2 * SWITCH.opening_delay / T, 33)[1] > 0.0


def test_a_pause_shorter_than_the_delay_shuts_nothing() -> None:
    state, total = opened(1.0 - 0.9 * SWITCH.closing_delay / T, 33, periods=3)
    assert state.opening == 1.0
    assert total == pytest.approx(T, rel=1e-12)


@given(shares, shares, shares, st.floats(0.0, 0.99), st.floats(0.01, 0.99), st.floats(1e-3, 1.0))
def test_two_parts_of_a_step_make_the_step(
    c: float, x: float, D: float, phase: float, part: float, gain: float
) -> None:
    state, h = SwitchState(c, x), gain * T
    whole, mean = switch_on_and_off(SWITCH, state, D, phase, gain, h)
    first, mean_1 = switch_on_and_off(SWITCH, state, D, phase, part * gain, part * h)
    middle = phase + part * gain
    last, mean_2 = switch_on_and_off(SWITCH, first, D, middle % 1.0, (1 - part) * gain, (1 - part) * h)
    assert last == pytest.approx(whole, abs=1e-9)
    assert part * mean_1 + (1 - part) * mean_2 == pytest.approx(mean, abs=1e-9)


def test_duty_grows_from_the_least_pulse_to_one() -> None:
    assert duty(PAIR, -0.5) == duty(PAIR, 0.0) == duty(PAIR, PAIR.dead_band) == 0.0
    grows = [float(duty(PAIR, u)) for u in np.linspace(PAIR.dead_band + 1e-12, 1.0, 9)]
    assert grows[0] == pytest.approx(PAIR.min_pulse * PAIR.frequency, abs=1e-9)
    assert all(a < b for a, b in pairwise(grows))
    assert grows[-1] == duty(PAIR, 1.5) == 1.0


def conductances(command: float, periods: int = 4) -> tuple[float, float, float]:
    """Mean conductances over the last period, and the net opening at its end."""
    h, state, wave = T / 50, shut(PAIR), start_carrier(PAIR, 0.0, T / 50)
    fills, vents = [], []
    for _ in range(50 * periods):
        state, fill, vent = move_pair(PAIR, state, command, wave, h)
        wave = turn_carrier(PAIR, wave)
        fills.append(fill)
        vents.append(vent)
    return float(np.mean(fills[-50:])), float(np.mean(vents[-50:])), float(pair_opening(PAIR, state))


def test_valves_that_have_been_shut_for_long_stay_as_they_are_without_a_command() -> None:
    state, fill, vent = move_pair(PAIR, shut(PAIR), 0.0, start_carrier(PAIR, 0.0, T / 50), T / 50)
    assert state == shut(PAIR)
    assert fill == vent == PAIR.leakage


def test_a_command_opens_one_way_and_its_opposite_the_other() -> None:
    fill, vent, _ = conductances(0.4)
    assert vent == pytest.approx(PAIR.leakage)
    assert 10.0 * PAIR.leakage < fill < 0.5 * PAIR.conductance
    assert conductances(-0.4)[:2] == (vent, fill)
    assert conductances(0.0) == pytest.approx((PAIR.leakage, PAIR.leakage, 0.0))
    assert conductances(1.0) == pytest.approx((PAIR.conductance, PAIR.leakage, 1.0))
    assert conductances(-1.0)[2] == -1.0


def test_a_carrier_goes_on_where_it_was() -> None:
    h = 2.5e-4
    wave = start_carrier(PAIR, 0.0, h)
    for _ in range(333):
        wave = turn_carrier(PAIR, wave)
    assert wave.phase == pytest.approx(start_carrier(PAIR, 333 * h, h).phase, abs=1e-9)
    assert start_carrier(PAIR, 0.3, 1.0).gain == 1.0
