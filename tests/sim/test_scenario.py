from itertools import islice
from math import radians

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from layflat.description import units as u
from layflat.errors import InputError
from layflat.machine import load
from layflat.physics.noise import NOISE_BLOCK, noise_samples, sensor_noise
from layflat.sim import Scenario
from layflat.sim.scenario import signals, spread

ARM = load("paper-arm")
NAMES = ["large", "small"]
TIMES = 0.005 * np.arange(200)


def test_a_constant_fills_all_joints() -> None:
    assert np.all(spread("30 deg", TIMES, NAMES, u.ANGLE, "x") == radians(30))


def test_a_table_by_joint_leaves_the_others_at_zero() -> None:
    rows = spread({"small": "30 deg"}, TIMES, NAMES, u.ANGLE, "x")
    assert np.all(rows[:, 0] == 0.0)
    assert np.all(rows[:, 1] == radians(30))


@given(st.floats(0.011, 0.9))
def test_a_step_holds_from_its_time_on(at: float) -> None:
    rows = spread([(0.0, 0.1), (at, 0.2)], TIMES, NAMES, u.ANGLE, "x")[:, 0]
    assert np.all(rows[TIMES < at - 1e-6] == 0.1)
    assert np.all(rows[TIMES >= at] == 0.2)


def test_a_disturbance_is_as_usual_before_its_first_step_and_for_other_joints() -> None:
    acting = signals(
        Scenario(duration=1.0, payload=[("0.5 s", "2 kg")], brake={"large": 0.5}, supply=[(0.5, "1 bar")]), ARM, 0.005
    )
    assert acting.payload[0] == ARM.arm.payload
    assert acting.payload[-1] == 2.0
    assert acting.supply[0] == ARM.supply.pressure
    assert acting.brake[0, 0] == 0.5 * ARM.joint["large"].brake.torque
    assert acting.brake[0, 1] == ARM.joint["small"].brake.torque


def test_a_function_and_an_array_mean_the_same() -> None:
    def wave(t: float) -> float:
        return float(np.sin(t))

    rows = spread(wave, TIMES, NAMES, u.ANGLE, "x")
    assert np.array_equal(rows, spread(np.sin(TIMES), TIMES, NAMES, u.ANGLE, "x"))


@pytest.mark.parametrize(
    ("changes", "expected"),
    [
        ({"demand": "40"}, "demand: '40' is a bare number"),
        ({"demand": "40 bar"}, "demand: '40 bar' is not an angle"),
        ({"demand": "61 deg"}, "demand: 61 deg is outside the working stroke of joint 'large'"),
        ({"demand": {"wrist": "1 deg"}}, "demand: unknown joint 'wrist'; joints are large, small"),
        ({"demand": ["1 deg"]}, "demand: has 1 values; give 2: large, small"),
        ({"demand": [("1 s", 0.0), ("1 s", 0.1)]}, "demand: the times of its steps do not grow"),
        ({"demand": np.full((3, 2), 0.0)}, r"demand: an array of shape (3, 2) does not fit"),
        ({"demand": np.full(400, np.nan)}, "demand: holds a value that is not finite"),
        ({"demand": float("nan")}, "demand: nan is not finite"),
        ({"duration": "-1 s"}, "duration: -1 s is out of range"),
        ({"supply": "-2 bar"}, "supply: -200000 is out of range; give a gauge pressure above vacuum"),
        ({"payload": "-1 kg"}, "payload: -1 is out of range; give a mass of zero or more"),
        ({"brake": -0.1}, "brake: -0.1 is out of range; give a share of zero or more"),
        ({"dither": 1.5}, "dither: 1.5 is out of range; give a share from 0 to 1"),
        ({"opening": "wide"}, "opening: 'wide' is not a number"),
    ],
)
def test_mistakes_are_named(changes: dict[str, object], expected: str) -> None:
    with pytest.raises(InputError) as caught:
        signals(Scenario(**changes), ARM, 0.005)  # type: ignore[arg-type]
    assert expected in str(caught.value)


def test_noise_comes_from_the_seed_alone() -> None:
    one, same, other = (signals(Scenario(seed=seed), ARM, 0.005).noise for seed in (1, 1, 2))
    assert np.array_equal(one, same)
    assert not np.array_equal(one, other)


@pytest.mark.parametrize("seed", [0, 7, None])
def test_noise_without_end_is_the_noise_of_a_run(seed: int | None) -> None:
    count = 2 * NOISE_BLOCK + 3
    one_by_one = np.array(list(islice(noise_samples(seed, 2), count)))
    assert np.array_equal(one_by_one, sensor_noise(seed, count, 2))
