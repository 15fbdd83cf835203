import numpy as np
import pytest

from layflat.machine import Machine, changed, load
from layflat.tune import search as s
from layflat.tune.conditions import Conditions, sample_conditions
from layflat.tune.knobs import (
    SearchPart,
    SearchStage,
    current_values,
    fractions_to_values,
    neutral_values,
    round_values,
    values_to_fractions,
)
from layflat.tune.laws import PAPER_TUNING, PHASE_GAINS, joint_gain_knobs
from layflat.tune.search import SearchResult, evaluate_costs, panel_conditions, search_knob_values

JOINT = load("paper-small-joint")
KNOBS = joint_gain_knobs("small")
NEUTRAL = neutral_values(KNOBS)
ALL = SearchPart("all", tuple(range(len(KNOBS))), 12, (SearchStage(6, 8),))


def meet(runs: int, seed: int) -> Conditions:
    return sample_conditions(JOINT, runs, seed=seed)


@pytest.fixture(autouse=True)
def _small_panel(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(s, "PANEL_RUNS", 16)


def test_knobs_read_and_write_what_stands_in_the_machine() -> None:
    values = current_values(JOINT, KNOBS)
    machine: Machine = JOINT
    for knob, value in zip(KNOBS, values, strict=True):
        machine = changed(machine, knob.paths[0], value * knob.si)
    assert np.allclose(current_values(machine, KNOBS), values, rtol=1e-12)
    assert KNOBS[0].text(0.12345) == "0.123 V/deg"


def test_neutral_gains_lie_within_their_ranges() -> None:
    for knob, value in zip(KNOBS, NEUTRAL, strict=True):
        assert knob.low < value < knob.high


def test_shares_of_a_range_count_factors_and_stay_inside() -> None:
    assert fractions_to_values(KNOBS, values_to_fractions(KNOBS, NEUTRAL)) == pytest.approx(NEUTRAL)
    low, high = (fractions_to_values(KNOBS, np.full(len(KNOBS), share)) for share in (0.0, 1.0))
    assert fractions_to_values(KNOBS, np.full(len(KNOBS), 0.5)) == pytest.approx(np.sqrt(low * high))
    assert values_to_fractions(KNOBS, np.zeros(len(KNOBS))).tolist() == [0.0] * len(KNOBS)


def test_candidates_are_judged_one_by_one() -> None:
    both, by = np.array([NEUTRAL, current_values(JOINT, KNOBS)]), sample_conditions(JOINT, 8)
    together = evaluate_costs(JOINT, KNOBS, both, by)
    assert [float(evaluate_costs(JOINT, KNOBS, one[None], by)[0]) for one in both] == together.tolist()
    assert together[1] < together[0]


def test_a_search_finds_better_gains_and_repeats_itself() -> None:
    seen: list[SearchResult] = []
    one = search_knob_values(JOINT, KNOBS, NEUTRAL, [ALL], meet, progress=lambda found, *_: seen.append(found))
    two = search_knob_values(JOINT, KNOBS, NEUTRAL, [ALL], meet)
    assert one.cost < 0.9 * seen[0].cost
    assert np.array_equal(one.values, two.values)
    assert np.array_equal(one.values, round_values(one.values))
    assert float(evaluate_costs(JOINT, KNOBS, one.values[None], panel_conditions(meet))[0]) == one.cost
    assert [f.cost for f in seen] == sorted((f.cost for f in seen), reverse=True)
    assert len(seen) == 1 + 6
    for knob, value in zip(KNOBS, one.values, strict=True):
        assert knob.low <= value <= knob.high


def test_each_phase_turns_its_own_gains_of_one_joint_only() -> None:
    arm = load("paper-arm")
    knobs = [*joint_gain_knobs("large"), *joint_gain_knobs("small")]
    wanted = PAPER_TUNING.parts(arm, "phases", 36)
    order = [f"round 1, {joint} joint, {phase}" for joint in ("large", "small") for phase in ("far", "near", "close")]
    assert [part.name for part in wanted] == order
    for part, (joint, phase) in zip(wanted, ((j, p) for j in arm.joints for p in PHASE_GAINS), strict=True):
        names = {knobs[place].paths[0].removeprefix(f"joint.{joint}.gains.") for place in part.knobs}
        belongs = {f"{phase}.error", f"{phase}.pressure", f"{phase}_below.error", f"{phase}_below.speed", "integral"}
        assert names <= belongs
    assert sorted(place for part in wanted for place in part.knobs) == list(range(len(knobs)))

    twice = PAPER_TUNING.parts(arm, "phases", 40)
    assert twice[:6] == wanted
    assert (twice[6].knobs, twice[6].stages[0].generations) == (wanted[0].knobs, 4)

    part = SearchPart("small joint, near", wanted[4].knobs, 8, (SearchStage(2, 8),))
    before = current_values(arm, knobs)
    found = search_knob_values(arm, knobs, before, [part], lambda runs, seed: sample_conditions(arm, runs, seed=seed))
    turned = set(np.flatnonzero(found.values != round_values(before)))
    assert turned <= set(part.knobs)


@pytest.mark.parametrize("wanted", [1, 2, 7, 50, 110, 333])
def test_generations_are_what_was_asked_for(wanted: int) -> None:
    arm = load("paper-arm")
    (part,) = PAPER_TUNING.parts(arm, "global", wanted)
    assert sum(stage.generations for stage in part.stages) == wanted
    assert (
        sum(stage.generations for part in PAPER_TUNING.parts(arm, "phases", wanted) for stage in part.stages) == wanted
    )
