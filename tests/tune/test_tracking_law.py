"""Settings of the tracking law: the plants that they are judged by, and a search from beginning to end."""

from pathlib import Path

import numpy as np
import pytest

from layflat.errors import InputError
from layflat.machine import changed, load
from layflat.sim.ensemble import ensemble
from layflat.tune import begin
from layflat.tune import robust as v
from layflat.tune import search as s
from layflat.tune.conditions import candidate_costs
from layflat.tune.knobs import values_of
from layflat.tune.page import write_page
from layflat.tune.robust import validate
from layflat.tune.tracking_law import conditions, knobs_of

pytestmark = pytest.mark.compiled

ARM = load("paper-arm-tracking")


@pytest.fixture(autouse=True)
def _small(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(s, "PANEL", 16)
    monkeypatch.setattr(v, "FRESH", 16)


def test_the_first_runs_are_nominal_and_the_rest_are_plants_that_differ() -> None:
    by = conditions(ARM, 32, None, 3)
    brakes = by.vary["joint.small.brake.torque"] / ARM.joint["small"].brake.torque
    assert np.all(brakes[: by.nominal] == 1.0)
    assert np.all(by.vary["joint.small.friction.static_ratio"][: by.nominal] == 1.0)
    assert np.all(np.abs(brakes[by.nominal :] - 1.0) > 0.0)
    assert {plant.joint["small"].losses.kind for plant in by.plants} == {"elasto-slip", "bouc-wen"}
    assert "scenario.payload" not in by.vary
    unsure = conditions(changed(ARM, "controller.payload_spread", "0.5 kg"), 32, None, 3)
    assert np.all(unsure.vary["scenario.payload"][: unsure.nominal] == ARM.arm.payload)
    assert np.ptp(unsure.vary["scenario.payload"]) > 1.0


def test_runs_are_those_of_their_own_plants_in_order() -> None:
    by = conditions(ARM, 8, None, 1)
    vary = by.of(2) | {"controller.reserve": np.repeat([0.1, 0.4], 8)}
    found = by.simulate(ARM, vary)
    for run in (0, 3, 7, 12, 15):
        own = {path: values[run : run + 1] for path, values in vary.items()}
        alone = ensemble(by.plants[by.which[run % 8]], by.scenarios, own, controller=ARM)
        assert np.array_equal(found.tip_settling[run], alone.tip_settling[0])
    costs = candidate_costs(found, by, 2)
    assert costs.shape == (2,)
    assert costs[0] != costs[1]


def test_a_law_that_is_set_badly_is_tuned_better(tmp_path: Path) -> None:
    bad = tmp_path / "bad.toml"
    bad.write_text(
        'extends = "paper-arm-tracking"\nname = "bad"\n[controller]\nbandwidth = "8 1/s"\nvalve_share = 0.2\n',
        encoding="utf-8",
    )
    tuning = begin(str(bad), tmp_path / "out", start="current", generations=6)
    tuning.seek()
    tuned = tuning.keep()
    assert not tuning.kept
    before, after = validate(tuning.base, tuning.meet), validate(tuned, tuning.meet)
    assert after.cost < 0.9 * before.cost
    assert np.allclose(values_of(tuned, tuning.knobs), tuning.history[-1].values)
    assert tuned.provenance["controller.reserve"].source == "calibrated"
    html = write_page(tuning, tuned, before, after, tmp_path / "tuning.html").read_text(encoding="utf-8")
    assert "<h1>Settings of bad</h1>" in html
    assert "settling within 2 mm" in html
    assert "another law of losses" in html


def test_no_bandwidth_is_tried_that_the_cycle_does_not_allow() -> None:
    slow = changed(ARM, "controller.cycle", "20 ms")
    knob = knobs_of(slow)[0]
    assert knob.low < knob.neutral == knob.high == pytest.approx(7.5)


@pytest.mark.parametrize(
    ("options", "expected"),
    [
        ({"method": "phases"}, "--method: unknown method 'phases' for settings; give global"),
        ({"over": "cloud"}, "--over: the tracking law is told which machine it has; tune for each member by itself"),
    ],
)
def test_what_only_the_papers_law_has_is_refused(options: dict[str, str], expected: str, tmp_path: Path) -> None:
    with pytest.raises(InputError) as error:
        begin("paper-arm-tracking", tmp_path / "out", **options)  # type: ignore[arg-type]
    assert str(error.value) == expected
