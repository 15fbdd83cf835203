"""The open questions: every figure draws, and every finding says what the table says."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas
import pytest

from layflat.description.change import value_at
from layflat.errors import InputError
from layflat.experiments import Reproduction, questions, write_report
from layflat.experiments.questions import (
    QUESTION_MODULES,
    answer_question,
    assumptions,
    dither,
    inertia_limits,
    inertia_per_torque,
    losses_and_brake,
    median_grid,
    read_answers,
    run_question,
    supply_pressure,
    valves,
)
from layflat.machine.listing import list_values
from layflat.machine.loader import load, tables
from layflat.plot.style import to_svg
from layflat.study import Study, is_finished, read_study, run_study, study_names, study_table
from layflat.study.check import check_runs
from layflat.study.sampling import draw_samples
from layflat.study.varied import machine_values

Asked = dict[str, tuple[Study, pandas.DataFrame]]
THIN = {"brake-and-inertia": 5, "losses-and-brake": 5, "dither": 5, "valves": 2, "supply-pressure": 3, "assumptions": 2}

HELD = {
    "losses.weights": "they add up to one; what turn each element takes to slip varies instead",
    "hose.loss_fraction": "only its product with the cover's factor counts, which varies",
    "valve.centre_voltage": "driver and controller share it",
    "stops": "no move reaches them",
    "valve.volts_to_full": "a driver's range is known; another would ask for other gains in proportion",
}
"""What is not the paper's but does not vary in `assumptions`, and why."""


@pytest.fixture(scope="module")
def asked(tmp_path_factory: pytest.TempPathFactory) -> Asked:
    """Every study with few samples, and its table."""
    found = {}
    for name, points in THIN.items():
        study, out = read_study(name).thinned(points), tmp_path_factory.mktemp(name)
        run_study(study, out)
        found[name] = study, study_table(out)
    return found


def test_every_built_in_study_is_a_question() -> None:
    assert sorted(QUESTION_MODULES) == sorted(study_names()) == sorted(THIN)


@pytest.mark.parametrize("name", THIN)
def test_the_figure_draws_with_units_and_the_same_bytes(asked: Asked, name: str) -> None:
    study, frame = asked[name]
    question = QUESTION_MODULES[name]
    made = question.figure(study, frame)
    for axes in made.axes:
        assert "(" in axes.get_xlabel() or "index" in axes.get_xlabel()
    assert to_svg(made) == to_svg(question.figure(study, frame))
    assert questions.QUESTION_TEXTS[name]["title"].endswith("?")
    assert questions.QUESTION_TEXTS[name]["caption"].endswith(".")


@pytest.mark.parametrize("name", THIN)
def test_the_finding_is_whole_sentences_of_the_table_alone(asked: Asked, name: str) -> None:
    study, frame = asked[name]
    said = QUESTION_MODULES[name].finding(study, frame)
    assert said.endswith(".")
    assert not any(word in said for word in ("nan", "inf ", "None"))
    assert QUESTION_MODULES[name].finding(study, frame.sample(frac=1.0, random_state=1).sort_index()) == said


def made_up(asked: Asked, name: str, column: str, values: Callable[[pandas.DataFrame], object]) -> tuple[Study, str]:
    """A question's study, and what it finds where a column is what we say."""
    study, frame = asked[name]
    columns = [own for own in frame.columns if own.split(".")[0] == column]
    return study, QUESTION_MODULES[name].finding(study, frame.assign(**{own: values(frame) for own in columns}))


def test_brake_that_helps_and_brake_that_does_not(asked: Asked) -> None:
    def more_is_better(frame: pandas.DataFrame) -> object:
        return np.where(frame["scenario.brake"] * 8.0 >= frame["scenario.payload"], 1.0, np.inf)

    _, said = made_up(asked, "brake-and-inertia", "settling", more_is_better)
    assert "settles most inertia within 1.5 s at 60 % of total hysteresis" in said  # as good as 78 %, and less
    assert "the paper's 25 % carries 12 % of that" in said
    assert "stalls" not in said
    _, said = made_up(
        asked, "brake-and-inertia", "settling", lambda frame: np.where(frame["scenario.brake"] > 1.5, np.inf, 1.0)
    )
    assert "From 42 % on it stalls" in said
    assert "the paper's 25 % carries as much or nearly so" in said
    _, said = made_up(asked, "brake-and-inertia", "settling", lambda _: np.inf)
    assert said.count("no level of the brake lets the joint settle within 1.5 s") == 2


