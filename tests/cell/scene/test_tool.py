from __future__ import annotations

from math import pi

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from layflat.cell import Cell, load
from layflat.cell.scene.grip import LiftDrive, SuctionCup

CELL = load("packing")
STEP = 1e-3


def moved(cell: Cell, demands: list[float], blocked: float = 1.0) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Stroke, speed and force of a free piston (blocked at a stroke) that is led to demands, half a second each."""
    lift, at, speed = LiftDrive(cell.lift, STEP), 0.0, 0.0
    rows = []
    for demand in demands:
        lift.demand = demand
        for _ in range(500):
            force = lift.force(at, speed)
            speed += force / cell.lift.mass * STEP
            at += speed * STEP
            if at > blocked:
                at, speed = blocked, min(speed, 0.0)
            rows.append((at, speed, force))
    stroke, speeds, forces = np.array(rows).T
    return stroke, speeds, forces


def test_it_comes_to_rest_where_it_is_led_without_overshoot(packing: Cell) -> None:
    stroke, speed, _ = moved(packing, [0.12, 0.05])
    assert stroke[499] == pytest.approx(0.12, abs=1e-4)
    assert stroke[-1] == pytest.approx(0.05, abs=1e-4)
    assert stroke.max() < 0.121
    assert abs(speed[-1]) < 1e-3


def test_speed_acceleration_and_force_are_kept(packing: Cell) -> None:
    _, speed, force = moved(packing, [0.16, 0.0, 0.03])
    acceleration = np.diff(speed) / STEP
    assert np.abs(speed).max() <= 1.02 * packing.lift.speed
    assert np.abs(acceleration).max() <= 1.01 * packing.lift.acceleration
    assert np.abs(force).max() <= packing.lift.force


def test_demands_beyond_the_stroke_are_cut(packing: Cell) -> None:
    lift = LiftDrive(packing.lift, STEP)
    lift.demand = 1.0
    assert lift.demand == packing.lift.stroke
    lift.demand = -1.0
    assert lift.demand == 0.0


def test_a_blocked_piston_presses_with_its_greatest_force_and_comes_back(packing: Cell) -> None:
    stroke, speed, force = moved(packing, [0.15, 0.0], blocked=0.06)
    assert force[499] == pytest.approx(packing.lift.force)
    assert np.abs(speed).max() <= 1.05 * packing.lift.speed
    assert stroke[-1] == pytest.approx(0.0, abs=1e-4)


def test_vacuum_follows_its_law_on_a_skin_and_after_release(packing: Cell) -> None:
    cup, told = SuctionCup(packing.cup), packing.cup

    def slope(t: float, p: np.ndarray[tuple[int], np.dtype[np.float64]]) -> list[float]:
        if t < 0.2:
            return [float((told.vacuum - p[0]) / told.build_up - p[0] / told.leak)]
        return [float(-p[0] / told.leak - p[0] / told.release)]

    cup.on = True
    for step in range(250):
        cup.on = step < 200
        cup.advance(True, 1e-3)
    reference = solve_ivp(slope, (0.0, 0.25), [0.0], max_step=1e-3, rtol=1e-8).y[0, -1]
    assert cup.vacuum == pytest.approx(reference, rel=2e-3)
    assert cup.air == pytest.approx(0.2 * told.air_consumption)


def test_an_open_cup_keeps_little(packing: Cell) -> None:
    opened, sealed = SuctionCup(packing.cup), SuctionCup(packing.cup)
    opened.on = sealed.on = True
    for _ in range(500):
        opened.advance(False, 1e-3)
        sealed.advance(True, 1e-3)
    assert opened.vacuum < 0.35 * sealed.vacuum
    assert sealed.vacuum < packing.cup.vacuum


@given(st.floats(0, 12), st.floats(0, 12), st.floats(0, 3), st.floats(0, 3))
def test_what_is_held_is_held_against_less(pull: float, shear: float, less: float, least: float) -> None:
    cup = SuctionCup(CELL.cup)
    cup.vacuum = 4e4
    assert cup.force == pytest.approx(4e4 * pi / 4 * CELL.cup.effective_diameter**2)
    if cup.holds(pull, shear):
        assert cup.holds(pull - less, max(shear - least, 0.0))
        assert pull <= cup.force


def test_friction_bounds_what_is_held_sideways(packing: Cell) -> None:
    cup = SuctionCup(packing.cup)
    cup.vacuum = 4e4
    free = packing.cup.friction * (cup.force - 2.0)
    assert cup.holds(2.0, 0.99 * free)
    assert not cup.holds(2.0, 1.01 * free)
