"""The cloud is the ensemble's truth: its first run is the rollout, and its bands hold what they say."""

import numpy as np
import pytest

from layflat.errors import InputError, MachineError
from layflat.machine import load
from layflat.pages.studio.cloud import (
    CYCLES_PER_RECORD,
    QUANTILE_LEVELS,
    JointStep,
    OvertakenError,
    StepCloud,
    Tolerances,
    simulate_cloud,
    step_scenario,
    vary_parameters,
)
from layflat.pages.studio.design import Design
from layflat.sim import rollout

pytestmark = pytest.mark.compiled
STEP = JointStep("large", duration=0.8)
RUNS = 32


@pytest.fixture(scope="module")
def found() -> StepCloud:
    return simulate_cloud(load("paper-arm"), STEP, runs=RUNS)


def test_the_first_run_is_the_rollout(found: StepCloud) -> None:
    machine = load("paper-arm")
    run = rollout(machine, scenario=step_scenario(machine, STEP)).sel(joint="large")
    for name in ("angle", "pressure_a", "pressure_b"):
        nominal = run[name].to_numpy()[:-1:CYCLES_PER_RECORD]
        assert np.array_equal(getattr(found, name)[0], nominal)


def test_bands_hold_as_many_runs_as_they_say(found: StepCloud) -> None:
    moving = np.ptp(found.angle, axis=0) > 1e-3
    angle = found.angle[:, moving]
    levels = found.levels["angle"][:, moving]
    below = (angle[:, None, :] <= levels[None]).mean(axis=0)
    assert moving.sum() > 25
    assert np.abs(below - np.array(QUANTILE_LEVELS)[:, None]).max() <= 1.5 / RUNS
    assert levels[2] == pytest.approx(np.median(angle, axis=0))


def test_settling_is_told_by_quantiles(found: StepCloud) -> None:
    settled = np.isfinite(found.settling)
    assert found.late == int((~settled).sum())
    assert found.settled(0.5) <= found.settled(0.95)
    assert np.mean(found.settling <= found.settled(0.5)) >= 0.5
    assert found.summary.startswith("Settled within 0.3 deg: 50 % in ")


def test_tolerances_fill_their_ranges_about_a_nominal_run() -> None:
    machine = load("paper-arm")
    vary = vary_parameters(machine, Tolerances(supply=0.2, payload=1.5), 64)
    pressure = vary["supply.pressure_gauge"] / machine.supply.pressure_gauge
    assert pressure[0] == 1.0
    assert vary["arm.payload"][0] == machine.arm.payload
    assert 0.8 <= pressure.min() < 0.85
    assert 1.15 < pressure.max() <= 1.2
    assert 0.0 <= vary["arm.payload"].min() < 0.1
    assert vary["arm.payload"].max() > 1.4 * machine.arm.payload


def test_without_tolerances_all_runs_differ_by_noise_alone() -> None:
    one = simulate_cloud(load("paper-arm"), STEP, Tolerances(0.0, 0.0, 0.0, 0.0, 1e-9), runs=2)
    assert np.allclose(one.pressure_a[0, :5], one.pressure_a[1, :5], rtol=0.02)


def test_a_cloud_that_is_overtaken_ends_early() -> None:
    with pytest.raises(OvertakenError):
        simulate_cloud(load("paper-arm"), STEP, runs=RUNS, overtaken=lambda: True)


def test_what_can_not_be_simulated_is_said(design: Design) -> None:
    with pytest.raises(MachineError, match="has no controller"):
        simulate_cloud(load("rig-kevlar"), JointStep("small"), runs=2)
    with pytest.raises(InputError, match="outside the working stroke"):
        simulate_cloud(design.machine, JointStep("large", size=3.0), runs=2)
    design.edit("controller.cycle", "0.1 ms")
    with pytest.raises(InputError, match="control cycles, more than 4000"):
        simulate_cloud(design.machine, STEP, runs=2)
