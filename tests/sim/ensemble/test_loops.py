import numpy as np
import pytest

from layflat.machine import load
from layflat.registers import host_width
from layflat.sim import Scenario
from layflat.sim.ensemble import loops
from layflat.sim.ensemble.cases import prepare_cases


def test_how_many_are_swept_at_a_time_changes_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    brakes = np.linspace(0.0, 6.0, 2 * host_width() + 1)
    prepared = prepare_cases(load("paper-arm"), [Scenario()], {"joint.large.brake.torque": brakes}, None)
    heights, torques = loops.loop_heights(prepared)
    assert np.all(np.diff(heights[:, 0]) > 0.0)
    monkeypatch.setattr(loops, "MAX_BATCH", host_width())
    assert np.array_equal(loops.loop_heights(prepared), (heights, torques))
