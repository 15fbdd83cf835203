"""Runs that follow a log: its voltages, from the state that it begins with."""

from dataclasses import replace
from math import radians

import numpy as np
import pytest

from layflat.errors import InputError
from layflat.machine import changed, load
from layflat.motion.signal_rows import Steps
from layflat.sim import Scenario, rollout
from layflat.sim.ensemble import ensemble
from layflat.sim.ensemble.parallel import simulate_traces

ARM = load("paper-arm")
STEPS: Steps = [("0 s", "0 deg"), ("0.2 s", {"large": "30 deg", "small": "-20 deg"})]
MOVES = Scenario(demand=STEPS, duration="1.5 s")


def test_a_run_s_own_voltages_give_the_run_again() -> None:
    run = rollout(ARM, scenario=MOVES)
    followed = Scenario(voltage=run.voltage.to_numpy()[:-1], start=0.0, duration="1.5 s", noise=False)
    again = rollout(ARM, scenario=followed)
    assert np.abs(np.degrees(again.angle - run.angle)).max() < 1e-6
    many = simulate_traces(ARM, followed, {"scenario.payload": [1.5, 1.5, 0.5]}, ("angle", "pressure_a"))
    assert np.abs(np.degrees(many[0, :, :, 0] - run.angle.to_numpy()[:-1])).max() < 1e-6
    assert np.array_equal(many[0], many[1])
    assert not np.array_equal(many[0], many[2])


def test_a_voltage_means_more_to_a_valve_that_needs_less() -> None:
    pulled = Scenario(voltage=("6 V", "5 V"), duration="0.3 s", noise=False)
    run = simulate_traces(
        ARM, pulled, {"valve.volts_to_full": [5.0, 2.5], "valve.centre_voltage": [5.0, 5.5]}, ("angle",)
    )
    other = rollout(changed(ARM, "valve.volts_to_full", 2.5), scenario=pulled).angle[:-1, 0]
    assert run[0, -1, 0, 0] > radians(1.0)
    shifted = changed(changed(ARM, "valve.volts_to_full", 2.5), "valve.centre_voltage", 5.5)
    assert np.abs(run[1, :, :, 0] - rollout(shifted, scenario=pulled).angle.to_numpy()[:-1]).max() < 1e-8
    assert abs(float(other[-1]) - run[0, -1, 0, 0]) > radians(1.0)


def test_openings_and_voltages_do_not_stand_side_by_side() -> None:
    with pytest.raises(InputError, match="opening: stands beside a voltage"):
        rollout(ARM, opening=0.1, voltage=5.0)


def test_every_joint_begins_where_it_is_put() -> None:
    vary = {
        "start.angle.small": [radians(10.0), radians(-10.0)],
        "start.pressure_a.large": [2e5, 3e5],
        "start.pressure_b.large": [2e5, 3e5],
    }
    still = Scenario(duration="0.05 s", opening=0.0, pressures={"small": ("3 bar", "2.5 bar")}, noise=False)
    run = simulate_traces(ARM, still, vary, ("angle", "pressure_a", "pressure_b"))[:, 0]
    assert run[:, 1, 0] == pytest.approx([radians(10.0), radians(-10.0)])
    assert run[:, 0, 0] == pytest.approx(0.0)
    assert run[:, 0, 1] == pytest.approx([2e5, 3e5])
    assert run[:, 1, 1:] == pytest.approx(np.array([[3e5, 2.5e5]] * 2))
    with pytest.raises(InputError, match=r"unknown joint 'wrist'; joints are large, small"):
        rollout(ARM, pressures={"wrist": ("3 bar", "3 bar")})


def test_a_late_command_is_late_in_both_loops() -> None:
    late = changed(ARM, "valve.delay", 7e-3)
    run = rollout(late, scenario=MOVES)
    many = ensemble(late, MOVES, runs=1, traces=["angle"])
    assert np.array_equal(run.angle[:-1], many.angle[0])
    prompt = rollout(ARM, scenario=MOVES)
    assert not np.array_equal(run.angle, prompt.angle)
    calm = changed(ARM, "valve.dither.amplitude", 0.0)
    step = Scenario(opening=[("0 s", 0.0), ("0.1 s", 0.5)], start=0.0, duration="0.3 s", noise=False)
    moved = [
        rollout(machine, scenario=step).pressure_a[:, 0].to_numpy()
        for machine in (calm, changed(calm, "valve.delay", 1e-2))
    ]
    assert moved[1][2:] == pytest.approx(moved[0][:-2], rel=2e-3)


def test_a_run_that_diverges_is_no_numbers_from_there() -> None:
    case = Scenario(load=1e5, opening=0.0, duration="0.5 s", noise=False)
    angles = simulate_traces(ARM, case, {"seed": [0.0]}, ("angle",))[0, :, 0, 0]
    assert np.isfinite(angles[0])
    assert np.isnan(angles[-1])


def test_each_run_may_have_openings_of_its_own() -> None:
    openings = np.random.default_rng(4).uniform(-1.0, 1.0, (3, 20, 2))
    each = [Scenario(opening=one, duration=0.1, noise=False) for one in openings]
    together = simulate_traces(ARM, each, {"scenario": np.arange(3)}, ("angle", "pressure_a"))
    alone = [simulate_traces(ARM, one, {"seed": [0.0]}, ("angle", "pressure_a"))[0] for one in each]
    assert np.array_equal(together, alone)
    assert np.ptp(together[:, -1, :, 1], axis=0).min() > 5e3


def test_what_leads_a_run_to_its_demand_is_voltages_and_torques_that_can_be_given_as_well() -> None:
    times = ARM.cycle * np.arange(200)
    wanted = 0.3 * np.sin(np.multiply.outer(times, [6.0, 9.0]))
    speeds = np.gradient(wanted, ARM.cycle, axis=0)
    voltage = 5.0 + 0.6 * np.sin(np.multiply.outer(times, [8.0, 11.0]))
    led = Scenario(demand=wanted, demand_velocity=speeds, voltage=voltage, start=0.0, duration="1 s", noise=False)
    leads = {"lead": [3.0], "pressure_lead": [1e-6], "spring": [4.0], "damper": [0.5]}
    signals = ("angle", "velocity", "pressure_a", "pressure_b")
    run = simulate_traces(ARM, led, {f"scenario.{name}": lead for name, lead in leads.items()}, signals)[0]
    angle, velocity, first, second = np.moveaxis(run, -1, 0)
    given = replace(
        led,
        voltage=voltage + 3.0 * (wanted - angle) - 1e-6 * (first - second),
        load=4.0 * (wanted - angle) + 0.5 * (speeds - velocity),
    )
    assert np.array_equal(simulate_traces(ARM, given, {"seed": [0.0]}, signals)[0], run)
    unled = simulate_traces(ARM, led, {"seed": [0.0]}, signals)[0]
    assert np.abs(run - unled)[:, :, 0].max() > 0.1
