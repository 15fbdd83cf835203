from itertools import islice
from typing import Any

import numpy as np
import pytest

from layflat.errors import InputError
from layflat.machine import load
from layflat.motion.scenario import SIGNALS
from layflat.physics.sensor import NOISE_BLOCK, noise_samples, sensor_noise
from layflat.sim import Scenario
from layflat.sim.loop import JointSignals, SharedSignals
from layflat.sim.run import prepare_run
from layflat.sim.signals import acting_signals, read_start_angles, start_pressures

ARM = load("paper-arm")


def test_a_disturbance_is_as_usual_before_its_first_step_and_for_other_joints() -> None:
    acting = acting_signals(
        Scenario(duration=1.0, payload=[("0.5 s", "2 kg")], brake={"large": 0.5}, supply=[(0.5, "1 bar")]), ARM, 0.005
    )
    assert acting.named("payload")[0] == ARM.arm.payload
    assert acting.named("payload")[-1] == 2.0
    assert acting.named("supply")[0] == ARM.supply.pressure_gauge
    assert acting.named("brake")[0].tolist() == [0.5, 1.0]


def test_the_loop_reads_every_row_of_the_table() -> None:
    by_joint = [name for name, row in SIGNALS.items() if row.by_joint]
    assert by_joint == list(JointSignals._fields)
    assert [name for name in SIGNALS if name not in by_joint] == list(SharedSignals._fields)


def test_a_demand_is_the_start_before_its_first_step_and_for_other_joints() -> None:
    asked = acting_signals(Scenario(demand=[("1 s", {"large": 0.3})], start={"small": 0.1}), ARM, 0.005).named("demand")
    assert np.all(asked[:200] == [0.0, 0.1])
    assert np.all(asked[200:] == [0.3, 0.1])


def test_a_voltage_of_joints_that_are_not_named_shuts_their_valves() -> None:
    acting = acting_signals(Scenario(voltage=[("1 s", {"large": "6 V"})]), ARM, 0.005)
    assert np.all(acting.named("opening")[:200] == 0.0)
    assert acting.named("opening")[200:] == pytest.approx(np.array([[0.2, 0.0]] * 200))


@pytest.mark.parametrize(
    ("changes", "expected"),
    [
        ({"demand": "40"}, "demand: '40' is a bare number"),
        ({"demand": "40 bar"}, "demand: '40 bar' is not an angle"),
        ({"demand": "61 deg"}, "demand: 61 deg is outside the working stroke of joint 'large'"),
        ({"demand": {"wrist": "1 deg"}}, "demand: unknown joint 'wrist'; joints are large, small"),
        ({"demand": [("2 s", 0.1)]}, "demand: 2 s is after the end; the run ends at 2 s"),
        ({"load": [("3 s", 0.1)]}, "load: 3 s is after the end"),
        ({"payload": [("3 s", 0.1)]}, "payload: 3 s is after the end"),
        ({"demand": np.full((3, 2), 0.0)}, r"demand: an array of shape (3, 2) does not fit"),
        ({"duration": "-1 s"}, "duration: -1 s is out of range"),
        ({"duration": True}, "duration: True is not a time"),
        ({"duration": "1000 h"}, "duration: 3.6e+06 s is out of range"),
        ({"supply": "-2 bar"}, "supply: -200000 Pa is out of range; give a gauge pressure above vacuum"),
        ({"supply": 4}, 'supply: 4 Pa is hardly any pressure; give a gauge pressure such as "4 bar"'),
        ({"supply": "200 bar"}, "supply: 2e+07 Pa is out of range"),
        ({"payload": "-1 kg"}, "payload: -1 kg is out of range; give a mass of zero or more"),
        ({"payload": "1 t"}, "payload: 1000 kg is out of range"),
        ({"brake": -0.1}, "brake: -0.1 is out of range; give a share from 0 to 1"),
        ({"brake": [("0 s", 1.0), ("1 s", {"small": 50})]}, "brake: 50 is out of range"),
        ({"dither": 1.5}, "dither: 1.5 is out of range; give a share from 0 to 1"),
        ({"load": "5 kN m"}, "load: 5000 N m is out of range"),
        ({"drift": "6 V"}, "drift: 6 V is out of range; give a shift of up to 5 V"),
        ({"opening": "wide"}, "opening: 'wide' is not a number"),
        ({"opening": 1.1}, "opening: 1.1 is out of range; give a share from -1 to 1"),
        ({"voltage": 100}, "voltage: 100 V is out of range; give 0 to 10 V, the range of the valve"),
        ({"voltage": np.full((400, 2), -3.0)}, "voltage: -3 V is out of range"),
        ({"opening": 0.1, "demand": 0.2}, "opening: stands beside demand: a run in open loop follows none"),
        ({"opening": 0.1, "tip": [0.5, 0.3]}, "opening: stands beside tip"),
        ({"opening": 0.1, "demand_velocity": 0.2}, "opening: stands beside demand_velocity"),
        ({"opening": 0.1, "voltage": 5.0}, "opening: stands beside a voltage"),
        ({"voltage": 5.0, "demand": 0.2}, "voltage: stands beside a demand"),
        ({"voltage": 5.0, "tip": [0.5, 0.3]}, "voltage: stands beside a demand"),
        ({"demand": 0.3, "demand_velocity": 0.5}, "demand_velocity: goes through 1 rad where the demand changes by 0"),
        ({"demand_velocity": np.full(400, 30.0)}, "demand_velocity: goes through 60 rad"),
        ({"demand": 0.3, "demand_acceleration": 5}, "demand_acceleration: goes through 10 rad/s where its velocity"),
        ({"demand": lambda t: 0.2 * t, "demand_velocity": 12}, "demand_velocity: goes through 24 rad"),
        ({"demand_velocity": "5000 deg/s"}, "demand_velocity: goes through"),
        ({"demand_velocity": 250.0}, "demand_velocity: 250 rad/s is out of range"),
        ({"demand_stiffness": -1}, "demand_stiffness: -1 N m/rad is out of range"),
        ({"noise": "no"}, "noise: 'no' is neither True nor False"),
        ({"noise": 1}, "noise: 1 is neither True nor False"),
        ({"seed": 1.5}, "seed: 1.5 is not a whole number; give 0 to 4294967295"),
        ({"seed": "1"}, "seed: '1' is not a whole number"),
        ({"seed": None}, "seed: None is not a whole number"),
        ({"seed": True}, "seed: True is not a whole number"),
        ({"seed": -1}, "seed: -1 is out of range"),
    ],
)
def test_mistakes_are_named(changes: dict[str, object], expected: str) -> None:
    with pytest.raises(InputError) as caught:
        acting_signals(Scenario(**changes), ARM, 0.005)  # type: ignore[arg-type]
    assert expected in str(caught.value)