def test_losses_as_good_as_a_brake_and_not(asked: Asked) -> None:
    brake = losses_and_brake.BRAKE_COLUMN
    _, said = made_up(
        asked, "losses-and-brake", "settling", lambda frame: np.where(frame["scenario.payload"] < 5, 1.0, np.inf)
    )
    assert "Where the hysteresis comes from makes little difference." in said

    def with_brake(frame: pandas.DataFrame) -> object:
        return np.where(frame["scenario.payload"] < 2.0 + 3.0 * frame[brake], 1.0, np.inf)

    _, said = made_up(asked, "losses-and-brake", "settling", with_brake)
    assert "better in a brake" in said
    study, frame = asked["losses-and-brake"]
    ripple = np.where(frame[brake] > 0.0, 0.0, 0.02)
    own = frame.assign(**{"settling.small.0": with_brake(frame), "ripple.small.0": ripple})
    said = losses_and_brake.finding(study, own)
    assert "1.1 deg of motion are left with all of it in the hose, nothing is left" in said


def test_dither_that_helps_and_dither_that_does_not(asked: Asked) -> None:
    study, frame = asked["dither"]
    amplitude, friction, frequency = (frame[one] for one in (dither.AMPLITUDE, dither.FRICTION, dither.FREQUENCY))
    moves = [own for own in frame.columns if own.startswith(("steady_error", "ripple"))]

    def said(enough: pandas.Series) -> str:
        error = np.radians(np.where(enough, 0.05, 0.5))
        return dither.finding(study, frame.assign(**dict.fromkeys(moves, error)))

    slow = said(amplitude >= 2.0 * friction)
    assert "rests 0.50 deg off" in slow
    assert "Enough near 50 Hz is an amplitude of" in slow
    assert "does it with no more" in slow
    assert "takes 30 % where 10 % do near 50 Hz" in said(amplitude >= np.where(frequency > 100.0, 0.3, 0.1))
    assert "Dither makes little difference." in said(amplitude >= 0.0)


def test_valves_that_matter_and_valves_that_do_not(asked: Asked) -> None:
    study, said = made_up(asked, "valves", "settling", lambda _: 1.0)
    assert "the valve hardly matters for settling: 1.00 s" in said
    odd = study.variants[3].name
    _, said = made_up(asked, "valves", "settling", lambda frame: np.where(frame["variant"] == odd, 0.5, 1.0))
    assert f"the valve matters for settling: 0.50 s ({odd}) to 1.00 s" in said


def test_a_valve_is_judged_with_its_own_best_gains(asked: Asked) -> None:
    study, frame = asked["valves"]
    error, pressure = (one.path for one in study.varied if one.relative)
    odd = study.variants[1].name
    suits = np.where(frame["variant"] == odd, frame[error] == frame[error].max(), frame[error] == frame[error].min())
    settling = np.where(suits, 0.6, 1.9)
    air = np.where(frame[pressure] == frame[pressure].max(), 1.0, 2.0)
    columns = [own for own in frame.columns if own.startswith("settling")]
    found = valves.best_by_valve(study, frame.assign(**dict.fromkeys(columns, settling), air_used=air))
    assert np.allclose(found["settling"], 0.6)
    assert np.allclose(found["air"], 1.0)
    assert list(found.index) == [one.name for one in study.variants]


def test_supply_that_is_enough_and_that_is_not(asked: Asked) -> None:
    column = supply_pressure.PRESSURE_COLUMN
    assert "The joint settles within 1.5 s at every" in made_up(asked, "supply-pressure", "settling", lambda _: 0.5)[1]
    _, said = made_up(asked, "supply-pressure", "settling", lambda frame: np.where(frame[column] < 3e5, np.inf, 0.5))
    assert "From 3.75 bar on the joint settles within 1.5 s" in said
    _, said = made_up(asked, "supply-pressure", "settling", lambda _: np.inf)
    assert "At 6 bar the joint settles in not at all, not within 1.5 s" not in said
    assert "At 6 bar the joint does not settle" in said


def test_air_alone_is_as_stiff_as_its_law_says(asked: Asked) -> None:
    """Two hoses: twice K squared times pressure by volume, times 1 (slow) to 1.4 (fast); losses add a little."""
    study, frame = asked["supply-pressure"]
    found = supply_pressure.results_by_pressure(frame)
    from layflat.machine import parameters

    joint, air = study.machine.joint["small"], study.machine.supply
    hose = parameters.hose(joint)
    k = parameters.torque_constant(joint)
    pressure = 0.75 * (1e5 * found["pressure"] + air.ambient_pressure)
    volume = joint.hose.dead_volume + k * hose.neutral + joint.hose.compliance * (pressure - air.ambient_pressure)
    slow = np.radians(2.0 * k**2 * pressure / (volume + joint.hose.compliance * pressure))
    assert np.all(found["air stiffness"] > slow)
    assert np.all(found["air stiffness"] < 1.4 * 1.4 * slow)


