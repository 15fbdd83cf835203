"""Repeats in simulation: what they learn on plants that differ from what the controller believes."""

from __future__ import annotations

import numpy as np
import pytest

from layflat.machine import changed, load
from layflat.motion.learning import begin_learning
from layflat.motion.optimal import plan_time_optimal
from layflat.motion.path import JointSpline
from layflat.sim.repeats import learnt_error_ratio, simulated_repeats

ARM = load("paper-arm-tracking")
WAY = JointSpline(ARM, [np.radians(at) for at in ([-30.0, 0.0], [0.0, 30.0], [20.0, 0.0], [30.0, -20.0])])
MOTION = plan_time_optimal(ARM, WAY)


def test_a_quarter_of_the_error_is_left_after_five_repeats() -> None:
    """On plants with more and less friction, air and losses."""
    ratios = []
    for brake, losses, air, supply in ((1.25, 0.75, 0.85, 0.9), (0.8, 1.25, 1.0, 1.1), (1.2, 1.2, 0.9, 1.0)):
        plant = changed(ARM, "supply.pressure_gauge", supply * ARM.supply.pressure_gauge)
        assert ARM.valve is not None
        plant = changed(plant, "valve.conductance", air * ARM.valve.conductance)
        for name in ARM.joints:
            plant = changed(plant, f"joint.{name}.brake.torque", brake * ARM.joint[name].brake.torque)
            share = ARM.joint[name].hose.loss_fraction
            plant = changed(plant, f"joint.{name}.hose.loss_fraction", losses * share)
        ratios.append(learnt_error_ratio(ARM, plant, MOTION, seeds=(1,)))
    assert np.median(ratios) <= 0.25
    assert max(ratios) <= 0.4


def test_noise_differs_between_repeats_and_seeds_and_repeats_itself() -> None:
    runs = [list(simulated_repeats(begin_learning(ARM, MOTION.rows(ARM.cycle)), 2, seed=seed)) for seed in (0, 0, 1)]
    assert np.array_equal(runs[0][1].angles, runs[1][1].angles)
    assert runs[0][1].learnt.history == runs[1][1].learnt.history
    assert not np.array_equal(runs[0][0].angles, runs[2][0].angles)


def test_the_first_run_is_over_itself_one() -> None:
    assert learnt_error_ratio(ARM, ARM, MOTION, repeats=0) == pytest.approx(1.0, abs=0.3)
