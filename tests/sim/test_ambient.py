"""Weather: the ambient pressure over time."""

from typing import Any

import numpy as np

from layflat.machine import changed, load
from layflat.sim import Scenario, rollout
from layflat.sim.ensemble import ensemble

ARM = load("paper-arm")
STEP: dict[str, Any] = {"demand": [("0.1 s", "20 deg")], "duration": "0.8 s", "start": 0.0}


def test_a_run_in_thin_air_is_that_of_a_machine_described_there() -> None:
    there = rollout(changed(ARM, "supply.ambient_pressure", "0.8 bar"), **STEP)
    run, varied = rollout(ARM, ambient="0.8 bar", **STEP), {"scenario.ambient": ["0.8 bar"]}
    assert np.array_equal(run["angle"], there["angle"])
    runs = (ensemble(ARM, Scenario(**STEP), varied), ensemble(ARM, Scenario(ambient=8e4, **STEP), runs=1))
    assert np.array_equal(runs[0]["air_used"], runs[1]["air_used"])
    falls = rollout(ARM, ambient=[("0 s", "1 bar"), ("0.4 s", "0.8 bar")], **STEP)
    assert falls["ambient"][0] == 1e5
    assert falls["supply"][-1] == ARM.supply.pressure_gauge + 8e4
