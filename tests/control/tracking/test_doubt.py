"""A model that is too far from the plant is noticed, and given up; one that is not far never is."""

import numpy as np
import pytest

from layflat.control.tracking.arrival import AVERAGING_TIME, MAX_MEAN_SQUARE, ModelResidual, update_residual
from layflat.description.change import changed_all
from layflat.machine import Machine, load
from layflat.sim import rollout

STEPS = [(0.0, [-0.35, -0.35]), (0.3, [0.35, 0.35]), (1.8, [-0.35, -0.35])]
T = 5e-3
CALM = ModelResidual(0.0, 0.0, (0.0, 0.0))


@pytest.fixture(scope="module")
def arm() -> Machine:
    return load("paper-arm-tracking")


def test_a_bump_is_no_doubt_and_what_lasts_is() -> None:
    bumped = update_residual(CALM, 1e9, (0.0, 0.0), T)
    assert bumped.held == 0.0
    doubt = CALM
    for _ in range(round(3 * AVERAGING_TIME / T)):
        doubt = update_residual(doubt, 1.5 * MAX_MEAN_SQUARE, (0.0, 0.0), T)
    assert doubt.held == 1.0


def test_what_was_given_up_is_tried_again_for_another_goal() -> None:
    held = ModelResidual(2.0 * MAX_MEAN_SQUARE, 1.0, (0.2, 0.0))
    assert update_residual(held, 0.0, (0.2, 0.001), T).held == 1.0
    assert update_residual(held, 1.0, (0.3, 0.0), T).held == 0.0


@pytest.mark.compiled
def test_an_arm_that_carries_far_too_much_is_held_and_comes_when_it_does_not(arm: Machine) -> None:
    run = rollout(arm, STEPS, duration="3 s", payload=[("0 s", "1.5 kg"), ("0.3 s", "12 kg"), ("1.7 s", "1.5 kg")])
    gave_up = run.given_up.values[:, 0]
    first = int(np.argmax(gave_up > 0.0))
    assert 0.3 < float(run.time[first]) < 1.2
    centre = arm.valve.centre_voltage  # type: ignore[union-attr]
    assert np.all(run.voltage.sel(time=slice(float(run.time[first]) + T, 1.79)) == centre)
    assert gave_up[-1] == 0.0
    assert np.abs(run.angle.values[-1] + 0.35).max() < np.radians(0.5)


@pytest.mark.compiled
def test_plants_that_differ_within_reason_are_never_given_up(arm: Machine) -> None:
    rough = {"joint.small.brake.torque": 1.5, "joint.large.brake.torque": 9.0, "valve.conductance": 1.6e-8}
    run = rollout(changed_all(arm, rough), STEPS, duration="3 s", controller=arm, supply="3.2 bar", payload="1 kg")
    assert float(run.model_error.max()) < 4.0
    assert np.all(run.given_up == 0.0)