def test_results_that_hold_and_that_depend(asked: Asked) -> None:
    study, frame = asked["assumptions"]
    columns = {"settling": 0.5, "ripple": 0.0, "tip_error": 1e-3}
    good = frame.assign(
        **{own: value for key, value in columns.items() for own in frame.columns if own.split(".")[0] == key}
    )
    said = assumptions.finding(study, good)
    assert "“settles within 1.5 s” (100 %), “tip within 2 mm” (100 %)" in said
    assert "hold whatever was assumed" in said
    assert "“does not settle without brake” (0 %) depends on what was assumed" in said
    said = assumptions.finding(
        study, frame.assign(**{own: 9.0 for own in frame.columns if own.startswith("tip_error")})
    )
    assert "“tip within 2 mm” (0 %)" in said


def test_what_decides_is_named_first(asked: Asked) -> None:
    study, frame = asked["assumptions"]
    path = "joint.large.hose.dead_volume"
    settling = 0.5 + 0.5 * frame[path] / frame[path].max()
    own = frame.assign(**{name: settling for name in frame.columns if name.startswith("settling")})
    found = assumptions.finding(study, own)
    assert "Settling depends most on hose dead volume (" in found
    ranked = assumptions.result_indices(study, own)["settling"].total[: len(study.varied)]
    assert study.varied[int(np.argmax(ranked))].path == path
    assert np.count_nonzero(ranked > 1e-9) == 1


def test_every_value_that_is_not_the_papers_varies_or_is_told_why_not() -> None:
    study = read_study("assumptions")
    spread = {path for one in study.varied for path in one.paths}
    group = {path: one.group for one in study.varied for path in one.paths}
    arm = load("paper-arm")
    for line in list_values(*tables("paper-arm")):
        if line.source not in {"assumed", "calibrated"}:
            continue
        own = [path for path in spread if path == line.path or path.startswith(f"{line.path}.")]
        if own:
            expected = "gains" if ".gains." in line.path and line.source == "calibrated" else f"{line.source} values"
            assert {group[path] for path in own} == {expected}, line.path
        elif not any(reason in line.path for reason in HELD):
            value = value_at(arm, line.path)
            if isinstance(value, float):  # a word or a whole number could not
                both = {line.path: np.array([value, 0.9 * value + 1e-3])}
                with pytest.raises(InputError, match="has no effect"):
                    check_runs(arm, study.scenarios[:1], both, study.step, line.path)


def test_limits_begin_at_the_papers_comparison() -> None:
    ratios = np.array([0.005, 0.01, 0.02, 0.04])
    times = np.array([[9.0, 1.0, 1.0], [1.0, 1.0, 2.0], [1.0, 9.0, 1.0], [2.0, 1.0, 1.0]])
    assert list(inertia_limits(ratios, times, 1.5)) == [0.02, 0.01, 0.0]


def test_a_run_that_diverged_has_not_settled() -> None:
    frame = pandas.DataFrame({"x": [1.0] * 3 + [2.0] * 3, "y": [1.0] * 6, "z": [1.0, 2.0, np.nan, 1.0, np.nan, np.inf]})
    assert list(median_grid(frame, "x", "y", "z")[2][0]) == [2.0, np.inf]


def test_inertia_per_torque_is_that_of_the_paper() -> None:
    assert inertia_per_torque(load("paper-small-joint"), np.array([2.0]))[0] == pytest.approx(0.32 / 25.05, rel=1e-3)


def test_answers_come_from_finished_tables_alone(
    tmp_path: Path, paper: Reproduction, monkeypatch: pytest.MonkeyPatch
) -> None:
    def shorter(name: str) -> Study:
        return read_study(name).thinned(3)

    monkeypatch.setattr(questions, "read_study", shorter)
    assert read_answers(tmp_path / "none") == []
    name = "supply-pressure"
    run_study(read_study(name).thinned(2), tmp_path / "thin" / name)
    assert answer_question(name, tmp_path / "thin" / name).finding
    assert read_answers(tmp_path / "thin") == [], "it is the table of another study"
    own = run_question(name, tmp_path / "whole" / name)
    assert is_finished(shorter(name), tmp_path / "whole" / name)
    assert read_answers(tmp_path / "whole") == [own]
    assert answer_question(name, tmp_path / "whole" / name) == own
    without_figures = replace(paper, claims=[])
    html = write_report(without_figures, [], tmp_path / "report.html", [own]).read_text(encoding="utf-8")
    assert "<h2>Open questions</h2>" in html
    assert 'id="question-supply-pressure"' in html
    assert own.finding in html
    assert "Open questions" not in write_report(without_figures, [], tmp_path / "b.html").read_text(encoding="utf-8")
    (tmp_path / "whole" / name / "figure.svg").unlink()
    assert read_answers(tmp_path / "whole") == []


def test_samples_of_the_assumptions_stay_within_their_spread() -> None:
    study = read_study("assumptions").thinned(4)
    on_arm = machine_values(study.varied, draw_samples(study.varied, study.file), study.machine)
    usual = value_at(study.machine, "valve.leakage")
    assert np.all((on_arm["valve.leakage"] >= 0.5 * usual) & (on_arm["valve.leakage"] <= 2.0 * usual))
