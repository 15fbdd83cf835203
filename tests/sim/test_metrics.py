from math import inf

import numpy as np
import pytest
import xarray
from hypothesis import given
from hypothesis import strategies as st

from layflat.sim.metrics import MAX_MOVES, measure_move, measure_moves, settling_time

TIME = np.linspace(0.0, 2.0, 401)


def fake(angle: np.ndarray, demand: np.ndarray) -> xarray.Dataset:
    return xarray.Dataset(
        {"angle": (("time", "joint"), angle[:, None]), "demand": (("time", "joint"), demand[:, None])},
        coords={"time": TIME, "joint": ["a"]},
    )


def test_settling_is_the_last_exit_from_the_band() -> None:
    error = np.where(TIME < 0.5, 1.0, 0.0)
    error[TIME == 1.0] = 1.0
    assert settling_time(TIME, error, 0.1) == pytest.approx(1.005)


def test_never_outside_settles_at_once_and_outside_at_the_end_never() -> None:
    assert settling_time(TIME, np.zeros_like(TIME), 0.1) == 0.0
    assert settling_time(TIME, TIME, 0.1) == inf


@given(st.floats(0.05, 0.5), st.floats(3.0, 20.0))
def test_an_exponential_settles_when_mathematics_says(tau: float, ratio: float) -> None:
    band = 1.0 / ratio
    expected = tau * np.log(ratio)
    if expected < 1.9:
        assert settling_time(TIME, np.exp(-TIME / tau), band) == pytest.approx(expected, abs=0.0051)


def test_overshoot_counts_beyond_the_demand_only() -> None:
    demand = np.ones_like(TIME)
    over = 1.0 + 0.2 * np.exp(-TIME) - 1.2 * np.exp(-5 * TIME)
    assert measure_move(fake(over, demand), "a").overshoot == pytest.approx(np.max(over) - 1.0)
    assert measure_move(fake(1.0 - np.exp(-TIME), demand), "a").overshoot == 0.0


def test_moves_begin_where_a_demand_changes() -> None:
    demand = np.where(TIME < 0.5, 0.0, np.where(TIME < 1.0, 1.0, 0.5))
    found = measure_moves(fake(demand, demand))
    assert [since for since, _ in found] == pytest.approx([0.5, 1.0])
    assert all(one.settling == 0.0 for _, one in found)


def test_a_demand_that_moves_all_the_time_is_one_move() -> None:
    demand = np.sin(TIME)
    assert len(TIME) > MAX_MOVES
    assert len(measure_moves(fake(demand, demand))) == 1


def test_joints_that_nobody_moves_are_not_reported() -> None:
    """Of two joints, the first of which is moved at once and the second later; where none is, all are."""
    time = np.linspace(0.0, 3.0, 301)
    demand = np.column_stack([np.where(time < 1.0, 0.0, 1.0), np.where(time < 2.0, 0.0, 0.5)])
    run = xarray.Dataset(
        {"angle": (("time", "joint"), demand), "demand": (("time", "joint"), demand)},
        {"time": time, "joint": ["a", "b"]},
    )
    assert [(round(since, 6), one.joint) for since, one in measure_moves(run)] == [(1.0, "a"), (2.0, "b")]
    assert [one.joint for _, one in measure_moves(run.isel(time=slice(0, 50)))] == ["a", "b"]
    away = run.isel(time=slice(0, 50)).copy(deep=True)
    away["angle"][:, 1] -= 0.3
    assert [one.joint for _, one in measure_moves(away)] == ["b"]
