"""Many machines at once do what each does by itself."""

from dataclasses import replace

import numpy as np
import pytest

from layflat.description.change import value_at
from layflat.experiments import load_bench
from layflat.experiments.axis_one import STEP, STEP_TIME, AxisOneExperiment, step_scenario
from layflat.experiments.bench import INERTIA_PER_TORQUE, maximum_torque, payload_for_inertia
from layflat.experiments.controller import ControllerExperiment
from layflat.experiments.dither import DitherExperiment, ripple_amplitudes
from layflat.experiments.open_loop import SMALL_SWEEP_FRACTION, OpenLoopExperiment
from layflat.experiments.two_axis import HALF_STEP, TwoAxisExperiment
from layflat.machine import changed
from layflat.physics.step import STEP as STEP_FINE
from layflat.sim import rollout
from layflat.sim.metrics import SETTLING_BAND
from research.calibration import steps
from research.calibration.effort import CLAIM_EFFORT, OWN_NOISE, ROUGH_EFFORT, EvaluationEffort
from research.calibration.evidence import Evidence

pytestmark = pytest.mark.compiled
GAIN = "joint.small.gains.far.pressure"
FEW = EvaluationEffort((3, 2), 2, 2, STEP_FINE)


@pytest.fixture
def evidence(monkeypatch: pytest.MonkeyPatch) -> Evidence:
    monkeypatch.setattr(steps, "RECORDED_TIME", 1.0)
    return Evidence(load_bench())


def test_every_machine_has_its_values_and_every_run_its_payload(evidence: Evidence) -> None:
    values = {GAIN: np.array([1e-5, 4e-5]), "joint.large.valve_size": np.array([1.0, 2.0])}
    compared, loaded = evidence.steps.compared(values, 7, FEW), evidence.steps.loaded(values, 7, FEW)
    assert compared.unbraked.shape[:2] == (2, steps.UNBRAKED_RUNS)
    assert compared.earlier.time.shape == (2, 1, 1)
    assert loaded.braked.time.shape == (2, 3, 2)
    assert loaded.earlier.time.shape == (2, 2, 2)
    assert loaded.earlier.time[:, 0, 1] == pytest.approx(compared.earlier.time[:, 0, 0])
    machine = changed(evidence.bench.axis_one, GAIN, 4e-5)
    payload = payload_for_inertia(machine, "small", INERTIA_PER_TORQUE * maximum_torque(machine, "small"))
    run = rollout(machine, scenario=replace(step_scenario(0.0, 7 + 1, payload), duration=STEP_TIME + 1.0))
    error = run["angle"].to_numpy()[round(STEP_TIME / machine.cycle) : -1, 0] - STEP / 2
    assert np.array_equal(compared.unbraked[1, 1], error)


def test_what_a_run_comes_to() -> None:
    time = 0.005 * np.arange(1000)
    error = np.where(time < 1.0, 1.0, 0.5 * SETTLING_BAND * np.sin(8.0 * np.pi * time))
    lost = np.where(time < 4.0, 0.0, np.nan)
    found = steps.evaluate_responses(np.stack([error, lost])[None], np.array([0.01, 0.02]), 0.005)
    assert found.time[0, :, 0] == pytest.approx([1.0, np.inf])
    assert found.swing[0, 0, 0] == pytest.approx(SETTLING_BAND, rel=5e-3)
    assert found.late[0, 0, 0] == pytest.approx(0.5 * SETTLING_BAND / np.sqrt(2.0), rel=1e-2)
    assert found.swing[0, 1, 0] == steps.DIVERGED_ERROR


def test_inertias_lie_elsewhere_with_every_seed_while_searching(evidence: Evidence) -> None:
    values = {GAIN: np.array([1e-5])}
    one, other = (evidence.steps.loaded(values, seed, ROUGH_EFFORT).braked.ratios for seed in (1, 2))
    assert one[[0, -1]] == pytest.approx([INERTIA_PER_TORQUE, steps.MAX_INERTIA_RATIO])
    assert np.all(np.diff(one) > 0.0)
    assert not np.isin(one[1:-1], other).any()


