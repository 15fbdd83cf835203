"""Many machines at once do what each does by itself."""

from dataclasses import replace

import numpy as np
import pytest

from layflat.description.change import value_at
from layflat.experiments import bench
from layflat.experiments.bench import INERTIA_PER_TORQUE, maximum_torque, payload_for_inertia
from layflat.experiments.calibration import evidence as e
from layflat.experiments.dither import ripple
from layflat.experiments.limits import AT, STEP, stepped
from layflat.experiments.open_loop import SMALL_SWEEP
from layflat.experiments.two_axis import HALF
from layflat.machine import changed
from layflat.sim import rollout
from layflat.sim.metrics import BAND

pytestmark = pytest.mark.compiled
GAIN = "joint.small.gains.far.pressure"
FEW = replace(e.FINE, counts=(3, 2), repeats=2)


@pytest.fixture
def evidence(monkeypatch: pytest.MonkeyPatch) -> e.Evidence:
    monkeypatch.setattr(e, "WATCHED", 1.0)
    return e.Evidence(bench())


def test_every_machine_has_its_values_and_every_run_its_payload(evidence: e.Evidence) -> None:
    values = {GAIN: np.array([1e-5, 4e-5]), "joint.large.valve_size": np.array([1.0, 2.0])}
    steps = evidence.steps(values, seed=7, effort=FEW)
    assert steps.unbraked.shape[:2] == (2, e.UNBRAKED)
    assert steps.carried_braked.time.shape == (2, 3, 2)
    assert steps.carried_earlier.time.shape == (2, 2, 2)
    machine = changed(evidence.bench.axis_one, GAIN, 4e-5)
    payload = payload_for_inertia(machine, "small", INERTIA_PER_TORQUE * maximum_torque(machine, "small"))
    run = rollout(machine, scenario=replace(stepped(0.0, 7 + 1, payload), duration=AT + 1.0))
    error = run["angle"].to_numpy()[round(AT / machine.cycle) : -1, 0] - STEP / 2
    assert np.array_equal(steps.unbraked[1, 1], error)


def test_what_a_run_comes_to() -> None:
    time = 0.005 * np.arange(1000)
    error = np.where(time < 1.0, 1.0, 0.5 * BAND * np.sin(8.0 * np.pi * time))
    lost = np.where(time < 4.0, 0.0, np.nan)
    found = e.carried(np.stack([error, lost])[None], np.array([0.01, 0.02]), 0.005)
    assert found.time[0, :, 0] == pytest.approx([1.0, np.inf])
    assert found.swing[0, 0, 0] == pytest.approx(BAND, rel=5e-3)
    assert found.late[0, 0, 0] == pytest.approx(0.5 * BAND / np.sqrt(2.0), rel=1e-2)
    assert found.swing[0, 1, 0] == e.LOST


def test_inertias_lie_elsewhere_with_every_seed_while_searching(evidence: e.Evidence) -> None:
    values = {GAIN: np.array([1e-5])}
    one, other = (evidence.steps(values, seed, e.ROUGH) for seed in (1, 2))
    assert one.carried_braked.ratios[[0, -1]] == pytest.approx([INERTIA_PER_TORQUE, e.MOST])
    assert np.all(np.diff(one.carried_braked.ratios) > 0.0)
    assert not np.isin(one.carried_braked.ratios[1:-1], other.carried_braked.ratios).any()


def test_the_earlier_actuators_pressure_gains_follow_its_torque(evidence: e.Evidence) -> None:
    scaled, plain = (value_at(one, GAIN) for one in (evidence.bench.earlier_scaled, evidence.bench.earlier))
    assert evidence.scale == pytest.approx(scaled / plain)


def test_what_a_small_motion_keeps_is_what_a_sweep_shows(evidence: e.Evidence) -> None:
    earlier = evidence.bench.earlier
    curves = [evidence.bench.curve("small", earlier, share=share) for share in (SMALL_SWEEP, None)]
    kept = evidence.small_motion({GAIN: np.array([1e-5, 2e-5])})
    assert kept == pytest.approx(np.full(2, curves[0].height / curves[1].height), rel=2e-3)


def test_the_arm_moves_either_way(evidence: e.Evidence) -> None:
    angles = evidence.arm_moves({GAIN: np.array([2e-5])}, seed=1, effort=FEW)
    assert angles.shape[:2] == (1, 4)
    assert angles[0, :, 0] == pytest.approx(np.full((4, 2), -HALF), abs=1e-6)


def test_dither_shows_in_the_pressure_as_the_papers_experiment_finds_it(evidence: e.Evidence) -> None:
    arm = evidence.bench.arm
    _, pressure = ripple(arm, 1.0, 50.0)
    found = evidence.ripple(arm, {"valve.conductance": np.array([1.0, 0.5]) * value_at(arm, "valve.conductance")})
    assert found[0] == pytest.approx([pressure[joint] for joint in arm.joints], rel=0.05)
    assert found[1] == pytest.approx(0.5 * found[0], rel=0.2)
