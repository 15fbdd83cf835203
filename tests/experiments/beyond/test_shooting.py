import numpy as np
import pytest

from layflat.experiments.beyond.search import (
    OPENING_CHANGE,
    REST_CYCLES,
    OpeningTrial,
    Shooting,
    minimize_cycles,
    settling_cycles,
)
from layflat.machine import load
from layflat.sim import rollout
from layflat.sim.metrics import TIP_BAND

JOINT = load("paper-small-joint-fast")
STEP = Shooting(JOINT, (-0.3,), (0.4,))
OPENINGS = np.random.default_rng(0).uniform(-0.2, 1.0, (3, 12, 1))


def test_errors_are_those_of_a_rollout() -> None:
    padded = np.pad(OPENINGS[1], ((REST_CYCLES, 0), (0, 0)))
    run = rollout(JOINT, start=-0.3, opening=padded, duration=len(padded) * JOINT.cycle, noise=False)
    expected = run["tip"].to_numpy()[REST_CYCLES + 1 :] - STEP.goal
    assert np.array_equal(STEP.errors(OPENINGS)[1], expected)


def test_sensitivities_say_what_an_opening_changes() -> None:
    changed = OPENINGS[:2].copy()
    changed[1] = changed[0]
    k = int(np.argmin(changed[0, :6, 0]))  # where the change is upwards
    changed[1, k, 0] += OPENING_CHANGE
    before, after = STEP.errors(changed)
    found = STEP.sensitivities(OPENINGS[0], 6)
    assert found.shape == (6, 1, 12, 2)
    assert found[k, 0] == pytest.approx((after - before) / OPENING_CHANGE, abs=1e-12)


def test_nothing_acts_before_its_time() -> None:
    found = STEP.sensitivities(OPENINGS[0], 6)
    assert not found[4, 0, :4].any()
    assert found[4, 0, 5:].any()


def test_settled_counts_cycles_until_the_tip_stays() -> None:
    away = np.array([[5.0, 0.0], [1.0, 0.0], [0.0, 3.0], [0.5, 0.5], [0.0, 0.0]])
    assert settling_cycles(away, 2.0) == 4
    assert settling_cycles(away[[1, 3]], 2.0) == 0
    assert settling_cycles(away[[0, 1, 2]], 2.0) == 4  # one more than there are


@pytest.mark.parametrize("settled", [0, 1])
def test_a_step_that_settles_at_once_needs_no_search(settled: int) -> None:
    errors = np.full((40, 2), 0.0)
    errors[: settled and settled - 1] = 1.0
    trial = OpeningTrial(Shooting(load("paper-small-joint"), (0.0,), (0.0,)), np.zeros((40, 1)), errors, 8, TIP_BAND)
    assert trial.settled <= 1
    assert minimize_cycles(trial) is trial
