"""Learning from repeats: what the filter passes, what is learnt from, and what a demand may be."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from layflat.arrays import Array
from layflat.errors import InputError
from layflat.machine import changed, load
from layflat.motion.learning import LearntCorrections, RepeatedMotion, begin_learning, landing_time
from layflat.motion.learning.corrections import CorrectionFilter, CorrectionSplines, choose_filter
from layflat.motion.limits import joint_capabilities
from layflat.motion.optimal import plan_time_optimal
from layflat.motion.path import JointLine, half_strokes

ARM = load("paper-arm-tracking")
MOTION = plan_time_optimal(ARM, JointLine(np.radians([-20.0, 10.0]), np.radians([20.0, -20.0]))).rows(ARM.cycle)
HOW = CorrectionFilter(smoothing=0.025, lead=0.01, lead_in=0.05, tail=0.2)


def late(learnt: LearntCorrections, share: float = 0.05, cycles: int = 2) -> Array:
    """Angles of an arm that falls behind what it is asked for, by a share of its speed, and some cycles."""
    asked = learnt.demand()
    behind = asked.angles - 0.05 * share * asked.velocities
    return np.vstack([np.repeat(behind[:1], cycles, axis=0), behind[: len(behind) - cycles]])


def test_a_demand_of_any_length_has_corrections() -> None:
    for cycles in range(40, 400):
        errors = np.ones((cycles, 2))
        assert np.isfinite(CorrectionSplines(0.005, cycles, HOW).filter_errors(errors)).all()


def test_slow_errors_pass_ahead_of_time_and_fast_ones_do_not() -> None:
    """With 1 / (1 + (T_s w)^4), T_l earlier, far from the ends."""
    made = CorrectionSplines(0.005, 401, HOW)
    time = 0.005 * np.arange(401)
    for frequency in (1.0, 4.0, 8.0, 16.0):
        w = 2.0 * np.pi * frequency
        passed = made.states(made.filter_errors(np.sin(w * time)[:, None])).angles[100:300, 0]
        share = 1.0 / (1.0 + (HOW.smoothing * w) ** 4)
        assert_allclose(passed, share * np.sin(w * (time + HOW.lead))[100:300], atol=0.03)


def test_a_correction_has_its_rates_and_ends_at_rest() -> None:
    made = CorrectionSplines(0.005, 101, HOW)
    of = made.states(np.random.default_rng(0).normal(size=(made.count, 2)))
    for values in of:
        assert_allclose(values[[0, -1]], 0.0, atol=1e-9)
    for value, rate in ((of.angles, of.velocities), (of.velocities, of.accelerations)):
        moved = np.cumsum(0.5 * (rate[1:] + rate[:-1]) * 0.005, axis=0)
        assert_allclose(moved, value[1:] - value[0], atol=0.05 * np.abs(value).max())


def test_the_filter_follows_from_the_bandwidth_and_the_cycle() -> None:
    assert choose_filter(ARM) == pytest.approx(HOW)
    slower = choose_filter(changed(ARM, "controller.bandwidth", "15 Hz"))
    assert slower == pytest.approx([0.05, 0.02, 0.1, 0.4])
    assert choose_filter(load("paper-arm-fast-tuned")) == pytest.approx(HOW)


def test_an_arm_that_is_late_is_asked_earlier() -> None:
    learnt = begin_learning(ARM, MOTION)
    assert_allclose(learnt.demand().angles[learnt.lead_in_cycles :][: len(MOTION.angles)], MOTION.angles)
    for _ in range(6):
        learnt = learnt.learn_from(late(learnt))
    errors = [repeat.rms for repeat in learnt.history]
    assert min(errors) < errors[0] / 4.0
    assert learnt.history[-1].arrival <= learnt.history[0].arrival


def test_a_repeat_that_is_worse_is_not_learnt_from() -> None:
    first = begin_learning(ARM, MOTION)
    good = first.learn_from(late(first))
    bad = good.learn_from(late(good, cycles=9))
    assert not bad.history[-1].kept
    assert_allclose(bad.best, good.best)
    assert_allclose(bad.sent - bad.best, 0.7 * (good.sent - good.best))
    assert_allclose(bad.best_demand().angles, first.demand().angles)


def test_the_same_repeats_teach_the_same() -> None:
    learnt = [begin_learning(ARM, MOTION), begin_learning(ARM, MOTION)]
    for _ in range(2):
        learnt = [one.learn_from(late(one)) for one in learnt]
    assert np.array_equal(learnt[0].sent, learnt[1].sent)


def test_demands_stay_inside_strokes_and_speeds() -> None:
    """However large the errors are."""
    edge = np.radians([-58.0, 10.0]), np.radians([58.0, -20.0])
    motion = plan_time_optimal(ARM, JointLine(*edge), reserve=0.05).rows(ARM.cycle)
    learnt = begin_learning(ARM, motion)
    rng = np.random.default_rng(3)
    for size in (0.02, 0.2, 2.0):
        rested = learnt.uncorrected.angles
        noise = np.cumsum(rng.normal(size=rested.shape), axis=0)
        asked = replace(learnt, history=()).learn_from(rested + size * noise / np.abs(noise).max()).demand()
        assert np.all(np.abs(asked.angles) <= half_strokes(ARM) + 1e-8)
        assert np.all(np.abs(asked.velocities) <= joint_capabilities(ARM).speed + 1e-8)


@pytest.mark.parametrize(
    ("measured", "expected"),
    [
        (np.zeros((3, 2)), r"shape \(3, 2\) do not fit; give those of the whole demand"),
        (np.zeros((900, 1)), "do not fit"),
        (np.full((900, 2), np.nan), "cycles lack measured angles; give a run without gaps"),
    ],
)
def test_runs_that_do_not_fit_are_refused(measured: Array, expected: str) -> None:
    with pytest.raises(InputError, match=expected):
        begin_learning(ARM, MOTION).learn_from(measured)


def test_motions_that_do_not_fit_are_refused() -> None:
    with pytest.raises(InputError, match=r"shape \(9, 1\) is not one of paper-arm-tracking; give two rows"):
        begin_learning(ARM, (np.zeros((9, 1)), None, None))
    with pytest.raises(InputError, match="has no controller"):
        begin_learning(load("rig-kevlar"), (np.zeros((9, 1)), None, None))


def test_landing_counts_from_the_end_of_the_motion() -> None:
    angles = np.repeat(np.linspace(0.0, 0.3, 31)[:, None], 2, axis=1)
    wanted, zero = RepeatedMotion(0.005, angles, angles * 0.0, angles * 0.0), np.repeat(angles[-1:], 20, axis=0)
    assert landing_time(ARM, wanted, np.vstack([angles, zero])) == pytest.approx(0.0, abs=0.006)
    assert landing_time(ARM, wanted, np.vstack([angles[:1], angles, zero])) == pytest.approx(0.005, abs=0.006)
    assert landing_time(ARM, wanted, np.vstack([angles, 0.5 * zero])) == np.inf
    assert landing_time(ARM, wanted, zero) == pytest.approx(-0.15)
