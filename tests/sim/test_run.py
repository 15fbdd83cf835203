from math import radians
from typing import Any

import numpy as np
import pytest
import xarray

from layflat.errors import DivergedError, InputError
from layflat.machine import changed, load
from layflat.machine.signals import SIGNALS
from layflat.sim import Scenario, rollout

ARM = load("paper-arm")


def test_a_run_names_its_columns_and_units() -> None:
    run = rollout("paper-arm", duration="0.1 s")
    assert run.sizes == {"time": 21, "joint": 2, "axis": 2}
    for name in SIGNALS:
        assert run[name].attrs["units"]
        assert np.isfinite(run[name]).all()
    assert list(run["joint"].to_numpy()) == ["large", "small"]
    assert run.attrs["machine_name"] == "paper-arm"


def test_same_seed_same_run() -> None:
    one, same, other = (rollout(ARM, "10 deg", start=0.0, duration=0.3, seed=seed) for seed in (1, 1, 2))
    xarray.testing.assert_identical(one, same)
    assert not np.array_equal(one["measured_angle"], other["measured_angle"])


def test_recording_more_often_changes_nothing() -> None:
    coarse = rollout(ARM, "10 deg", start=0.0, duration=0.3)
    fine = rollout(ARM, "10 deg", start=0.0, duration=0.3, records=5)
    assert np.array_equal(coarse["angle"], fine["angle"][::5])


def test_sensors_read_the_last_instant_too() -> None:
    run = rollout("paper-small-joint", "40 deg", duration=0.3, start=0.0, noise=False)
    last = run.isel(time=-1, joint=0)
    assert abs(last["velocity"]) > 0.5
    assert last["measured_angle"] == pytest.approx(float(last["angle"]), abs=radians(0.1))
    assert last["measured_pressure"] == pytest.approx(float(last["pressure_a"] - last["pressure_b"]), abs=500.0)


def test_the_arm_goes_where_it_is_asked() -> None:
    run = rollout(ARM, {"large": "20 deg", "small": "-15 deg"}, start=0.0, duration="2 s")
    reached = np.degrees(run["angle"][-1].to_numpy())
    assert reached == pytest.approx([20, -15], abs=0.3)


def test_scenario_and_changes_are_laid_over_each_other() -> None:
    scenario = Scenario(demand="10 deg", duration=0.2, seed=3)
    run = rollout(ARM, scenario=scenario, seed=4)
    assert run.attrs["seed"] == 4
    assert np.all(run["demand"] == radians(10))


def test_a_demand_is_laid_over_a_scenario() -> None:
    run = rollout(ARM, "20 deg", scenario=Scenario(demand="10 deg", duration=0.1))
    assert np.all(run["demand"] == radians(20))
    assert rollout(ARM, scenario=Scenario(demand="10 deg", duration=0.1)).demand[0, 0] == radians(10)


def test_a_run_s_own_demand_gives_the_run_again() -> None:
    run = rollout(ARM, [("0.1 s", {"large": "20 deg"})], duration=0.3)
    assert np.array_equal(rollout(ARM, run["demand"], duration=0.3)["angle"], run["angle"])
    frame = run["demand"].to_pandas()
    assert np.array_equal(rollout(ARM, frame, duration=0.3)["angle"], run["angle"])
    assert run["angle"][0].values.tolist() == [0.0, 0.0]


def test_a_step_that_would_lose_the_dither_is_refused() -> None:
    fast = changed(ARM, "valve.dither.frequency", 2000.0)
    with pytest.raises(InputError, match=r"step: 0\.5 ms is too long for the 2000 Hz of the valves.*0\.05 ms"):
        rollout(fast, duration=0.1)
    rollout(changed(fast, "valve.dither.amplitude", 0.0), duration=0.1)
    with pytest.raises(InputError, match="step: 1 ms is too long for the 600 Hz"):
        rollout(changed(load("paper-arm-switching"), "valve.frequency", 600.0), step="1 ms")


