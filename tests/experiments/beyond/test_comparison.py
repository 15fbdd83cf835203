"""The comparison of controllers, small: that its parts find what they are for, and what is written of it."""

import json
from pathlib import Path

import numpy as np
import pytest

from layflat.errors import MachineError
from layflat.experiments.beyond import settling
from layflat.experiments.beyond.comparison import TRACKING_LABEL, Comparison, Effort, prepare_comparison
from layflat.experiments.beyond.moves import CONFIGURATION_COUNT, first_moves, measure_belt_following, move_sequences
from layflat.experiments.beyond.report import result_numbers, write_numbers, write_page
from layflat.machine import load
from layflat.sim.signals import expand_scenario

pytestmark = pytest.mark.compiled

SMALL = Effort(runs=32, seeds=1, rest_time=5.0, bounds=1, plants=2)


@pytest.fixture(scope="module")
def found() -> Comparison:
    made = prepare_comparison("paper-arm-fast", SMALL)
    for what, work in made.stages():
        if what not in {"stiffness", "optimum", "gravity"}:
            work()
    return made


def test_every_law_meets_the_same_moves_inside_the_strokes() -> None:
    arm = load("paper-arm-fast")
    assert len(first_moves(arm)) == CONFIGURATION_COUNT
    for (before, after), scenario in zip(first_moves(arm), move_sequences(arm, 3), strict=True):
        moved = np.degrees(np.abs(after - before))
        assert set(moved.round(6)) <= {0.0, 40.0}
        rows = expand_scenario(scenario, arm, arm.cycle).named("demand")
        assert np.abs(rows).max() <= np.radians(55.0) + 1e-9


def test_the_tracking_law_is_far_ahead_and_each_part_counts(found: Comparison) -> None:
    told = result_numbers(found)
    assert told["nominal_settling_95_s"] < 0.5  # type: ignore[operator]
    assert told["robust_settling_95_s"] < 0.65  # type: ignore[operator]
    for law in ("the paper's", "the paper's, tuned"):
        rival, own = (
            found.settling_of(law, settling.NOMINAL_CASE),
            found.settling_of(TRACKING_LABEL, settling.NOMINAL_CASE),
        )
        assert rival is not None
        assert own is not None
        assert own.late < 0.5 * rival.late
    whole = found.settling_of(TRACKING_LABEL, settling.ROBUST_CASE)
    assert whole is not None
    friction = next(one for one in found.ablations if "friction" in one.law)
    assert friction.late > 1.3 * whole.late


def test_belts_are_followed(found: Comparison) -> None:
    told = result_numbers(found)
    assert told["conveyor_0p3_rms_mm"] < 1.0  # type: ignore[operator]
    assert told["conveyor_0p3_max_mm"] < 3.0  # type: ignore[operator]
    papers = measure_belt_following("the paper's", load("paper-arm-fast"), 0.3, 1)
    assert papers.rms > 20e-3


def test_what_is_written_is_what_was_found(found: Comparison, tmp_path: Path) -> None:
    told = json.loads(write_numbers(found, tmp_path / "beyond.json").read_text())
    assert told == result_numbers(found)
    assert told["stiffness_spread_percent"] is None
    assert 0.0 < told["learnt_error_ratio"] < 0.6
    html = write_page(found, tmp_path / "beyond.html").read_text()
    assert f"{told['nominal_settling_95_s']:.4g}" in html
    assert html.count("<svg") == 4


def test_arms_in_space_are_compared_in_what_they_can_do() -> None:
    made = prepare_comparison("picking-arm", SMALL)
    assert [what for what, _ in made.stages()] == ["steps, tracking", "parts left out", "rest", "repeats"]
    assert settling.max_payload(made.machine) == pytest.approx(1.0)
    assert settling.with_unknown_payload(made.machine).arm.payload == pytest.approx(0.5)
    ways = {tuple(np.sign(after - before)) for before, after in first_moves(made.machine)}
    assert {sum(map(abs, way)) for way in ways} == {1.0, 4.0}
    assert len(ways) > 10


def test_a_machine_that_the_law_can_not_have_is_refused() -> None:
    with pytest.raises(MachineError, match="can't model its joints or valves; give a machine with spool valves"):
        prepare_comparison("paper-arm-switching")