def test_rates_that_fit_their_demand_are_taken() -> None:
    times = 0.005 * np.arange(400)
    moved = np.where(times < 1.0, 0.3 * np.sin(2.0 * times), -0.5)  # with a jump
    rates = (
        np.where(times < 1.0, 0.6 * np.cos(2.0 * times), 0.0),
        np.where(times < 1.0, -1.2 * np.sin(2.0 * times), 0.0),
    )
    acting = acting_signals(Scenario(demand=moved, demand_velocity=rates[0], demand_acceleration=rates[1]), ARM, 0.005)
    for name, rate in zip(("demand_velocity", "demand_acceleration"), rates, strict=True):
        assert np.array_equal(acting.named(name)[:, 0], rate)


@pytest.mark.parametrize("start", [np.array([0.1, 0.2]), (0.1, 0.2), {"large": 0.1, "small": 0.2}])
def test_a_start_is_one_row(start: Any) -> None:
    angles = read_start_angles(Scenario(start=start), ARM)
    assert angles is not None
    assert angles.tolist() == [0.1, 0.2]


@pytest.mark.parametrize("start", [[("0 s", 0.1)], lambda t: t, "61 deg", True, np.zeros((400, 2)), {"wrist": 0.0}])
def test_what_is_no_start(start: Any) -> None:
    with pytest.raises(InputError, match="start: "):
        read_start_angles(Scenario(start=start), ARM)


@pytest.mark.parametrize(
    "pressures", ["3 bar", 3e5, ("3 bar",), ("3 bar", 3.0), ("3 bar", True), {"large": "3 bar"}, {"wrist": (3e5, 3e5)}]
)
def test_what_are_no_pressures(pressures: Any) -> None:
    with pytest.raises(InputError, match="pressures: "):
        start_pressures(Scenario(pressures=pressures), ARM)


def test_noise_comes_from_the_seed_alone() -> None:
    one, same, other = (prepare_run(ARM, Scenario(seed=seed)).samples for seed in (1, 1, 2))
    assert np.array_equal(one, same)
    assert not np.array_equal(one, other)


@pytest.mark.parametrize("seed", [0, 7, None])
def test_noise_without_end_is_the_noise_of_a_run(seed: int | None) -> None:
    count = 2 * NOISE_BLOCK + 3
    one_by_one = np.array(list(islice(noise_samples(seed, 2), count)))
    assert np.array_equal(one_by_one, sensor_noise(seed, count, 2))
