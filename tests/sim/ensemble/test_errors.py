from typing import Any

import numpy as np
import pytest

from layflat.errors import InputError
from layflat.machine import load
from layflat.sim import Scenario
from layflat.sim.ensemble import ensemble
from layflat.sim.ensemble.cases import MAX_CACHED_ARRAYS, prepare_cases

CASE = Scenario(duration="0.01 s")


@pytest.mark.parametrize(
    ("vary", "message"),
    [
        ({"joint.small.brake.torqe": [1.0]}, r"nearest is 'joint\.small\.brake\.torque'"),
        ({"joint.small.brake": [1.0]}, "not a single number"),
        ({"scenario.paylod": [1.0]}, "scenario.paylod"),
        ({"seed": [1.0, 2.0], "arm.payload": [1.0]}, "different numbers of runs"),
        ({"arm.payload": [np.nan]}, "not finite"),
        ({"arm.payload": [[1.0]]}, "one number a run"),
        ({"arm.payload": []}, "one number a run"),
        ({"scenario": [1.0]}, "0 to 0"),
        ({"controller.cycle": [5e-3]}, "same in all runs"),
        ({"arm.payload": ["1 bar"]}, "vary: arm.payload: '1 bar' is not a mass"),
        ({"arm.payload": "1 kg"}, "vary: arm.payload: '1 kg' is no list"),
        ({"arm.payload": [1j]}, "vary: arm.payload: 1j is not a mass"),
        ({"arm.payload": np.ma.masked_all(2)}, "vary: arm.payload: holds masked values"),
        ({"seed": ["1"]}, "vary: seed: '1' is not a number"),
        ({"scenario.supply": [4.0]}, "vary: scenario.supply: 4 Pa is hardly any pressure"),
        ({"scenario.payload": ["-1 kg"]}, "vary: scenario.payload: -1 kg is out of range"),
        ({"scenario.brake.small": [-1.0]}, "vary: scenario.brake.small: -1 is out of range"),
        ({"start.angle.small": ["100 deg"]}, "vary: start.angle.small: 100 deg is outside"),
        ({"start.pressure_a.small": [3.0]}, "vary: start.pressure_a.small: 3 Pa is out of range"),
        ({"valve.dither.frequency": [50.0, 3000.0]}, "step: 0.5 ms is too long for the 3000 Hz"),
        ({"arm.gravity_direction": [0.0, 1.0], "seed": [1.5, 2.0]}, "vary: seed: holds a number that is no seed"),
        ([1.0], "vary: .* is no table of what varies"),
    ],
)
def test_what_can_not_vary(vary: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=message):
        ensemble("paper-arm", CASE, vary)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"traces": ["angel"]}, "'angel' is not a signal"),
        ({"every": 0}, "every"),
        ({"every": 10**50}, "every: 1000.* is out of range"),
        ({"device": np.array([1.0, 2.0])}, r"device: array\(\[1., 2.\]\) is not a device"),
        ({"runs": np.timedelta64(1, "s")}, "runs: .* is not a whole number"),
        ({"step": "1 s"}, "step"),
        ({"band": "1 kg"}, "band"),
        ({"band": -0.1}, "band: -0.1 rad is out of range"),
        ({"runs": 1.5}, "runs: 1.5 is not a whole number"),
        ({"runs": 10**9}, "runs: an ensemble of 1000000000 runs of 0.01 s needs about .* GiB of memory"),
        ({"threads": 0}, "threads: 0 is out of range"),
        ({"metrics": "settling"}, "metrics: 'settling' is no list of names"),
        ({"traces": 5}, "traces: 5 is no list of names"),
        ({"every": 1.5}, "every: 1.5 is not a whole number"),
        ({"controller": "nobody"}, "nobody: no such machine"),
    ],
)
def test_options(options: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=message):
        ensemble("paper-arm", CASE, **{"runs": 1, **options})


@pytest.mark.parametrize("given", ["20 deg", 5, [], [CASE, "x"], {"demand": 0.1}])
def test_what_is_no_scenario(given: Any) -> None:
    with pytest.raises(InputError, match="scenario: "):
        ensemble("paper-arm", given, runs=1)


def test_values_that_vary_may_have_units() -> None:
    numbers, texts = (
        ensemble("paper-arm", Scenario(demand=0.1, duration="0.05 s"), {"arm.payload": own, "scenario.supply": supply})
        for own, supply in (([1.0, 0.5], [4e5, 3e5]), (["1 kg", "500 g"], ("4 bar", "3 bar")))
    )
    assert numbers.identical(texts)


def test_scenarios_last_equally_long() -> None:
    with pytest.raises(InputError, match="equally long"):
        ensemble("paper-arm", [CASE, Scenario(duration="0.02 s")], {"scenario": [0, 1]})


def test_progress_counts_all_runs() -> None:
    done: list[int] = []
    ensemble("paper-arm", CASE, {"seed": np.arange(37)}, progress=done.append)
    assert sum(done) == 37


def test_only_the_metrics_that_are_asked_for_are_kept() -> None:
    scenario = Scenario(demand=0.1, duration="0.05 s")
    whole = ensemble("paper-arm", scenario, runs=1)
    some = ensemble("paper-arm", scenario, runs=1, metrics=("air_used", "hysteresis"))
    assert set(some) == {"air_used", "hysteresis", "diverged"}
    assert all(some[name].identical(whole[name]) for name in some)
    with pytest.raises(InputError, match="metrics: 'speed' is not a metric; use settling, overshoot, "):
        ensemble("paper-arm", scenario, runs=1, metrics=("speed",))


@pytest.mark.parametrize(("indices", "wrong"), [([-1.0, 0.0], "-1"), ([0.0, 0.5, 1.0], "0.5"), ([1.0, 2.0, 3.0], "2")])
def test_the_first_index_of_no_scenario_is_named(indices: list[float], wrong: str) -> None:
    with pytest.raises(InputError, match=f"vary: scenario: {wrong} is not a scenario; give 0 to 1"):
        ensemble("paper-arm", [CASE, CASE], {"scenario": indices})


def test_as_many_arrays_of_scenarios_are_kept_as_their_limit_says() -> None:
    count = MAX_CACHED_ARRAYS + 2
    cases = prepare_cases(load("paper-arm"), [CASE] * count, {"scenario": np.arange(float(count))}, None)
    kept = []
    for row in range(count):
        cases.scenario_arrays(np.array([row]), 0.005, 0.001)
        kept.append(len(cases._arrays))
    assert kept == [*range(1, MAX_CACHED_ARRAYS + 1), 1, 2]
