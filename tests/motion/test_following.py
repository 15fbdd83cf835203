from __future__ import annotations

import numpy as np
import pytest

from layflat.machine import load
from layflat.motion.limits import MotionLimits
from layflat.motion.travel import ANGLE_DEMANDS, RATE_DEMANDS, demand_style, plan_travel

WAY = plan_travel(np.zeros(2), np.array([0.5, -0.3]), MotionLimits((2.0, 2.0), (9.0, 9.0), (200.0, 200.0)))
CYCLE = 5e-3


@pytest.mark.parametrize("name", ["paper-arm", "paper-arm-fast-tuned", "paper-arm-switching"])
def test_a_law_of_the_error_alone_is_asked_ahead_of_a_motion(name: str) -> None:
    assert demand_style(load(name)) == ANGLE_DEMANDS
    demands = ANGLE_DEMANDS.demands(WAY, CYCLE)
    assert demands.angles.tolist() == WAY.demand(CYCLE, lead=ANGLE_DEMANDS.lead_time).tolist()
    assert not demands.velocities.any()


def test_a_law_that_goes_by_rates_is_asked_for_the_motion_itself() -> None:
    assert demand_style(load("paper-arm-tracking")) == RATE_DEMANDS
    demands = RATE_DEMANDS.demands(WAY, CYCLE)
    assert np.diff(demands.angles, axis=0) / CYCLE == pytest.approx(
        (demands.velocities[1:] + demands.velocities[:-1]) / 2, abs=5e-3
    )
    assert demands.angles[-1] == pytest.approx(WAY.end)