def test_payload_change_and_supply_loss_are_recorded() -> None:
    run = rollout(
        ARM, payload=[("0 s", "1 kg"), ("0.1 s", "2 kg")], supply=[("0 s", "4 bar"), ("0.1 s", "0 bar")], duration=0.2
    )
    assert run["payload"][0] == 1.0
    assert run["payload"][-1] == 2.0
    assert run["supply"][-1] == pytest.approx(101325.0)


def test_without_air_the_joint_can_not_move() -> None:
    ambient = ARM.supply.ambient_pressure
    run = rollout(ARM, "20 deg", start=0.0, supply="0 bar", pressures=(ambient, ambient), duration="0.5 s")
    assert np.all(run["angle"] == 0.0)


def test_mirrored_demands_give_mirrored_runs() -> None:
    calm = changed(changed(ARM, "valve.dither.amplitude", 0.0), "arm.elbow", 0.0)
    there, back = (
        rollout(calm, [(0.0, (0.0, 0.0)), (0.1, (s * 0.3, s * 0.2))], duration=0.6, noise=False) for s in (1, -1)
    )
    # The converters round halves up on both sides, so that counts differ by one now and then.
    assert np.degrees((there["angle"] + back["angle"]).to_numpy()) == pytest.approx(0.0, abs=0.05)


def test_gravity_pulls_the_way_it_is_said_to() -> None:
    hanging = changed(changed(ARM, "arm.gravity", 9.81), "arm.gravity_direction", radians(-90.0))
    ambient = ARM.supply.ambient_pressure
    run = rollout(hanging, opening=0.0, brake=0.0, supply=0.0, pressures=(ambient, ambient), duration=0.2, noise=False)
    assert run["angle"].sel(joint="large")[-1] < -0.01


def test_a_log_that_says_when_dither_stopped_is_followed_to_the_same_pressures() -> None:
    run = rollout("paper-arm-tracking", {"small": "20 deg"}, start=0.0, duration=1.0, noise=False)
    rows = {name: run[name].to_numpy()[:-1] for name in ("voltage", "dither_share")}
    assert rows["dither_share"].min() < 0.5

    def missed(**changes: Any) -> float:
        again = rollout("paper-arm-tracking", voltage=rows["voltage"], start=0.0, duration=1.0, noise=False, **changes)
        return float(np.abs(again["pressure_a"] - run["pressure_a"]).max())

    assert missed(dither=rows["dither_share"]) < 1.0
    assert missed() > 100.0


def test_divergence_says_when_and_where_and_keeps_the_data() -> None:
    wild = changed(ARM, "joint.small.stops.stop_stiffness", 1e9)
    with pytest.raises(DivergedError, match=r"diverged at t = .* in joint '(large|small)'") as caught:
        rollout(wild, opening=(0.0, 1.0), brake=0.0, duration=2.0)
    kept = caught.value.run
    assert isinstance(kept, xarray.Dataset)
    assert 0.0 < float(kept["time"][-1]) < 2.0


@pytest.mark.parametrize(
    ("options", "expected"),
    [
        ({"step": "1 s"}, "step: 1 s is out of range"),
        ({"records": 0}, "records: 0 is out of range"),
        ({"sead": 1}, "unknown option 'sead'"),
        ({"records": 1.5}, "records: 1.5 is not a whole number; give 1 to 10000"),
        ({"records": 10000, "duration": 900.0}, "records: a run of 900 s with 10000 records .* GiB"),
        ({"controller": "nobody"}, "nobody: no such machine"),
        ({"controller": "picking-arm"}, "controller: picking-arm: has joints base, shoulder"),
        ({"scenario": "20 deg"}, r"scenario: '20 deg' is not a Scenario; give Scenario\(demand='20 deg'\)"),
        ({"progress": 5}, "progress: 5 can't be called"),
        ({"start": "70 deg"}, "start: 70 deg is outside the working stroke"),
        ({"pressures": (0.0, 0.0)}, "pressures: 0 Pa is out of range; give absolute pressures"),
    ],
)
def test_wrong_options(options: dict[str, object], expected: str) -> None:
    with pytest.raises(InputError, match=expected):
        rollout(ARM, **options)  # type: ignore[arg-type]
