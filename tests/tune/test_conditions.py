from math import radians

import numpy as np
import pytest

from layflat.errors import MachineError
from layflat.machine import changed, load
from layflat.sim.ensemble import ensemble
from layflat.sim.signals import expand_scenario
from layflat.tune.conditions import (
    ConditionRanges,
    check_joints_hold,
    configuration_sequences,
    nominal_configurations,
    sample_conditions,
)
from layflat.tune.laws import PAPER_TUNING, sample_robust_conditions

ARM = load("paper-arm")


def test_the_first_runs_are_nominal_and_the_rest_fill_the_spread() -> None:
    found = sample_conditions(ARM, 64, seed=2)
    supply, usual = found.vary["supply.pressure_gauge"], ARM.supply.pressure_gauge
    assert found.nominal == 8
    assert np.all(found.vary["arm.payload"][:8] == ARM.arm.payload)
    assert np.all(supply[:8] == usual)
    assert np.all(found.vary["scenario.drift.small"][:8] == 0.0)
    assert np.all(found.vary["scenario"][:8] == 0)
    assert found.vary["arm.payload"].min() == 0.0
    assert found.vary["arm.payload"].max() == pytest.approx(2.0)
    assert (supply.min(), supply.max()) == pytest.approx((0.9 * usual, 1.1 * usual))
    shares = found.vary["joint.large.hose.loss_fraction"] / ARM.joint["large"].hose.loss_fraction
    assert (shares.min(), shares.max()) == pytest.approx((0.7, 1.3))
    assert len(set(found.vary["seed"])) == 64


def test_payloads_follow_what_the_machine_carries() -> None:
    heavy = sample_conditions(changed(ARM, "arm.payload", 6.0), 32)
    assert heavy.vary["arm.payload"].max() == pytest.approx(8.0)


def test_no_spread_is_nominal_everywhere() -> None:
    found = sample_conditions(ARM, 4, ConditionRanges(supply=0.0, losses=0.0, drift=0.0))
    for path in ("supply.pressure_gauge", "joint.small.hose.loss_fraction", "scenario.drift.large"):
        assert np.ptp(found.vary[path]) == pytest.approx(0.0, abs=1e-9)


def test_runs_have_members_of_a_cloud_and_nominal_ones_the_machine_itself() -> None:
    size, overlap = np.array([1e-9, 2e-9, 3e-9]), np.array([0.01, 0.02, 0.03])
    found = sample_conditions(
        ARM, 64, ConditionRanges(members={"valve.conductance": size, "valve.overlap": overlap}), seed=1
    )
    assert ARM.valve is not None
    own = found.vary["valve.conductance"]
    assert np.all(own[: found.nominal] == ARM.valve.conductance)
    assert set(own[found.nominal :]) == set(size)
    assert found.vary["valve.overlap"][found.nominal :] == pytest.approx(own[found.nominal :] * 1e7)
    usual = sample_conditions(ARM, 64, seed=1).vary
    assert all(np.array_equal(found.vary[path], usual[path]) for path in usual)


def test_every_candidate_meets_the_same_runs() -> None:
    found = sample_conditions(ARM, 16)
    vary = found.repeat_varied(3)
    assert set(vary["scenario"]) == set(range(len(found.scenarios)))
    for values in vary.values():
        first, second, third = values.reshape(3, found.runs)
        assert np.array_equal(first, second)
        assert np.array_equal(first, third)


@pytest.mark.parametrize("name", ["paper-arm", "paper-small-joint"])
def test_moves_stay_in_the_stroke_and_are_measured_one_by_one(name: str) -> None:
    machine = load(name)
    found = sample_conditions(machine, 8)
    runs = ensemble(machine, found.scenarios, found.repeat_varied(1))
    assert runs.sizes["move"] == 2
    assert not np.isnan(runs.settling).any()
    first = np.unique(expand_scenario(found.scenarios[0], machine, 0.005).named("demand"), axis=0)
    assert np.abs(np.diff(first[:, 0])).max() == pytest.approx(radians(40.0))


@pytest.mark.parametrize("joints", range(1, 8))
def test_of_any_number_of_joints_one_after_the_other_moves_and_then_all_do(joints: int) -> None:
    sequences = [np.array(sequence) for sequence in configuration_sequences(joints)]
    assert len({len(sequence) for sequence in sequences}) == 1
    assert all(np.abs(sequence).max() <= 2 / 3 for sequence in sequences)
    moved = np.diff(nominal_configurations(joints), axis=0) != 0.0
    assert (moved.sum(axis=1) == 1).all()
    if joints > 1:
        assert (moved.sum(axis=0) == 1).all()
        assert any((np.diff(sequence, axis=0) != 0.0).all() for sequence in sequences)


def test_moves_that_an_arm_can_not_carry_its_payload_through_are_refused() -> None:
    arm = load("picking-arm")
    check_joints_hold(arm, sample_robust_conditions(arm, 16, None, 1))
    heavy = changed(arm, "arm.payload", 5.0)
    with pytest.raises(
        MachineError, match=r"picking-arm: joint 'wrist' can't hold 5\.\d+ kg at 4\.\d+ bar in the moves"
    ):
        check_joints_hold(heavy, sample_robust_conditions(heavy, 16, None, 1))
    with pytest.raises(MachineError, match=r"joint 'wrist' can't hold 6\.67 kg at 5\.\d+ bar"):
        check_joints_hold(heavy, PAPER_TUNING.conditions(heavy, 16, None, 1))
