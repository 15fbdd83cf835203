from math import radians

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from layflat.machine import load
from layflat.motion.trajectory import derived_rates
from layflat.sim import Scenario
from layflat.sim.signals import expand_scenario

T = 0.005
TIMES = T * np.arange(200)


@given(st.floats(0.1, 1.0), st.floats(0.5, 5.0))
def test_a_smooth_demand_has_its_rates(size: float, w: float) -> None:
    v, a = derived_rates(size * np.sin(w * TIMES)[:, None], T)
    middle = w * (TIMES + 0.5 * T)
    assert v[:-2, 0] == pytest.approx(size * w * np.cos(middle[:-2]), abs=1e-3)
    assert a[:-3, 0] == pytest.approx(-size * w * w * np.sin(w * (TIMES + T))[:-3], abs=1e-2)


@given(st.floats(0.01, 1.0), st.integers(1, 198))
def test_a_jump_has_none(size: float, when: int) -> None:
    v, a = derived_rates(np.where(np.arange(200) < when, 0.0, size)[:, None], T)
    assert not v.any()
    assert not a.any()


def test_a_demand_that_sets_off_and_turns_at_once_has_its_velocity_from_there_on() -> None:
    x = np.interp(TIMES, [0.0, 0.2, 0.5, 0.8], [0.0, 0.0, 0.3, 0.0])[:, None]
    v, a = derived_rates(x, T)
    assert v[[39, 40, 99, 100, 159, 160], 0] == pytest.approx([0.0, 1.0, 1.0, -1.0, -1.0, 0.0])
    assert np.abs(a).max() < 1e-6


def test_rates_that_are_given_are_taken() -> None:
    arm = load("paper-arm-fast")
    moves = [(t, [radians(10.0), radians(30.0 * t)]) for t in (T * np.arange(200)).tolist()]
    found = expand_scenario(Scenario(demand=moves, demand_velocity={"small": "30 deg/s"}, duration="1 s"), arm, T)
    assert found.named("demand_velocity")[0] == pytest.approx([0.0, radians(30.0)])
    assert not found.named("demand_acceleration").any()
    given_both = Scenario(
        demand=lambda t: 0.5 * t * t - 0.5, demand_velocity=lambda t: t, demand_acceleration="1 rad/s^2", duration="1 s"
    )
    assert expand_scenario(given_both, arm, T).named("demand_acceleration") == pytest.approx(np.ones((200, 2)))
    jumps = Scenario(demand=[(0.0, "0 deg"), (0.5, "20 deg")], duration="1 s")
    assert not expand_scenario(jumps, arm, T).named("demand_velocity").any()
