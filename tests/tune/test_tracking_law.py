"""Settings of the tracking law: the plants that they are judged by, and a search from beginning to end."""

from pathlib import Path

import numpy as np
import pytest

from layflat.errors import InputError
from layflat.machine import changed, load
from layflat.sim.ensemble import ensemble
from layflat.tune import begin_tuning, finish_tuning
from layflat.tune import robust as v
from layflat.tune import search as s
from layflat.tune.conditions import candidate_costs
from layflat.tune.knobs import current_values
from layflat.tune.laws import sample_robust_conditions, setting_knobs
from layflat.tune.page import write_page

pytestmark = pytest.mark.compiled

ARM = load("paper-arm-tracking")
ONE = """
extends = "paper-small-joint-fast"
name = "{name}"
[controller]
kind = "tracking"
cycle = "5 ms"
{settings}
"""
"""A single joint, whose plants are compiled in a third of the time; settings of the law are those of all joints."""


def one_joint(folder: Path, name: str = "one", settings: str = "") -> Path:
    path = folder / f"{name}.toml"
    path.write_text(ONE.format(name=name, settings=settings), encoding="utf-8")
    return path


@pytest.fixture(autouse=True)
def _small(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(s, "PANEL_RUNS", 16)
    monkeypatch.setattr(v, "VALIDATION_RUNS", 16)


def test_the_first_runs_are_nominal_and_the_rest_are_plants_that_differ() -> None:
    by = sample_robust_conditions(ARM, 32, None, 3)
    brakes = by.vary["joint.small.brake.torque"] / ARM.joint["small"].brake.torque
    assert np.all(brakes[: by.nominal] == 1.0)
    assert np.all(by.vary["joint.small.friction.static_ratio"][: by.nominal] == 1.0)
    assert np.all(np.abs(brakes[by.nominal :] - 1.0) > 0.0)
    assert {plant.joint["small"].losses.kind for plant in by.plants} == {"elasto-slip", "bouc-wen"}
    assert "scenario.payload" not in by.vary
    unsure = sample_robust_conditions(changed(ARM, "controller.payload_std", "0.5 kg"), 32, None, 3)
    assert np.all(unsure.vary["scenario.payload"][: unsure.nominal] == ARM.arm.payload)
    assert np.ptp(unsure.vary["scenario.payload"]) > 1.0


def test_runs_are_those_of_their_own_plants_in_order(tmp_path: Path) -> None:
    machine = load(one_joint(tmp_path))
    by = sample_robust_conditions(machine, 8, None, 1)
    vary = by.repeat_varied(2) | {"controller.reserve": np.repeat([0.1, 0.4], 8)}
    found = by.simulate(machine, vary)
    for run in (0, 3, 7, 12, 15):
        own = {path: values[run : run + 1] for path, values in vary.items()}
        alone = ensemble(by.plants[by.which[run % 8]], by.scenarios, own, controller=machine)
        assert np.array_equal(found.tip_settling[run], alone.tip_settling[0])
    costs = candidate_costs(found, by, 2)
    assert costs.shape == (2,)
    assert costs[0] != costs[1]


def test_a_law_that_is_set_badly_is_tuned_better(tmp_path: Path) -> None:
    bad = one_joint(tmp_path, "bad", 'bandwidth = "8 1/s"\nvalve_fraction = 0.2')
    tuning = begin_tuning(str(bad), tmp_path / "out", start="current", generations=6)
    tuning.search()
    result = finish_tuning(tuning)
    tuned = result.machine
    assert not tuning.unchanged
    assert result.before is not None
    assert result.after.cost < 0.9 * result.before.cost
    assert np.allclose(current_values(tuned, tuning.knobs), tuning.history[-1].values)
    assert tuned.provenance["controller.reserve"].source == "calibrated"
    html = write_page(result, tmp_path / "tuning.html").read_text(encoding="utf-8")
    assert "<h1>Settings of bad</h1>" in html
    assert "settling within 2 mm" in html
    assert "another law of losses" in html


def test_no_bandwidth_is_tried_that_the_cycle_does_not_allow() -> None:
    slow = changed(ARM, "controller.cycle", "20 ms")
    knob = setting_knobs(slow)[0]
    assert knob.low < knob.neutral == knob.high == pytest.approx(7.5)


@pytest.mark.parametrize(
    ("options", "expected"),
    [
        ({"method": "phases"}, "method: unknown method 'phases' for settings; give global"),
        ({"over": "cloud"}, "over: the tracking law is told which machine it has; tune for each member by itself"),
    ],
)
def test_what_only_the_papers_law_has_is_refused(options: dict[str, str], expected: str, tmp_path: Path) -> None:
    with pytest.raises(InputError) as error:
        begin_tuning("paper-arm-tracking", tmp_path / "out", **options)  # type: ignore[arg-type]
    assert str(error.value) == expected
