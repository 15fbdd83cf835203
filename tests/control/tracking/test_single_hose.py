"""The tracking law with a single hose: a lift that gravity and a spring bring back."""

import numpy as np
import pytest

from layflat.machine import load
from layflat.sim import rollout

pytestmark = pytest.mark.compiled

MOVES = [("0 s", "-40 deg"), ("0.2 s", "40 deg"), ("1.2 s", "-40 deg")]


@pytest.mark.parametrize("payload", ["0 kg", "0.75 kg", "1.5 kg"])
def test_a_lift_settles_with_any_payload_either_way(payload: str) -> None:
    run = rollout("single-joint-lift", MOVES, payload=payload, duration="2.2 s")
    angle, time = np.degrees(run["angle"].to_numpy()[:, 0]), run.time.to_numpy()
    for since, until, goal in ((0.8, 1.2, 40.0), (1.8, 2.2, -40.0)):
        rests = angle[(time > since) & (time < until)]
        assert rests == pytest.approx(goal, abs=0.3)
        assert np.ptp(rests) < 0.1
    assert angle.max() < 40.5
    assert angle.min() > -41.0
    assert run["pressure_b"].to_numpy() == pytest.approx(load("single-joint-lift").supply.ambient_pressure, rel=1e-9)
