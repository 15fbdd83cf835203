from math import radians

import numpy as np
import pytest

from layflat.machine import load
from layflat.sim.ensemble import ensemble
from layflat.sim.scenario import shapes
from layflat.tune.conditions import Spread, conditions

ARM = load("paper-arm")


def test_the_first_condition_is_nominal_and_the_rest_fill_the_spread() -> None:
    found = conditions(ARM, 32, seed=2)
    supply, usual = found.vary["supply.pressure_gauge"], ARM.supply.pressure_gauge
    assert found.vary["arm.payload"][0] == ARM.arm.payload
    assert supply[0] == usual
    assert found.vary["scenario.drift.small"][0] == 0.0
    assert found.vary["arm.payload"].min() == 0.0
    assert found.vary["arm.payload"].max() == 2.0
    assert (supply.min(), supply.max()) == pytest.approx((0.9 * usual, 1.1 * usual))
    shares = found.vary["joint.large.hose.loss_share"] / ARM.joint["large"].hose.loss_share
    assert (shares.min(), shares.max()) == pytest.approx((0.7, 1.3))
    assert len(set(found.vary["seed"])) == 32


def test_no_spread_is_nominal_everywhere() -> None:
    still = Spread(payload=ARM.arm.payload, supply=0.0, losses=0.0, drift=0.0)
    found = conditions(ARM, 4, still)
    for path in ("supply.pressure_gauge", "joint.small.hose.loss_share", "scenario.drift.large"):
        assert np.ptp(found.vary[path]) == pytest.approx(0.0, abs=1e-9)


def test_every_condition_meets_every_sequence_of_moves() -> None:
    found = conditions(ARM, 4)
    vary = found.of(3)
    runs = 4 * len(found.scenarios)
    assert found.runs == runs
    pairs = list(zip(vary["seed"], vary["scenario"], strict=True))
    assert len(set(pairs)) == runs
    assert pairs[:runs] == pairs[runs : 2 * runs] == pairs[2 * runs :]


@pytest.mark.parametrize("name", ["paper-arm", "paper-small-joint"])
def test_moves_stay_in_the_stroke_and_are_measured_one_by_one(name: str) -> None:
    machine = load(name)
    found = conditions(machine, 2)
    runs = ensemble(machine, found.scenarios, found.of(1))
    assert runs.sizes["move"] == 2
    assert not np.isnan(runs.settling).any()
    first = np.unique(shapes(found.scenarios[0], machine, 0.005).demand, axis=0)
    assert np.abs(np.diff(first[:, 0])).max() == pytest.approx(radians(40.0))
