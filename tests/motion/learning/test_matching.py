import numpy as np
import pytest

from layflat.machine import load
from layflat.motion.learning import align_measurement
from layflat.motion.optimal import plan_time_optimal
from layflat.motion.path import JointLine
from layflat.motion.trajectory import MotionSequence, RestMotion

ARM = load("paper-arm-tracking")
START, END = np.radians([-30.0, 20.0]), np.radians([20.0, -30.0])
MOTION = MotionSequence.join(
    RestMotion(0.1, START), plan_time_optimal(ARM, JointLine(START, END), reserve=0.35), RestMotion(0.2, END)
)
DEMAND = MOTION.rows(ARM.cycle)


@pytest.mark.parametrize("late", [-0.5, -0.24, 0.0, 0.1, 0.5])
def test_it_is_found_between_the_cycles_of_a_log(late: float) -> None:
    times = ARM.cycle * (np.arange(len(DEMAND.angles) + 150) - 70 + late)
    asked = MOTION.angles_at(times)
    found = align_measurement(DEMAND, asked, asked + 0.02 * np.sin(9.0 * times)[:, None], ARM.cycle)
    assert found is not None
    instants = ARM.cycle * np.arange(len(found))
    expected = DEMAND.angles + 0.02 * np.sin(9.0 * instants)[:, None]
    assert np.abs(found - expected).max() < 3e-4


@pytest.mark.parametrize("change", [0.002, np.nan])
def test_another_demand_is_not(change: float) -> None:
    asked = np.vstack([DEMAND.angles, DEMAND.angles[-1:]])
    asked[60, 1] += change
    assert align_measurement(DEMAND, asked, asked, ARM.cycle) is None
    assert align_measurement(DEMAND, DEMAND.angles[1:], DEMAND.angles[1:], ARM.cycle) is None
