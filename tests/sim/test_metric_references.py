"""Metrics against definitions written down a second time, on traces of any shape."""

from __future__ import annotations

from itertools import pairwise
from math import floor, inf, pi

import numpy as np
import pytest
import xarray
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from numpy.typing import NDArray

from layflat.machine import load
from layflat.motion.kinematics import tip_position
from layflat.physics.air import NORMAL_DENSITY
from layflat.sim.metrics import (
    MAX_MOVES,
    air_used,
    measure_move,
    move_windows,
    peak_tip_acceleration,
    settling_time,
    tip_settling,
)

Array = NDArray[np.float64]
ARM, SMALL = load("paper-arm"), load("paper-small-joint")
CYCLE = 0.005

errors = arrays(np.float64, st.integers(2, 40), elements=st.floats(-1.0, 1.0))
angles = st.floats(-1.0, 1.0)


def run_of(angle: Array, demand: float) -> xarray.Dataset:
    """A run of one joint, with what is asked of it all the time."""
    time = CYCLE * np.arange(len(angle))
    data = {
        "angle": (("time", "joint"), angle[:, None]),
        "demand": (("time", "joint"), np.full((len(angle), 1), demand)),
    }
    return xarray.Dataset(data, coords={"time": time, "joint": ["a"]})


@given(errors, st.floats(0.01, 0.9))
def test_settling_is_the_first_instant_from_which_all_lie_inside(error: Array, band: float) -> None:
    time = CYCLE * np.arange(len(error))
    inside = [k for k in range(len(error)) if np.all(np.abs(error[k:]) <= band)]
    assert settling_time(time, error, band) == pytest.approx(time[inside[0]] if inside else inf)


@given(errors, st.floats(0.01, 0.9), st.floats(0.01, 0.9))
def test_a_wider_band_is_never_later(error: Array, one: float, other: float) -> None:
    time = CYCLE * np.arange(len(error))
    assert settling_time(time, error, max(one, other)) <= settling_time(time, error, min(one, other))


@given(errors, angles)
def test_a_move_by_its_definition(angle: Array, demand: float) -> None:
    found = measure_move(run_of(angle, demand), "a", band=0.1)
    error = angle - demand
    end = error[floor(0.8 * len(error)) :]
    assert found.settling == settling_time(CYCLE * np.arange(len(error)), error, 0.1)
    assert found.overshoot == pytest.approx(max(0.0, np.max(np.sign(demand - angle[0]) * error)), abs=1e-15)
    assert found.steady_error == pytest.approx(np.mean(end), abs=1e-12)
    assert found.ripple == pytest.approx(np.ptp(end), abs=1e-12)


@given(errors, angles)
def test_the_other_way_round_a_move_is_worth_the_same(angle: Array, demand: float) -> None:
    one, other = measure_move(run_of(angle, demand), "a"), measure_move(run_of(-angle, -demand), "a")
    assert (one.settling, one.overshoot, one.ripple) == (other.settling, other.overshoot, other.ripple)
    assert one.steady_error == -other.steady_error


@given(arrays(np.int64, st.tuples(st.integers(1, 150), st.integers(1, 3)), elements=st.integers(0, 1)))
def test_moves_follow_each_other_without_a_gap(demand: Array) -> None:
    windows = move_windows(demand.astype(float))
    changes = int(np.any(np.diff(demand, axis=0) != 0, axis=1).sum())
    assert len(windows) == (changes if 0 < changes <= MAX_MOVES else 1)
    assert windows[-1][1] == len(demand) - 1
    for (_, last), (first, _) in pairwise(windows):
        assert first == last + 1
    for first, last in windows if 0 < changes <= MAX_MOVES else []:
        assert np.all(demand[first : last + 1] == demand[first])
        assert np.any(demand[first] != demand[first - 1])


@given(angles, angles)
def test_the_tip_of_two_links(first: float, second: float) -> None:
    links = [ARM.joint[name].planar_link.length for name in ("large", "small")]
    # Complex numbers for vectors: the elbow's angle counts from where it stands at mid-stroke.
    tip = links[0] * np.exp(1j * first) + links[1] * np.exp(1j * (first + second + ARM.arm.elbow))
    assert tip_position(ARM, np.array([first, second])) == pytest.approx([tip.real, tip.imag], abs=1e-12)


@given(arrays(np.float64, (3, 4, 1), elements=angles))
def test_the_tip_of_one_link_in_any_shape(q: Array) -> None:
    length = SMALL.joint["small"].planar_link.length
    assert tip_position(SMALL, q) == pytest.approx(
        length * np.stack([np.cos(q), np.sin(q)], axis=-1)[..., 0, :], abs=1e-12
    )


def at(tip: Array) -> xarray.Dataset:
    """A run of which only the tip's place is known."""
    return xarray.Dataset({"tip": (("time", "axis"), tip)}, coords={"time": CYCLE * np.arange(len(tip))})


@given(st.floats(0.1, 2.0), st.floats(0.5, 8.0))
def test_a_payload_on_a_circle_is_accelerated_to_its_middle(radius: float, speed: float) -> None:
    phase = speed * CYCLE * np.arange(100)
    found = peak_tip_acceleration(at(radius * np.stack([np.cos(phase), np.sin(phase)], axis=1)))
    assert found == pytest.approx(radius * speed**2, rel=1e-3)


def test_an_acceleration_needs_three_instants() -> None:
    assert peak_tip_acceleration(at(np.array([[0.0, 0.0], [1.0, 0.0]]))) == 0.0
    assert peak_tip_acceleration(at(np.outer(np.arange(9.0), [3.0, -4.0]))) == pytest.approx(0.0, abs=1e-6)


def test_air_is_counted_in_normal_litres_from_the_start_of_the_run() -> None:
    taken = np.array([[0.2, 0.1], [0.3, 0.1], [0.5, 0.4]])
    run = xarray.Dataset({"air_taken": (("time", "joint"), taken)})
    assert air_used(run) == pytest.approx(1000.0 * 0.6 / NORMAL_DENSITY)


@settings(max_examples=8)
@given(st.floats(1e-3, 0.2), st.integers(1, 60))
def test_the_tip_settles_when_it_stays_where_the_demands_put_it(band: float, late: int) -> None:
    q = np.zeros((80, 2))
    goal = tip_position(ARM, q)
    tip = goal.copy()
    tip[:late] += [1.001 * band, 0.0]
    data = {"demand": (("time", "joint"), q), "tip": (("time", "axis"), tip)}
    run = xarray.Dataset(data, coords={"time": CYCLE * np.arange(80)}, attrs={"machine": ARM.model_dump_json()})
    assert tip_settling(run, 0.0, inf, band) == pytest.approx(CYCLE * late)
    assert tip_settling(run, 0.0, CYCLE * (late - 1), band) == inf
    assert tip_settling(run, CYCLE * late, inf, band) == 0.0


def test_a_full_turn_of_the_base_brings_the_tip_back() -> None:
    assert tip_position(ARM, np.array([pi, 0.3])) == pytest.approx(tip_position(ARM, np.array([-pi, 0.3])), abs=1e-12)
