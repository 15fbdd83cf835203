from html.parser import HTMLParser
from math import radians
from pathlib import Path

import numpy as np
import pytest
import xarray

from layflat.errors import InputError, MachineError, OutputError
from layflat.machine import Machine, load
from layflat.tune import Tuning, begin_tuning, finish_tuning
from layflat.tune import robust as v
from layflat.tune import search as s
from layflat.tune.conditions import Conditions, sample_conditions
from layflat.tune.knobs import current_values, neutral_values
from layflat.tune.page import value_rows, write_page
from layflat.tune.robust import Validation, coupling_warnings, validate
from layflat.tune.search import MakeConditions, SearchResult

BARE = """extends = "paper-small-joint"
omits = ["joint.small.gains"]
name = "bare"
title = "A joint without gains"
"""


@pytest.fixture(autouse=True)
def _small(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(s, "PANEL_RUNS", 16)
    monkeypatch.setattr(v, "VALIDATION_RUNS", 16)


@pytest.fixture
def bare(tmp_path: Path) -> Path:
    path = tmp_path / "bare.toml"
    path.write_text(BARE, encoding="utf-8")
    return path


def usual(machine: Machine) -> MakeConditions:
    def meet(runs: int, seed: int) -> Conditions:
        return sample_conditions(machine, runs, seed=seed)

    return meet


def test_what_is_written_is_what_was_found(bare: Path, tmp_path: Path) -> None:
    tuning = begin_tuning(str(bare), tmp_path / "deep" / "out", generations=2)
    tuning.search()
    tuned = tuning.save_best()
    assert tuning.path == tmp_path / "deep" / "out" / "bare-tuned.toml"
    assert np.allclose(current_values(tuned, tuning.knobs), tuning.history[-1].values, rtol=1e-12)
    assert tuned == load(tuning.path)
    assert tuned.joint["small"].gains is not None
    assert tuned.joint["small"].gains.integral_limit == pytest.approx(0.4 * tuned.valve.volts_to_full)  # type: ignore[union-attr]
    for knob in tuning.knobs:
        source = tuned.provenance[knob.paths[0]]
        assert (source.source, source.note) == ("calibrated", tuning.command)
    same = load("paper-small-joint")
    assert tuned.joint["small"].model_copy(update={"gains": None}) == same.joint["small"].model_copy(
        update={"gains": None}
    )


def test_gains_are_judged_over_members_of_the_cloud_where_asked(bare: Path, tmp_path: Path) -> None:
    tuning = begin_tuning(str(bare), tmp_path / "out", generations=1, over="cloud")
    tuning.search()
    tuned = tuning.save_best()
    assert tuning.ranges is not None
    assert "valve.conductance" in tuning.ranges.members
    assert "--over cloud" in tuned.provenance["joint.small.gains.far.error"].note
    over, alone = validate(tuned, tuning.make_conditions), validate(tuned, usual(tuned))
    assert over.cost != alone.cost
    assert np.array_equal(over.nominal, alone.nominal)


def test_the_same_seed_writes_the_same_file_and_another_does_not(bare: Path, tmp_path: Path) -> None:
    def gains(seed: int, out: str) -> bytes:
        tuning = begin_tuning(str(bare), tmp_path / out, method="phases", generations=3, seed=seed)
        tuning.search()
        tuning.save_best()
        return tuning.path.read_bytes()

    assert gains(3, "a") == gains(3, "b") != gains(4, "c")


def test_an_interrupted_search_keeps_the_best_so_far(bare: Path, tmp_path: Path) -> None:
    def three(best: SearchResult, done: int, name: str) -> None:
        if done == 3:
            raise KeyboardInterrupt

    tuning = begin_tuning(str(bare), tmp_path / "out", generations=50)
    tuning.search(three)
    assert tuning.stopped
    assert len(tuning.history) == 4
    assert "stopped after 3" in tuning.command
    assert np.allclose(current_values(tuning.save_best(), tuning.knobs), tuning.history[-1].values)


def test_an_interruption_before_the_beginning_goes_on(
    bare: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def at_once(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("layflat.tune.tuning.search_knob_values", at_once)
    with pytest.raises(KeyboardInterrupt):
        begin_tuning(str(bare), tmp_path / "out").search()


def test_gains_are_never_made_worse(tmp_path: Path) -> None:
    tuning = begin_tuning("paper-arm-fast-tuned", tmp_path, generations=1)
    tuning.search()
    kept = tuning.save_best()
    assert tuning.unchanged
    assert np.allclose(
        current_values(kept, tuning.knobs), current_values(load("paper-arm-fast-tuned"), tuning.knobs), rtol=1e-9
    )


class Page(HTMLParser):
    def __init__(self) -> None:
        super().__init__()
        self.outside: list[str] = []
        self.figures = 0

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.outside += [v for k, v in attrs if k in {"src", "href", "xlink:href"} and v and not v.startswith("#")]
        self.figures += tag == "figure"


def told(tuning: Tuning) -> Tuning:
    values = neutral_values(tuning.knobs)
    tuning.history += [SearchResult(values, 3.0, 0), SearchResult(values, 2.5, 1)]
    return tuning


@pytest.mark.parametrize("name", ["paper-small-joint", "bare"])
def test_the_page_stands_alone_and_says_what_was_found(name: str, bare: Path, tmp_path: Path) -> None:
    tuning = told(begin_tuning(str(bare) if name == "bare" else name, tmp_path / "out", start="current"))
    result = finish_tuning(tuning)
    assert (result.before is None) == (name == "bare")
    rows = result.comparison_rows()
    assert any("small joint by 40 deg" in row[0] for row in rows)
    assert all((row[1] == "none") == (name == "bare") for row in rows)
    html = write_page(result, tmp_path / "tuning.html").read_text(encoding="utf-8")
    page = Page()
    page.feed(html)
    assert page.outside == []
    assert page.figures == 3
    assert "The cost: seconds until moves settle" in html
    for row in value_rows(tuning, result.machine):
        assert all(f">{cell}<" in html for cell in row if cell)


def test_a_verdict_counts_what_never_settles_as_worst() -> None:
    found = validate(load("paper-small-joint"), usual(load("paper-small-joint")))
    assert found.settling.shape == (16, 2, 1)
    assert found.worst == found.settling.max()
    assert found.late == np.count_nonzero(found.settling > 1.5)
    assert found.nominal == pytest.approx(found.settling[:2, :, 0].mean(axis=0))


@pytest.mark.parametrize(
    ("given", "options", "expected"),
    [
        ("paper-arm", {"method": "guess"}, "method: unknown method 'guess' for gains; give global or phases"),
        ("paper-arm", {"generations": 0}, "generations: 0 is out of range; give 1 to 9999"),
        ("paper-arm", {"start": "here"}, "start: unknown start 'here'; give neutral or current"),
        ("paper-arm", {"seed": -1}, "seed: -1 is out of range; give 0 to 9999"),
        ("paper-arm", {"device": "tpu"}, 'device: \'tpu\' is not a device; use "cpu" or "cuda"'),
    ],
)
def test_mistakes_are_told_before_any_work(given: str, options: dict[str, int], expected: str, tmp_path: Path) -> None:
    with pytest.raises(InputError) as error:
        begin_tuning(given, tmp_path / "out", **options)  # type: ignore[arg-type]
    assert str(error.value).startswith(expected)
    assert not (tmp_path / "out").exists()


def test_a_rig_has_nothing_to_tune(tmp_path: Path) -> None:
    with pytest.raises(MachineError, match="rig-kevlar: has no controller to be tuned"):
        begin_tuning("rig-kevlar", tmp_path)


def test_a_file_that_would_overwrite_what_it_extends_is_refused(tmp_path: Path) -> None:
    (tmp_path / "mine-tuned.toml").write_text('extends = "paper-arm"\n', encoding="utf-8")
    mine = tmp_path / "mine.toml"
    mine.write_text('extends = "mine-tuned.toml"\nname = "mine"\n', encoding="utf-8")
    with pytest.raises(InputError, match="would be overwritten"):
        begin_tuning(str(mine), tmp_path)
    begin_tuning(str(mine), tmp_path / "elsewhere")


def test_a_folder_that_is_a_file_is_refused(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    with pytest.raises(OutputError):
        begin_tuning("paper-arm", tmp_path / "file")


def made_validation(pushed: float) -> Validation:
    settling = np.full((16, 2, 2), 0.5)
    told_of = {"small joint pushed by the large one": radians(pushed), "large joint pushed by the small one": 0.001}
    return Validation(settling, np.full(2, 0.5), 1.0, xarray.Dataset(), told_of)


@pytest.mark.parametrize(
    ("before", "after", "said"), [(0.8, 10.1, True), (6.0, 10.1, False), (0.8, 2.5, False), (None, 10.1, True)]
)
def test_a_joint_that_is_pushed_much_further_is_warned_of(before: float | None, after: float, said: bool) -> None:
    found = coupling_warnings(None if before is None else made_validation(before), made_validation(after))
    assert len(found) == said
    if said:
        than = "" if before is None else ", 0.8 deg before"
        assert found[0].startswith(f"Coupling: small joint pushed by the large one by 10.1 deg{than}.")


def test_the_arms_coupling_is_that_of_its_nominal_run() -> None:
    found = validate(load("paper-arm"), usual(load("paper-arm")))
    assert list(found.deflections) == ["small joint pushed by the large one", "large joint pushed by the small one"]
    small, large = found.deflections.values()
    assert small > 3.0 * large
    part = found.response["angle"].sel(joint="small", time=slice(0.3, 2.0)).to_numpy()
    assert small == pytest.approx(np.abs(part - part[0]).max())


def test_a_name_that_leads_elsewhere_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    path.write_text('extends = "paper-small-joint"\nname = "../../evil"\n', encoding="utf-8")
    with pytest.raises(InputError, match="name"):
        begin_tuning(str(path), tmp_path / "out")


def test_a_title_does_not_contradict_what_was_changed(tmp_path: Path) -> None:
    path = tmp_path / "heavy.toml"
    path.write_text('extends = "paper-arm"\nname = "heavy"\n[arm]\npayload = "2.5 kg"\n', encoding="utf-8")
    assert "kg" not in load(path).title
