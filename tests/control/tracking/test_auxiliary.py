"""Brakes, dither and supply in the loop: rest without dither, brakes that open for what moves, a stiffness."""

import numpy as np
import pytest

from layflat.description.change import changed_all
from layflat.machine import Machine, load
from layflat.sim import rollout

pytestmark = pytest.mark.compiled

STEP = [(0.0, [-0.3, -0.3]), (0.1, [0.0, 0.3])]


@pytest.fixture(scope="module")
def arm() -> Machine:
    return load("paper-arm-adjustable")


def test_at_rest_dither_stops_and_nothing_moves() -> None:
    run = rollout("paper-arm-tracking", STEP, duration="60 s", seed=3)
    late = run.sel(time=slice(2.0, None))
    assert np.all(late.dither_share[1:] == 0.0)
    assert np.all(late.velocity == 0.0)
    air = late.air_taken.sum("joint")
    always = rollout(changed_all(load("paper-arm-tracking"), {"valve.dither.min": 1.0}), STEP, duration="4 s", seed=3)
    dithered = always.sel(time=slice(2.0, None)).air_taken.sum("joint")
    assert float(air[-1] - air[0]) / 58.0 < 0.2 * float(dithered[-1] - dithered[0]) / 2.0
    assert np.all(always.dither_share == 1.0)


def test_a_new_demand_brings_dither_back() -> None:
    run = rollout("paper-arm-tracking", [*STEP, (2.0, [0.2, 0.0])], duration="3 s", seed=3)
    assert np.all(run.dither_share.sel(time=slice(1.2, 1.99)) == 0.0)
    assert np.all(run.dither_share.sel(time=slice(2.006, 2.2)) == 1.0)
    assert np.abs(run.angle.values[-1] - [0.2, 0.0]).max() < np.radians(0.3)


def test_brakes_open_for_what_moves_and_close_at_rest(arm: Machine) -> None:
    t = arm.cycle * np.arange(600)
    moves = np.where(t < 1.5, 0.3 * np.sin(2.0 * t), 0.3 * np.sin(3.0))
    demand = np.stack([moves, -moves], axis=1)
    run = rollout(arm, demand, duration="3 s", start=[0.0, 0.0])
    least = arm.joint["large"].brake.calliper.released_fraction  # type: ignore[union-attr]
    assert np.all(run.brake_share.sel(time=slice(0.3, 1.45)) == pytest.approx(least))
    assert np.all(run.brake_share.sel(time=slice(1.7, None)) == 1.0)
    # A calliper takes its time.
    closing = run.brake_share.sel(time=slice(1.49, 1.6)).values[:, 0]
    assert np.diff(closing).max() <= arm.cycle / arm.joint["large"].brake.calliper.stroke_time + 1e-9  # type: ignore[union-attr]


@pytest.mark.parametrize("share", [0.25, 0.5])
def test_an_arm_has_the_stiffness_that_is_asked_for_and_stays_where_it_is(arm: Machine, share: float) -> None:
    asked = share * np.array([190.0, 50.0])
    pushes = [("8 s", [0.0, 0.1 * asked[1]]), ("9.5 s", [0.0, 0.0])]
    run = rollout(arm, STEP, duration="10 s", demand_stiffness=asked.tolist(), load=pushes, seed=2)
    rest = run.sel(time=slice(0.8, 7.99))
    assert np.abs(rest.angle.values - [0.0, 0.3]).max() < np.radians(0.3)
    assert np.abs(rest.estimated_stiffness.values[-1] / asked - 1.0).max() < 0.05
    gives = run.angle.sel(time=slice(8.5, 9.4), joint="small").mean() - 0.3
    assert 0.06 < float(gives) < 0.2


def test_a_position_is_kept_while_stiffness_rises_and_falls(arm: Machine) -> None:
    t = np.arange(4800) * arm.cycle
    levels = np.array([0.3, 0.9, 0.4])[(t / 8.0).astype(int)]
    goal = [-0.65, 0.65]
    asked = levels[:, None] * np.array([190.0, 50.0])
    run = rollout(arm, [(0.0, [-0.4, 0.4]), (0.1, goal)], duration="24 s", demand_stiffness=asked, seed=1)
    late = run.sel(time=slice(1.5, None))
    assert np.abs(late.angle.values - goal).max() < np.radians(0.45)
    for ends in (7.99, 15.99, 23.99):
        assert np.all(run.dither_share.sel(time=ends, method="nearest") == 0.0)


def test_a_stiffness_that_is_out_of_reach_ends_at_the_nearest(arm: Machine) -> None:
    run = rollout(arm, STEP, duration="8 s", demand_stiffness=[20.0, 5.0], seed=1)
    assert np.all(run.estimated_stiffness[-1] > [25.0, 6.0])
    assert np.all(run.dither_share[-1] == 0.0)
    assert np.all(run.brake_share[-1] < 0.1)


def test_without_a_stiffness_a_push_is_held(arm: Machine) -> None:
    run = rollout(arm, STEP, duration="4 s", load=[("2 s", [0.0, 1.0])], seed=2)
    assert np.abs(run.angle.values[-1] - [0.0, 0.3]).max() < np.radians(0.3)
