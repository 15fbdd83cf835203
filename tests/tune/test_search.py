from dataclasses import replace

import numpy as np
import pytest

from layflat.machine import Machine, changed, load
from layflat.tune.conditions import Conditions, Spread, conditions
from layflat.tune.knobs import gain_knobs, neutral_gains, values_of
from layflat.tune.search import Found, judge, search

JOINT = load("paper-small-joint")
KNOBS = gain_knobs("small")


@pytest.fixture(scope="module")
def few() -> Conditions:
    found = conditions(JOINT, 2, Spread(window=1.0), seed=1)
    scenario = found.scenarios[0]
    return replace(found, scenarios=[scenario])


def test_knobs_read_and_write_what_stands_in_the_machine() -> None:
    values = values_of(JOINT, KNOBS)
    machine: Machine = JOINT
    for knob, value in zip(KNOBS, values, strict=True):
        machine = changed(machine, knob.paths[0], value * knob.si)
    assert np.allclose(values_of(machine, KNOBS), values, rtol=1e-12)
    assert KNOBS[0].text(0.12345) == "0.123 V/deg"


def test_neutral_gains_lie_within_their_ranges() -> None:
    for knob, value in zip([*KNOBS, *KNOBS], neutral_gains(2), strict=True):
        assert knob.low < value < knob.high


def test_candidates_are_judged_one_by_one(few: Conditions) -> None:
    both = np.array([neutral_gains(1), values_of(JOINT, KNOBS)])
    together = judge(JOINT, KNOBS, both, few)
    assert [float(judge(JOINT, KNOBS, one[None], few)[0]) for one in both] == together.tolist()
    assert together[1] < together[0]


def test_a_search_finds_better_gains_and_repeats_itself(few: Conditions) -> None:
    start = neutral_gains(1)
    before = float(judge(JOINT, KNOBS, start[None], few)[0])
    one, two = (search(JOINT, KNOBS, start, [(8, few)]) for _ in range(2))
    assert one.cost < 0.8 * before
    assert np.array_equal(one.values, two.values)
    assert float(judge(JOINT, KNOBS, one.values[None], few)[0]) == one.cost
    for knob, value in zip(KNOBS, one.values, strict=True):
        assert knob.low <= value <= knob.high


def test_a_search_stops_when_told_with_the_best_so_far(few: Conditions) -> None:
    seen: list[Found] = []

    def until_three(found: Found) -> bool:
        seen.append(found)
        return len(seen) < 3

    found = search(JOINT, KNOBS, neutral_gains(1), [(50, few)], progress=until_three)
    assert len(seen) == 3
    assert found == seen[-1]
    assert [f.cost for f in seen] == sorted((f.cost for f in seen), reverse=True)


def test_a_later_stage_judges_the_best_anew(few: Conditions) -> None:
    nominal = replace(few, vary={path: values[:1] for path, values in few.vary.items()})
    found = search(JOINT, KNOBS, neutral_gains(1), [(3, nominal), (3, few)])
    assert float(judge(JOINT, KNOBS, found.values[None], few)[0]) == found.cost
