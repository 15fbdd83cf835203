"""A run of an ensemble is the rollout, bit for bit, whatever runs beside it."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import xarray

from layflat.description.change import value_at
from layflat.errors import InputError
from layflat.machine import Machine, changed, load
from layflat.registers import host_width
from layflat.sim import Scenario, rollout
from layflat.sim.ensemble import ensemble
from layflat.sim.ensemble.parallel import MAX_GROUPS
from layflat.sim.metrics import air_used, measure_moves, peak_tip_acceleration, tip_settling
from layflat.sim.sweep import sweep

ARM = load("paper-arm-fast")
MOVES = Scenario(demand=[(0.0, (-0.3, -0.3)), (0.2, (0.3, -0.3)), (0.9, (0.3, 0.3))], duration="1.5 s")


def assert_same(run: xarray.Dataset, found: xarray.Dataset, rel: float = 0.0) -> None:
    """The metrics of a rollout and those of a run of an ensemble."""
    assert found.attrs["step"] == run.attrs["step"]
    moves = measure_moves(run)
    starts = sorted({since for since, _ in moves})
    for since, move in moves:
        own = found.isel(move=starts.index(since)).sel(joint=move.joint)
        assert float(own.settling) == pytest.approx(move.settling, abs=1e-9)
        for name in ("overshoot", "steady_error", "ripple"):
            assert float(own[name]) == pytest.approx(getattr(move, name), rel=rel, abs=0.0)
    assert float(found.air_used) == pytest.approx(air_used(run), rel=rel, abs=0.0)
    assert float(found.peak_acceleration) == pytest.approx(peak_tip_acceleration(run), rel=1e-9 + rel)
    for i, (since, until) in enumerate(zip(starts, [*starts[1:], 1e9], strict=True)):
        tip = tip_settling(run, since, until - 1e-6, 2e-3)
        assert float(found.tip_settling[i]) == pytest.approx(tip, abs=1e-9)


def test_closed_loop_with_noise_is_the_rollout() -> None:
    payloads, brakes = np.linspace(0.0, 2.0, 6), np.linspace(1.0, 3.0, 6)
    vary = {"scenario.payload": payloads, "joint.small.brake.torque": brakes, "seed": np.arange(6)}
    many = ensemble(ARM, MOVES, vary, traces=["angle", "pressure_a"])
    for i in (0, 3, 5):
        machine = changed(ARM, "joint.small.brake.torque", float(brakes[i]))
        run = rollout(machine, scenario=MOVES, payload=float(payloads[i]), seed=i)
        assert np.array_equal(run.angle[:-1], many.angle[i])
        assert np.array_equal(run.pressure_a[:-1], many.pressure_a[i])
        assert_same(run, many.isel(run=i))


def test_a_machine_may_be_driven_by_the_controller_of_another() -> None:
    other = changed(ARM, "joint.small.gains.close.error", 2.0 * value_at(ARM, "joint.small.gains.close.error"))
    torques = np.array([1.0, 3.0])
    vary = {"joint.small.brake.torque": torques, "controller.drift_limit": np.array([0.3, 0.9]), "seed": np.arange(2)}
    many = ensemble(ARM, MOVES, vary, traces=["angle"], controller=other)
    for i, torque in enumerate(torques.tolist()):
        machine = changed(ARM, "joint.small.brake.torque", torque)
        driving = changed(other, "controller.drift_limit", vary["controller.drift_limit"].tolist()[i])
        assert np.array_equal(rollout(machine, scenario=MOVES, seed=i, controller=driving).angle[:-1], many.angle[i])
        assert not np.array_equal(rollout(machine, scenario=MOVES, seed=i).angle[:-1], many.angle[i])


def test_a_controller_brings_its_cycle_and_has_to_be_of_the_same_joints() -> None:
    slow = changed(ARM, "controller.cycle", 0.01)
    run = rollout(ARM, scenario=MOVES, controller=slow)
    assert len(run.time) == 151
    assert np.array_equal(run.angle[:-1], ensemble(ARM, MOVES, runs=1, traces=["angle"], controller=slow).angle[0])
    for simulate in (rollout, ensemble):
        with pytest.raises(InputError, match=r"controller: paper-small-joint: has joints small; give a machine with"):
            simulate(ARM, scenario=MOVES, controller=load("paper-small-joint"))


def test_open_loop_is_the_rollout() -> None:
    def opening(t: float) -> tuple[float, float]:
        return 0.08 * np.sin(2 * np.pi * 0.7 * t), 0.06 * np.sin(2 * np.pi * 1.1 * t)

    case = Scenario(opening=opening, duration="4 s", noise=False)
    many = ensemble(ARM, case, {"scenario.brake": [0.0, 1.0]}, traces=["angle"])
    for brake, run in zip((0.0, 1.0), many.angle, strict=True):
        alone = rollout(ARM, scenario=case, brake=brake).angle[:-1]
        assert np.abs(np.degrees(alone - run.to_numpy())).max() <= 1e-6


def test_hysteresis_is_that_of_a_slow_sweep() -> None:
    shares, brakes, supplies = [0.05, 0.1, 0.2], [0.0, 3.0, 6.0], [2e5, 4e5, 6e5]
    vary = {"joint.large.hose.loss_fraction": shares, "joint.large.brake.torque": brakes}
    short = Scenario(duration="0.1 s")
    many = ensemble(ARM, short, {**vary, "supply.pressure_gauge": supplies})
    for i in range(3):
        machine = changed(
            changed(ARM, "joint.large.hose.loss_fraction", shares[i]), "joint.large.brake.torque", brakes[i]
        )
        for joint in ("large", "small"):
            expected = sweep(machine, joint, supplies[i]).hysteresis
            assert float(many.hysteresis[i].sel(joint=joint)) == pytest.approx(expected, rel=2e-3)


def test_valves_that_switch() -> None:
    arm = load("paper-arm-switching")
    vary = {"valve.opening_delay": [1e-3, 2e-3, 3e-3], "valve.frequency": [50.0, 80.0, 130.0]}
    many = ensemble(arm, MOVES, vary, traces=["angle", "valve_opening"])
    for i in (0, 2):
        machine = arm
        for path, values in vary.items():
            machine = changed(machine, path, values[i])
        run = rollout(machine, scenario=MOVES)
        assert np.array_equal(run.angle[:-1], many.angle[i])
        assert np.array_equal(run.valve_opening[:-1], many.valve_opening[i])
        assert_same(run, many.isel(run=i))


@pytest.mark.parametrize("name", ["paper-small-joint-fast", "earlier-actuator"])
def test_joints_alone(name: str) -> None:
    machine = load("paper-small-joint-fast") if name == "paper-small-joint-fast" else with_gains(load(name))
    case = Scenario(demand=[(0.0, -0.3), (0.2, 0.3)], duration="1 s")
    many = ensemble(machine, case, {"arm.payload": [0.5, 1.5]})
    assert_same(rollout(changed(machine, "arm.payload", 1.5), scenario=case), many.isel(run=1))


def with_gains(machine: Machine) -> Machine:
    return changed(machine, "joint.small.gains", ARM.joint["small"].gains)


def test_a_scenario_s_supply_has_filled_the_hoses() -> None:
    still = Scenario(demand=0.2, duration="1 s", noise=False)
    many = ensemble(ARM, still, {"scenario.supply": [4e5, 2e5]})
    steps = Scenario(demand=0.2, duration="1 s", noise=False, supply=[(0.0, 2e5), (0.5, 3e5)])
    for i, case in enumerate([replace(still, supply=4e5), replace(still, supply=2e5)]):
        assert_same(rollout(ARM, scenario=case), many.isel(run=i))
        assert float(many.air_used[i]) > 0.3
    assert_same(rollout(ARM, scenario=steps), ensemble(ARM, steps).isel(run=0))


def test_one_joint_starts_at_its_own_pressure() -> None:
    machine = load("paper-small-joint-fast")
    case = Scenario(demand=[(0.0, -0.3), (0.2, 0.3)], duration="1 s")
    many = ensemble(machine, case, {"supply.pressure_gauge": [4e5, 3.5e5, 3e5]})
    for i, gauge in enumerate([4e5, 3.5e5, 3e5]):
        run = rollout(changed(machine, "supply.pressure_gauge", gauge), scenario=case)
        assert_same(run, many.isel(run=i))


@pytest.mark.parametrize(
    ("key", "change"),
    [
        ("scenario.supply", {"supply": 3.5e5}),
        ("scenario.brake", {"brake": 0.5}),
        ("scenario.load", {"load": 1.5}),
        ("scenario.drift.small", {"drift": {"small": 0.3}}),
    ],
)
def test_what_comes_on_top_of_a_scenario(key: str, change: dict[str, Any]) -> None:
    value = next(iter(change.values()))
    many = ensemble(ARM, MOVES, {key: [value["small"] if isinstance(value, dict) else value]})
    assert_same(rollout(ARM, scenario=MOVES, **change), many.isel(run=0))


@pytest.mark.parametrize(
    "path",
    [
        "joint.small.hose.width",
        "joint.small.losses.deflections.0",
        "joint.large.losses.reference_pressure_gauge",
        "joint.small.stops.mechanical_stroke",
        "valve.critical_ratio",
        "valve.conductance",
        "supply.ambient_pressure",
        "angle_sensor.range",
        "arm.elbow",
        "arm.gravity",
        "joint.small.link.length",
        "controller.drift_time",
    ],
)
def test_any_number_of_the_machine_may_vary(path: str) -> None:
    usual = value_at(ARM, path)
    value = 1.05 * usual if usual else 0.5
    many = ensemble(ARM, MOVES, {path: [value, usual or 0.1]})
    assert_same(rollout(changed(ARM, path, value), scenario=MOVES), many.isel(run=0))


def test_roller_joints_vary_in_shape() -> None:
    machine = with_gains(load("earlier-actuator"))
    case = Scenario(demand=[(0.0, -0.3), (0.2, 0.3)], duration="1 s")
    radius = machine.joint["small"].output.radius
    many = ensemble(machine, case, {"joint.small.output.radius": [radius, 1.1 * radius]})
    alone = rollout(changed(machine, "joint.small.output.radius", 1.1 * radius), scenario=case)
    # Fitting many curves at a time rounds in another way.
    assert_same(alone, many.isel(run=1), rel=1e-9)


def test_scenarios_differ_from_run_to_run() -> None:
    one = Scenario(demand=[(0.0, 0.0), (0.4, 0.4)], duration="1.5 s", payload="1 kg", seed=3)
    two = Scenario(demand=MOVES.demand, duration="1.5 s", supply=[("1 s", "3 bar")], start=(-0.3, -0.2), seed=4)
    many = ensemble(ARM, [one, two], {"scenario": [0, 1, 1, 0, 1]})
    assert many.sizes == {"run": 5, "move": 2, "joint": 2}
    for i, case in ((0, one), (1, two), (3, one), (4, two)):
        assert_same(rollout(ARM, scenario=case), many.isel(run=i))
    assert np.isnan(many.settling[0, 1]).all()
    assert not np.isnan(many.settling[1]).any()


def test_neither_neighbours_nor_threads_nor_blocks_matter() -> None:
    count = MAX_GROUPS * host_width() + 3
    case = Scenario(demand=[(0.0, 0.0), (0.05, 0.2)], duration="0.1 s")
    payloads = np.linspace(0.0, 2.0, count)
    vary = {"scenario.payload": payloads, "seed": np.arange(count)}
    one, two = (ensemble(ARM, case, vary, threads=threads) for threads in (1, 2))
    assert one.identical(two)
    some = [count - 1, 7, 0]
    alone = ensemble(ARM, case, {key: np.asarray(values)[some] for key, values in vary.items()})
    assert alone.identical(one.isel(run=some))


def test_a_run_that_diverges_is_kept_and_told() -> None:
    case = Scenario(demand=0.0, load=[("0.1 s", 0.0), ("0.2 s", 2000.0)], duration="0.5 s", noise=False)
    calm = Scenario(demand=0.0, duration="0.5 s", noise=False)
    many = ensemble(ARM, [case, calm], {"scenario": [1, 0, 1]})
    assert np.isnan(many.diverged[[0, 2]]).all()
    assert 0.2 <= float(many.diverged[1]) <= 0.25
    assert np.isnan(many.settling[1]).all()
    assert np.isnan(many.air_used[1])
    assert not np.isnan(many.settling[[0, 2]]).any()


def test_traces_are_thinned() -> None:
    thin = ensemble(ARM, MOVES, runs=1, traces=["velocity"], every=7)
    full = ensemble(ARM, MOVES, runs=1, traces=["velocity"])
    assert np.array_equal(thin.velocity, full.velocity[:, ::7])
    assert np.allclose(thin.time, full.time[::7])
