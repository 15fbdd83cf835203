"""Many machines at once do what each does by itself."""

import numpy as np
import pytest

from layflat.description.change import value_at
from layflat.experiments import bench
from layflat.experiments.bench import INERTIA_PER_TORQUE
from layflat.experiments.calibration import evidence as e
from layflat.experiments.dither import ripple
from layflat.experiments.limits import AT, STEP, stepped
from layflat.experiments.open_loop import SMALL_SWEEP
from layflat.experiments.two_axis import HALF
from layflat.machine import changed
from layflat.sim import rollout

pytestmark = pytest.mark.compiled
GAIN = "joint.small.gains.far.pressure"


@pytest.fixture
def evidence(monkeypatch: pytest.MonkeyPatch) -> e.Evidence:
    monkeypatch.setattr(e, "FINE_COUNTS", (3, 2))
    monkeypatch.setattr(e, "WATCHED", 1.0)
    return e.Evidence(bench())


def test_every_machine_has_its_values_and_every_run_its_payload(evidence: e.Evidence) -> None:
    values = {GAIN: np.array([1e-5, 4e-5]), "joint.large.valve_size": np.array([1.0, 2.0])}
    steps = evidence.steps(values, seed=7, fine=True)
    assert steps.unbraked.shape[:2] == (2, 2)
    assert steps.carried_braked.shape == (2, 3 * e.REPEATS, steps.braked.shape[2])
    assert steps.carried_earlier.shape == (2, 2 * e.REPEATS, steps.braked.shape[2])
    machine = changed(evidence.bench.axis_one, GAIN, 4e-5)
    case = stepped(1.0, 7 + 2, machine.arm.payload)
    case = case.__class__(**{**case.__dict__, "duration": AT + 1.0})
    run = rollout(machine, scenario=case)["angle"].to_numpy()[:, 0]
    since = round(AT / machine.cycle)
    assert np.array_equal(steps.braked[1, 0], run[since : since + steps.braked.shape[2]] - STEP / 2)


def test_inertias_lie_elsewhere_with_every_seed_while_searching(evidence: e.Evidence) -> None:
    values = {GAIN: np.array([1e-5])}
    one, other = evidence.steps(values, seed=1), evidence.steps(values, seed=2)
    assert one.ratios[[0, -1]] == pytest.approx([INERTIA_PER_TORQUE, e.MOST])
    assert np.all(np.diff(one.ratios) > 0.0)
    assert not np.isin(one.ratios[1:-1], other.ratios).any()


def test_the_earlier_actuators_pressure_gains_follow_its_torque(evidence: e.Evidence) -> None:
    scaled, plain = (value_at(one, GAIN) for one in (evidence.bench.earlier_scaled, evidence.bench.earlier))
    assert evidence.scale == pytest.approx(scaled / plain)


def test_what_a_small_motion_keeps_is_what_a_sweep_shows(evidence: e.Evidence) -> None:
    earlier = evidence.bench.earlier
    curves = [evidence.bench.curve("small", earlier, share=share) for share in (SMALL_SWEEP, None)]
    kept = evidence.small_motion({GAIN: np.array([1e-5, 2e-5])})
    assert kept == pytest.approx(np.full(2, curves[0].height / curves[1].height), rel=2e-3)


def test_the_arm_moves_either_way(evidence: e.Evidence) -> None:
    angles = evidence.arm_moves({GAIN: np.array([2e-5])}, seed=1)
    assert angles.shape[:2] == (1, 2)
    assert angles[0, :, 0] == pytest.approx(np.full((2, 2), -HALF), abs=1e-6)


def test_dither_shows_in_the_pressure_as_the_papers_experiment_finds_it(evidence: e.Evidence) -> None:
    arm = evidence.bench.arm
    _, pressure = ripple(arm, 1.0, 50.0)
    found = evidence.ripple(arm, {"valve.conductance": np.array([1.0, 0.5]) * value_at(arm, "valve.conductance")})
    assert found[0] == pytest.approx([pressure[joint] for joint in arm.joints], rel=0.05)
    assert found[1] == pytest.approx(0.5 * found[0], rel=0.2)