def test_the_earlier_actuators_pressure_gains_follow_its_torque(evidence: Evidence) -> None:
    scaled, plain = (value_at(one, GAIN) for one in (evidence.bench.earlier_scaled, evidence.bench.earlier))
    assert evidence.steps.scale == pytest.approx(scaled / plain)


def test_what_a_small_motion_keeps_is_what_a_sweep_shows(evidence: Evidence) -> None:
    earlier = evidence.bench.earlier
    curves = [evidence.bench.curve("small", earlier, share=share) for share in (SMALL_SWEEP_FRACTION, None)]
    kept = evidence.small_motion({GAIN: np.array([1e-5, 2e-5])})
    assert kept == pytest.approx(np.full(2, curves[0].height / curves[1].height), rel=2e-3)


def test_curves_and_spools_are_those_of_the_papers_experiments(evidence: Evidence) -> None:
    found, claims = evidence.hysteresis({GAIN: np.array([1e-5, 2e-5])}), OpenLoopExperiment(evidence.bench)
    assert found == pytest.approx(
        np.tile([one.hysteresis for one in (claims.earlier, claims.unbraked, claims.braked)], (2, 1)), rel=2e-3
    )
    sweeps = DitherExperiment(evidence.bench).sweeps
    usual = np.array([value_at(evidence.bench.arm, "valve.friction")])
    assert evidence.spool({"valve.friction": usual}) == pytest.approx([sweeps["fast"].gain / sweeps["normal"].gain])


def test_the_claims_own_noise_gives_their_runs(evidence: Evidence) -> None:
    on, usual = evidence.bench, {"valve.friction": np.array([value_at(evidence.bench.arm, "valve.friction")])}
    fine = replace(CLAIM_EFFORT, approaches=2, step=STEP_FINE)
    compared, claims = evidence.steps.compared(usual, OWN_NOISE, fine), AxisOneExperiment(on)
    own = claims.unbraked["angle"].to_numpy()[round(STEP_TIME / on.axis_one.cycle) :, 0] - STEP / 2
    assert np.array_equal(compared.unbraked[0, 0], own[: compared.unbraked.shape[2]])
    arm = TwoAxisExperiment(on)
    moves = evidence.arm_moves(usual, OWN_NOISE, fine)
    assert np.array_equal(moves[0, 0], arm.steps["angle"].to_numpy()[: moves.shape[2]])
    rests = evidence.comes_back(usual, OWN_NOISE, fine)
    assert rests[0] == pytest.approx(arm.rest_angles[:2], abs=5e-5)
    taken = ControllerExperiment(on).rules()[0].evaluate_claim(ControllerExperiment(on)).quantities[0].value
    assert evidence.taken_over(usual, fine) == pytest.approx([taken / 100.0])


def test_the_arm_moves_either_way(evidence: Evidence) -> None:
    angles = evidence.arm_moves({GAIN: np.array([2e-5])}, seed=1, effort=FEW)
    assert angles.shape[:2] == (1, 2)
    assert angles[0, :, 0] == pytest.approx(np.full((2, 2), -HALF_STEP), abs=1e-6)


def test_dither_shows_in_the_pressure_as_the_papers_experiment_finds_it(evidence: Evidence) -> None:
    arm = evidence.bench.arm
    _, pressure = ripple_amplitudes(arm, 1.0, 50.0)
    found = evidence.ripple(arm, {"valve.conductance": np.array([1.0, 0.5]) * value_at(arm, "valve.conductance")})
    assert found[0] == pytest.approx([pressure[joint] for joint in arm.joints], rel=0.05)
    assert found[1] == pytest.approx(0.5 * found[0], rel=0.2)
