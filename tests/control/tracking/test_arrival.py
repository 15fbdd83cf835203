"""Arrival by the place of the tip and by the joints that it does not tell of."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from layflat.control.tracking.arrival import Tolerance, has_arrived
from layflat.control.tracking.reference import Reference
from layflat.machine import Machine, load, parameters
from layflat.sim import Scenario
from layflat.sim.ensemble import ensemble

TURNED = 'extends = "picking-arm"\nname = "turned"\n[arm.link.wrist]\naxis = [1.0, 0.0, 0.0]\n'
TOLERANCE = Tolerance(0.0015, np.radians(1.0), np.radians(0.2))


@pytest.fixture
def turned(tmp_path: Path) -> Machine:
    """The picking arm with a wrist whose axis passes through the tip."""
    file = tmp_path / "turned.toml"
    file.write_text(TURNED)
    return load(file)


def arrived(machine: Machine, degrees: Any, goal: Any) -> bool:
    arm, goals = parameters.arm(machine), tuple(Reference(q, 0.0, 0.0) for q in np.radians(goal))
    return bool(has_arrived(arm, tuple(np.radians(degrees)), goals, TOLERANCE))


def test_a_joint_that_does_not_move_the_tip_has_to_be_there_itself(turned: Machine) -> None:
    goal = [10.0, 20.0, -15.0, 30.0]
    for off, there in ((0.0, True), (0.15, True), (-0.15, True), (0.3, False), (-40.0, False)):
        assert arrived(turned, [*goal[:3], goal[3] + off], goal) == there


def test_a_joint_that_moves_the_tip_is_told_by_it() -> None:
    arm, goal = load("paper-arm-tracking"), [20.0, 30.0]
    assert arrived(arm, [20.0, 30.2], goal)
    assert not arrived(arm, [20.0, 30.3], goal)  # 0.4 m x 0.3 deg are 2 mm


def test_the_other_way_to_the_same_place_is_not_the_goal() -> None:
    """With the elbow to the other side the tip is where it is to be, and the arm is not."""
    assert not arrived(load("paper-arm-tracking"), [20.0 + 30.0, -30.0], [20.0 - 0.0, 30.0])
    assert not arrived(load("paper-arm-tracking"), [10.0, -2.0], [8.0, 2.0])


@pytest.mark.compiled
def test_a_wrist_about_the_tip_settles_as_other_joints_do(turned: Machine) -> None:
    draw = np.random.default_rng(3).uniform
    moves = [(draw(-40.0, 40.0, 4), draw(-40.0, 40.0, 4)) for _ in range(8)]
    moves += [(np.zeros(4), np.array([0.0, 0.0, 0.0, way])) for way in (40.0, -3.0, 0.8)]
    scenarios = [
        Scenario(demand=[(0.0, np.radians(a).tolist()), (0.2, np.radians(b).tolist())], duration="1.4 s")
        for a, b in moves
    ]
    settling = ensemble(turned, scenarios, {"scenario": np.arange(len(moves))})["settling"].to_numpy()[:, -1]
    assert settling.max() < 0.8
    assert np.median(settling[:8, 3]) < 1.6 * np.median(settling[:8, :3])
