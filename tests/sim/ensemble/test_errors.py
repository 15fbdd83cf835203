from typing import Any

import numpy as np
import pytest

from layflat.errors import InputError
from layflat.sim import Scenario
from layflat.sim.ensemble import ensemble

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
    ],
)
def test_what_can_not_vary(vary: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=message):
        ensemble("paper-arm", CASE, vary)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"thread": 1}, "ensemble: unknown option 'thread'; did you mean 'threads'?"),
        ({"traces": ["angel"]}, "'angel' is not a signal"),
        ({"every": 0}, "every"),
        ({"step": "1 s"}, "step"),
        ({"band": "1 kg"}, "band"),
    ],
)
def test_options(options: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=message):
        ensemble("paper-arm", CASE, runs=1, **options)


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
