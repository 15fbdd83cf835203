from __future__ import annotations

import numpy as np
import pytest

from layflat.cell import Cell
from layflat.cell.scene.lift_drive import LiftDrive

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
