"""Results show themselves in a notebook and draw themselves: figures with units and a caption, texts escaped."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.figure import Figure

import layflat as lf

STEP = lf.Scenario(demand={"large": "20 deg"}, start="0 deg", duration="1 s")
pytestmark = pytest.mark.compiled


def designed() -> Any:
    return lf.design_joint("paper-arm", "large")


def sized() -> Any:
    return lf.size_joint(lf.SizingRequest(torque="25 N m", stroke="120 deg", supply="4 bar"))


RESULTS: dict[str, Any] = {
    "machine": lambda: lf.load("paper-arm"),
    "machine in space": lambda: lf.load("picking-arm"),
    "run": lambda: lf.rollout("paper-arm", scenario=STEP),
    "one joint of a run": lambda: lf.rollout("paper-arm", scenario=STEP).sel(joint="large"),
    "metrics": lambda: lf.metrics(lf.rollout("paper-arm", scenario=STEP)),
    "ensemble": lambda: lf.ensemble("paper-arm", STEP, {"arm.payload": [1.0, 1.5, 2.0, 2.5]}),
    "runs that differ in nothing": lambda: lf.ensemble("paper-arm", STEP, runs=3),
    "design": designed,
    "design with a roller": lambda: lf.design_joint("earlier-actuator", "small"),
    "sized joint": sized,
    "sized arm": lambda: lf.size_arm(reach="0.6 m", joints=2, payload="1 kg", supply="6 bar", time="1 s"),
    "motion": lambda: lf.plan_motion("paper-arm-tracking", [{"kind": "line", "to": ["450 mm", "300 mm"]}]),
    "tuned controller": lambda: lf.tune.tune_controller("paper-small-joint", generations=1, start="current"),
}


@pytest.mark.parametrize("name", RESULTS)
def test_a_result_shows_and_draws_itself(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    result = RESULTS[name]()
    assert "<table>" in result._repr_html_() or name == "one joint of a run"
    figure = result.plot()
    assert isinstance(figure, Figure)
    assert figure.texts[-1].get_text()
    assert all("(" in axes.get_ylabel() or not axes.get_ylabel() for axes in figure.axes)
    assert figure._repr_png_().startswith(b"\x89PNG")  # type: ignore[attr-defined]
    assert isinstance(lf.plot.draw(result), Figure)


def test_texts_are_escaped() -> None:
    odd = lf.load("paper-arm").model_copy(update={"title": "<script>alert(1)</script>"})
    assert "<script>" not in odd._repr_html_()


def test_other_plots_of_a_run_are_those_of_xarray() -> None:
    run = lf.rollout("paper-arm", scenario=STEP)
    assert run.plot.scatter(x="angle", y="pressure_a") is not None
    assert type(run.sel(time=slice(0.0, 0.5))) is type(run)
    assert run[["voltage"]]._repr_html_().count("<table>") == 0


def test_a_run_comes_back_as_one_that_draws_itself(tmp_path: Path) -> None:
    back = lf.open_run(lf.save(lf.rollout("paper-arm", scenario=STEP), tmp_path / "run.nc"))
    assert isinstance(back.plot(), Figure)


def test_metrics_of_a_run_are_those_of_an_ensemble() -> None:
    one = lf.metrics(lf.rollout("paper-arm", scenario=STEP, seed=3))
    many = lf.ensemble("paper-arm", STEP, {"seed": [3]})
    for name in one.data_vars:
        assert np.allclose(one[name].values, many[name].isel(run=0).values, rtol=1e-6, atol=1e-9), name
        assert one[name].units == many[name].units


def test_what_varies_has_its_unit() -> None:
    vary = {"arm.payload": ["1 kg", "2 kg"], "scenario.drift": [0.0, 0.1], "start.angle.small": [0.0, 0.1]}
    runs = lf.ensemble("paper-arm", STEP, vary)
    assert [runs[key].attrs.get("units") for key in vary] == ["kg", "V", None]
    assert "arm.payload (kg)" in {axes.get_xlabel() for axes in runs.plot().axes}


def test_a_caption_lies_below_what_it_explains() -> None:
    figure = lf.plot.add_caption(lf.plot.run_figure(lf.rollout("paper-arm", scenario=STEP)), "word " * 60)
    lines = [text for text in figure.texts if "word" in text.get_text()]
    assert len(lines) > 1
    assert max(text.get_position()[1] for text in lines) < min(axes.get_position().y0 for axes in figure.axes)


@pytest.mark.parametrize(
    ("call", "told"),
    [
        (lambda: lf.plot.draw(3), "result: 3 can't be drawn; give a machine, a run, a design ..."),
        (lambda: lf.save(3, "x"), "item: 3 can't be saved; give a machine, a run or metrics"),  # type: ignore[arg-type]
        (lambda: lf.metrics(3), "run: 3 is no run; give what `rollout` or `open_run` returns"),  # type: ignore[arg-type]
        (lambda: lf.metrics(lf.rollout("paper-arm", scenario=STEP)[["angle"]]), "run: has no demand; give what "),
        (lambda: lf.rollout("paper-arm", 0.0, scenario=lf.Scenario(opening=0.1)), "demand: stands beside an opening"),
        (lambda: lf.tune.tune_controller(lf.load("paper-arm")), "machine: paper-arm has no file; give one: save("),  # type: ignore[arg-type]
        (lambda: lf.reproduce(claims=["tabl-1"]), "claims: unknown claim 'tabl-1'; did you mean 'table-1'?"),
        (lambda: lf.inverse_kinematics("paper-arm", {"x": "0.5 m"}), "tip: has no y; give x, y"),
        (lambda: lf.inverse_kinematics("paper-arm", np.zeros((2, 3))), "tip: is an array of shape (2, 3); give finite"),
        (lambda: lf.plan_motion("paper-arm", "tour", start="0 deg"), "start: is only for segments given as a list"),
        (lambda: lf.plan_motion("paper-arm", [{"kind": "lin"}]), "motion: segment 1: kind: 'lin' is not a known kind"),
        (lambda: lf.size_arm(lf.size_arm, reach="1 m"), "names no arm task"),  # type: ignore[arg-type]
    ],
)
def test_mistakes_are_told_in_one_line_of_python(call: Any, told: str) -> None:
    with pytest.raises(lf.InputError) as error:
        call()
    assert told in str(error.value)
    assert "\n" not in str(error.value)
    assert "--" not in str(error.value)
