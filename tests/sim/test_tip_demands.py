"""Demands by the place of the tip, and what a run is worth there."""

from __future__ import annotations

from math import inf

import numpy as np
import pytest
import xarray
from numpy.testing import assert_allclose, assert_array_equal

from layflat.arrays import Array
from layflat.errors import InputError
from layflat.machine import Machine, load
from layflat.motion.kinematics import tip_position
from layflat.sim import Scenario
from layflat.sim.signals import expand_scenario
from layflat.sim.tip_metrics import measure_path_errors, measure_tip_moves

PICKING, PLANAR = load("picking-arm"), load("paper-arm")
PLACES = [("0 s", ["600 mm", "0 mm", "300 mm"]), ("0.1 s", {"z": "0.5 m", "x": "0.6 m", "y": "200 mm"})]

UP = np.array([0.0, 0.0, 0.001])


def asked(machine: Machine, **given: object) -> Array:
    return expand_scenario(Scenario(duration=0.2, **given), machine, 0.005).named("demand")  # type: ignore[arg-type]


def test_the_tip_is_asked_for_where_it_is_told_to() -> None:
    tips = tip_position(PICKING, asked(PICKING, tip=PLACES))
    assert_allclose(tips[:20], [[0.6, 0.0, 0.3]] * 20, atol=1e-6)
    assert_allclose(tips[20:], [[0.6, 0.2, 0.5]] * 20, atol=1e-6)
    assert_allclose(tip_position(PLANAR, asked(PLANAR, tip=["0.5 m", 0.3])), [[0.5, 0.3]] * 40, atol=1e-6)


def test_an_axis_that_is_not_named_keeps_what_it_had() -> None:
    start = np.radians([10.0, 30.0, -30.0, 40.0])
    there = tip_position(PICKING, start)
    tips = tip_position(PICKING, asked(PICKING, tip=[("0.1 s", {"y": "100 mm"})], start=start.tolist()))
    assert_allclose(tips[:20], [there] * 20, atol=1e-6)
    assert_allclose(tips[20:], [[there[0], 0.1, there[2]]] * 20, atol=1e-6)


def test_postures_are_near_to_the_start_and_to_each_other() -> None:
    start = np.radians([10.0, 30.0, -30.0, 40.0])
    there = tip_position(PICKING, start)
    demand = asked(PICKING, tip=[(0.0, there.tolist()), (0.1, (there + 10.0 * UP).tolist())], start=start.tolist())
    assert_array_equal(demand[0], start)
    assert np.abs(demand[-1] - start).max() < np.radians(2.0)
    elsewhere = asked(PICKING, tip=there.tolist())
    assert np.abs(elsewhere[0] - start).max() > np.radians(5.0)


def test_a_tip_that_moves_all_the_time_is_followed() -> None:
    def place(time: float) -> list[float]:
        return [0.6, 0.5 * time, 0.3]

    demand = asked(PICKING, tip=place)
    expected = np.array([place(0.005 * k) for k in range(40)])
    assert_allclose(tip_position(PICKING, demand), expected, atol=1e-6)
    assert_array_equal(asked(PICKING, tip=expected), demand)
    steps = np.diff(demand, axis=0)
    assert np.abs(np.diff(steps, axis=0)).max() < 1e-4  # no posture is left for another one


@pytest.mark.parametrize(
    ("machine", "given", "expected"),
    [
        (
            PICKING,
            {"tip": ["2 m", "0 m", "0 m"]},
            r"^tip: x = 2000.0 mm, .* mm out of the arm's reach; the nearest reachable position",
        ),
        (PICKING, {"tip": ["2 m", "0 m"]}, r"^tip: has 2 values; give 3: x, y, z"),
        (PICKING, {"tip": "600 mm"}, r"^tip: '600 mm' is not a position; give x, y, z"),
        (PLANAR, {"tip": {"x": "0.6 m", "y": "0 m", "z": "0 m"}}, r"^tip: unknown axis 'z'; axes are x, y$"),
        (PLANAR, {"tip": ["0.5 m", "30 deg"]}, r"^tip: '30 deg' is not a length"),
        (
            PLANAR,
            {"tip": ["0.5 m", "0.3 m"], "demand": "1 deg"},
            r"^tip: stands beside a demand; give one or the other",
        ),
    ],
)
def test_what_is_no_place_is_refused(machine: Machine, given: dict[str, object], expected: str) -> None:
    with pytest.raises(InputError, match=expected) as caught:
        asked(machine, **given)
    assert "\n" not in str(caught.value)


TIME = 0.005 * np.arange(400)


def run(tip: Array, demand: Array, machine: Machine = PICKING) -> xarray.Dataset:
    return xarray.Dataset(
        {"tip": (("time", "axis"), tip), "demand": (("time", "joint"), demand)},
        coords={"time": TIME, "joint": list(machine.joints)},
        attrs={"machine": machine.model_dump_json()},
    )


def test_the_tip_has_settled_when_its_distance_says_so() -> None:
    demand = np.where(TIME[:, None] < 0.5, np.zeros(4), [0.2, -0.1, 0.1, 0.0])
    goals = tip_position(PICKING, demand)
    away = np.where(TIME < 0.5, 0.0, 0.1 * np.exp(-(TIME - 0.5) / 0.1)) + 0.001
    off = away[:, None] * np.array([0.6, 0.0, 0.8])
    ((since, move),) = measure_tip_moves(run(goals + off, demand), (0.002, 0.005, 0.0005))
    assert since == pytest.approx(0.5)
    assert move.settling[0] == pytest.approx(0.1 * np.log(100.0), abs=0.006)
    assert move.settling[1] == pytest.approx(0.1 * np.log(25.0), abs=0.006)
    assert move.settling[2] == inf
    assert move.error == pytest.approx(0.001, abs=1e-5)


def test_a_tip_that_is_late_is_on_its_path_all_the_same() -> None:
    demand = np.stack([0.3 * np.sin(TIME), 0.0 * TIME, 0.2 * TIME, 0.0 * TIME], axis=1)
    goals = tip_position(PICKING, demand)
    late = np.concatenate([goals[:1].repeat(10, axis=0), goals[:-10]])
    missed = measure_path_errors(run(late, demand))
    assert missed.tracking[1] > 5e-3
    assert missed.contour[1] < 1e-12
    lifted = measure_path_errors(run(goals + 3.0 * UP, demand))
    assert lifted.tracking == pytest.approx((0.003, 0.003))
    assert 0.0 < lifted.contour[0] <= lifted.contour[1] <= 0.003 + 1e-12
    between = 0.5 * (goals[1:] + goals[:-1])
    assert measure_path_errors(run(np.concatenate([between, goals[-1:]]), demand)).contour[1] < 1e-12
