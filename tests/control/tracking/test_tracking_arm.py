"""The law in the loop, from its sensors alone: settling, unknown loads and plants, moving demands."""

from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from layflat.description.change import changed_all, value_at
from layflat.machine import Machine, load
from layflat.motion.kinematics import tip_position
from layflat.physics.friction.stribeck import StribeckPart
from layflat.sim import Scenario, rollout
from layflat.sim.ensemble import ensemble

pytestmark = pytest.mark.compiled

WAYS = ((1, 1), (1, -1), (1, 0), (0, 1), (-1, -1), (-1, 1), (-1, 0), (0, -1))
RUNS = 64


@pytest.fixture(scope="module")
def arm() -> Machine:
    return load("paper-arm-tracking")


@cache
def steps() -> list[Scenario]:
    """Steps of 40 degrees of one and of both joints."""
    begun = np.random.default_rng(4).uniform(-15.0, 15.0, (len(WAYS), 2))
    half = 20.0 * np.array(WAYS)
    moves = zip(begun - half, begun + half, strict=True)
    degrees = [[(0.0, np.radians(a)), (0.4, np.radians(b))] for a, b in moves]
    return [Scenario(demand=demand, duration="1.4 s") for demand in degrees]


def settled(machine: Machine, vary: dict[str, Any] | None = None, **options: Any) -> np.ndarray:
    """Settling times of the tip in as many runs."""
    each = {"scenario": np.arange(RUNS) % len(WAYS), "seed": np.arange(RUNS)} | (vary or {})
    times: np.ndarray = ensemble(machine, steps(), each, **options)["tip_settling"].values[:, -1]
    return times


def test_steps_settle_four_times_as_fast_as_the_paper_reports(arm: Machine) -> None:
    times = settled(arm)
    assert np.median(times) < 0.35
    assert times.max() < 0.55


def test_plants_that_differ_from_the_model_settle_too(arm: Machine) -> None:
    draw = np.random.default_rng(8).uniform
    brakes = {f"joint.{name}.brake.torque": joint.brake.torque for name, joint in arm.joints.items()}
    vary = {path: torque * draw(0.7, 1.3, RUNS) for path, torque in brakes.items()}
    vary |= {"valve.conductance": value_at(arm, "valve.conductance") * draw(0.8, 1.2, RUNS)}
    vary |= {"scenario.supply": 4e5 * draw(0.8, 1.2, RUNS), "valve.delay": draw(0.0, 5e-3, RUNS)}
    times = settled(load("paper-arm-fast"), vary, controller=arm)
    assert np.quantile(times, 0.95) < 0.65
    assert times.max() < 1.0


def test_a_command_that_is_known_to_be_late_costs_its_delay(arm: Machine) -> None:
    late = settled(changed_all(arm, {"valve.delay": 5e-3}))
    assert np.median(late) < 0.36
    assert late.max() < 0.6


def test_a_payload_is_learnt_in_the_first_move(arm: Machine) -> None:
    unsure = changed_all(arm, {"arm.payload": 1.0, "controller.payload_std": 0.6})
    payloads = np.random.default_rng(9).uniform(0.0, 2.0, RUNS)
    assert np.quantile(settled(unsure, {"scenario.payload": payloads}), 0.95) < 0.7
    for payload in (0.1, 1.9):
        run = rollout(unsure, scenario=steps()[0], payload=payload)
        assert abs(run.estimated_payload.values[-1, 0] - payload) < 0.1


def test_a_light_joint_that_breaks_away_is_caught(arm: Machine) -> None:
    """Friction at rest is far above that in motion: what it takes to start a joint flings it past its goal."""
    sticks = StribeckPart(kind="stribeck", static_ratio=1.45, velocity="2 deg/s")
    plant = changed_all(arm, {"joint.small.friction": sticks, "joint.small.brake.torque": 2.7})
    unsure = changed_all(arm, {"arm.payload": 1.0, "controller.payload_std": 0.6})
    times = settled(plant, {"scenario.payload": np.full(RUNS, 0.03)}, controller=unsure)
    assert np.median(times) < 0.5
    assert np.mean(times > 0.6) < 0.35


def test_gravity_is_borne_and_its_payload_learnt(arm: Machine) -> None:
    upright = changed_all(arm, {"arm.gravity": 9.81, "arm.payload": 1.0, "controller.payload_std": 0.6})
    run = rollout(upright, scenario=steps()[1], payload=1.8)
    tips = tip_position(upright, run.angle.values[200:])
    goal = tip_position(upright, run.demand.values[-1])
    assert np.linalg.norm(tips - goal, axis=1).max() < 2e-3


def test_a_run_of_an_ensemble_is_the_rollout_bit_for_bit(arm: Machine) -> None:
    vary = {"seed": np.array([3, 5]), "scenario": np.array([1, 1])}
    many = ensemble(arm, steps(), vary, traces=("angle", "voltage"))
    for i, seed in enumerate((3, 5)):
        one = rollout(arm, scenario=steps()[1], seed=seed)
        for name in ("angle", "voltage"):
            assert np.array_equal(many[name].values[i], one[name].values[:-1])


def test_a_target_that_moves_is_followed(arm: Machine) -> None:
    t = 5e-3 * np.arange(400)
    demand = np.stack([0.4 * np.sin(3.0 * t), 0.3 * np.cos(2.0 * t)], axis=1)
    run = rollout(arm, demand, duration="2 s", start={"large": "5 deg", "small": "10 deg"})
    apart = np.linalg.norm(tip_position(arm, run.angle.values[100:-1]) - tip_position(arm, demand[100:]), axis=1)
    assert np.sqrt(np.mean(apart**2)) < 1.0e-3
    assert apart.max() < 3e-3


def test_an_arm_whose_goal_changes_on_its_way_stays_in_its_stroke(arm: Machine) -> None:
    draw, time, demand = np.random.default_rng(6), 0.0, list[tuple[float, list[float]]]()
    while time < 20.0:
        demand.append((time, draw.uniform(-0.94, 0.94, 2).tolist()))
        time += draw.uniform(0.05, 0.6)
    run = rollout(arm, demand, duration=20.0)
    half = np.array([0.5 * joint.stops.working_stroke for joint in arm.joints.values()])
    assert (np.abs(run["angle"].to_numpy()).max(axis=0) < half + np.radians(3.0)).all()


def test_an_arm_that_is_pushed_away_comes_back(arm: Machine) -> None:
    push: Any = [("0.3 s", {"large": "60 N m", "small": "20 N m"}), ("0.5 s", 0.0)]
    run = rollout(arm, 0.0, duration="1.5 s", load=push)
    assert np.abs(run.angle.values[60:120]).max() > 0.2
    assert np.abs(run.angle.values[-60:]).max() < np.radians(0.3)


def test_a_single_joint(tmp_path: Path) -> None:
    path = tmp_path / "one.toml"
    path.write_text('extends = "paper-small-joint-fast"\nname = "one"\n[controller]\nkind = "tracking"\ncycle = "5 ms"')
    run = rollout(load(path), [(0.0, "-20 deg"), (0.4, "20 deg")], duration="1.2 s")
    assert np.abs(run.angle.values[180:] - np.radians(20.0)).max() < np.radians(0.3)
