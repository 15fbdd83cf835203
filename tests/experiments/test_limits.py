"""Joints that are watched, against the rollout."""

from dataclasses import replace

import numpy as np
import pytest

from layflat.experiments.axis_one import step_scenario, trace_rollout
from layflat.experiments.bench import load_bench
from layflat.sim.run import rollout


@pytest.mark.parametrize("brake", [0.0, 1.0])
def test_what_is_watched_is_the_rollout_to_the_last_bit(brake: float) -> None:
    machine = load_bench("paper-arm").axis_one
    scenario = replace(step_scenario(brake, 3, 2.0), duration="0.8 s")
    seen, run = trace_rollout(machine, scenario), rollout(machine, scenario=scenario)
    for name in ("time", "joint", "demand", "angle"):
        assert np.array_equal(seen[name], run[name]), name
    assert seen["angle"].dims == run["angle"].dims
    assert np.ptp(seen["angle"].to_numpy()) > 0.1
