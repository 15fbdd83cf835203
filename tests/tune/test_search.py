import numpy as np
import pytest

from layflat.machine import Machine, changed, load
from layflat.tune import search as s
from layflat.tune.conditions import Conditions, conditions
from layflat.tune.knobs import Part, Stage, from_shares, neutral_values, rounded, to_shares, values_of
from layflat.tune.papers_law import PHASES, TUNABLE, gain_knobs
from layflat.tune.search import Found, judge, panel, search

JOINT = load("paper-small-joint")
KNOBS = gain_knobs("small")
NEUTRAL = neutral_values(KNOBS)
ALL = Part("all", tuple(range(len(KNOBS))), 12, (Stage(6, 8),))


def meet(runs: int, seed: int) -> Conditions:
    return conditions(JOINT, runs, seed=seed)


@pytest.fixture(autouse=True)
def _small_panel(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(s, "PANEL", 16)


def test_knobs_read_and_write_what_stands_in_the_machine() -> None:
    values = values_of(JOINT, KNOBS)
    machine: Machine = JOINT
    for knob, value in zip(KNOBS, values, strict=True):
        machine = changed(machine, knob.paths[0], value * knob.si)
    assert np.allclose(values_of(machine, KNOBS), values, rtol=1e-12)
    assert KNOBS[0].text(0.12345) == "0.123 V/deg"


def test_neutral_gains_lie_within_their_ranges() -> None:
    for knob, value in zip(KNOBS, NEUTRAL, strict=True):
        assert knob.low < value < knob.high


def test_shares_of_a_range_count_factors_and_stay_inside() -> None:
    assert from_shares(KNOBS, to_shares(KNOBS, NEUTRAL)) == pytest.approx(NEUTRAL)
    low, high = (from_shares(KNOBS, np.full(len(KNOBS), share)) for share in (0.0, 1.0))
    assert from_shares(KNOBS, np.full(len(KNOBS), 0.5)) == pytest.approx(np.sqrt(low * high))
    assert to_shares(KNOBS, np.zeros(len(KNOBS))).tolist() == [0.0] * len(KNOBS)


def test_candidates_are_judged_one_by_one() -> None:
    both, by = np.array([NEUTRAL, values_of(JOINT, KNOBS)]), conditions(JOINT, 8)
    together = judge(JOINT, KNOBS, both, by)
    assert [float(judge(JOINT, KNOBS, one[None], by)[0]) for one in both] == together.tolist()
    assert together[1] < together[0]


def test_a_search_finds_better_gains_and_repeats_itself() -> None:
    seen: list[Found] = []
    one = search(JOINT, KNOBS, NEUTRAL, [ALL], meet, progress=lambda found, *_: seen.append(found))
    two = search(JOINT, KNOBS, NEUTRAL, [ALL], meet)
    assert one.cost < 0.9 * seen[0].cost
    assert np.array_equal(one.values, two.values)
    assert np.array_equal(one.values, rounded(one.values))
    assert float(judge(JOINT, KNOBS, one.values[None], panel(meet))[0]) == one.cost
    assert [f.cost for f in seen] == sorted((f.cost for f in seen), reverse=True)
    assert len(seen) == 1 + 6
    for knob, value in zip(KNOBS, one.values, strict=True):
        assert knob.low <= value <= knob.high


def test_each_phase_turns_its_own_gains_of_one_joint_only() -> None:
    arm = load("paper-arm")
    knobs = [*gain_knobs("large"), *gain_knobs("small")]
    wanted = TUNABLE.parts(arm, "phases", 36)
    order = [f"round 1, {joint} joint, {phase}" for joint in ("large", "small") for phase in ("far", "near", "close")]
    assert [part.name for part in wanted] == order
    for part, (joint, phase) in zip(wanted, ((j, p) for j in arm.joints for p in PHASES), strict=True):
        names = {knobs[place].paths[0].removeprefix(f"joint.{joint}.gains.") for place in part.knobs}
        belongs = {f"{phase}.error", f"{phase}.pressure", f"{phase}_below.error", f"{phase}_below.speed", "integral"}
        assert names <= belongs
    assert sorted(place for part in wanted for place in part.knobs) == list(range(len(knobs)))

    twice = TUNABLE.parts(arm, "phases", 40)
    assert twice[:6] == wanted
    assert (twice[6].knobs, twice[6].stages[0].generations) == (wanted[0].knobs, 4)

    part = Part("small joint, near", wanted[4].knobs, 8, (Stage(2, 8),))
    before = values_of(arm, knobs)
    found = search(arm, knobs, before, [part], lambda runs, seed: conditions(arm, runs, seed=seed))
    turned = set(np.flatnonzero(found.values != rounded(before)))
    assert turned <= set(part.knobs)


@pytest.mark.parametrize("wanted", [1, 2, 7, 50, 110, 333])
def test_generations_are_what_was_asked_for(wanted: int) -> None:
    arm = load("paper-arm")
    (part,) = TUNABLE.parts(arm, "global", wanted)
    assert sum(stage.generations for stage in part.stages) == wanted
    assert sum(stage.generations for part in TUNABLE.parts(arm, "phases", wanted) for stage in part.stages) == wanted
