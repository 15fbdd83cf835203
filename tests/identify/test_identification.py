"""From files to files: what is refused before any work is done, and what is written."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from layflat.errors import InputError
from layflat.identify.identification import prepare_identification
from layflat.identify.report_text import (
    count_identified,
    describe_prediction,
    distrust_reason,
    experiment_rows,
    issue_table,
    write_page,
)
from layflat.machine import load
from layflat.machine.loader import BENCH_LIBRARY
from tests.identify.benchlogs import Array, columns, written

SMALL = "paper-small-joint"
Table = dict[str, Array]


def rows(chosen: slice) -> Callable[[Table], Table]:
    return lambda table: {name: values[chosen] for name, values in table.items()}


def with_signal(name: str, change: Callable[[Array], Array]) -> Callable[[Table], Table]:
    return lambda table: table | {name: change(table[name])}


def backwards(t: Array) -> Array:
    return np.where(t < 1.0, t, np.where(t < 2.0, t - 0.7, t - 1.4))


def at_rest(table: Table) -> Table:
    n, random = len(table["time"]), np.random.default_rng(0)
    still = {"angle": 0.02, "pressure": 0.002}
    noise = {name: size * random.standard_normal(n) for name, size in still.items()}
    return table | noise | {"voltage": np.full(n, 5.0)}


SPOILT: dict[str, tuple[Callable[[Table], Table], str]] = {
    "sign of the angle": (with_signal("angle", np.negative), r"turns against the pressure.*sign = -1"),
    "time in ms": (with_signal("time", lambda t: 1e3 * t), r"unit of time: a factor of 0.001 would fit"),
    "time backwards": (with_signal("time", backwards), r"time goes backwards 2 times, first from .* at sample"),
    "a dead sensor": (with_signal("angle", lambda q: np.full_like(q, 3.0)), r"angle.small: is exactly 3 deg all the"),
    "nothing in it": (with_signal("angle", lambda q: np.full_like(q, np.nan)), r"angle.small: holds no value"),
    "four samples": (rows(slice(0, 4)), r"holds 4 samples"),
    "a machine at rest": (
        at_rest,
        r"can't identify joint.small.brake.torque, joint.small.brake.viscous; record slow ramps .*chirps.*excite",
    ),
}


@pytest.mark.parametrize("how", SPOILT)
def test_a_log_that_is_spoilt_is_refused_in_one_line(how: str, tmp_path: Path) -> None:
    change, expected = SPOILT[how]
    log = written(tmp_path / "log.csv", change(columns()))
    with pytest.raises(InputError, match=expected) as caught:
        prepare_identification([log], SMALL, tmp_path / "out", blocks="friction")
    assert "\n" not in str(caught.value)
    assert "log.csv" in str(caught.value)
    assert not (tmp_path / "out").exists()


def test_a_wrong_unit_is_told_with_the_right_one(tmp_path: Path) -> None:
    log = written(tmp_path / "log.csv", columns(), angle="angle.small [rad]")
    with pytest.raises(InputError, match=r'log.csv: angle.small: .*unit = "deg" instead of "rad" would fit'):
        prepare_identification([log], SMALL, tmp_path)


def test_gauge_pressures_that_are_said_to_be_absolute(tmp_path: Path) -> None:
    """What is vented shows it: nothing is below ambient."""
    vented = {"a": 2.0 + 2.0 * np.sin(columns()["time"]), "b": np.maximum(0.0, 2.0 - columns()["time"])}
    names = {"a": "pressure_a.small [bar]", "b": "pressure_b.small [bar]"}
    log = written(tmp_path / "log.csv", columns() | vented, **names)
    with pytest.raises(InputError, match=r"pressure_[ab].small.*below ambient.*gauge = true would fit"):
        prepare_identification([log], SMALL, tmp_path)


@pytest.mark.parametrize(
    ("missing", "expected"),
    [
        ("voltage", r"log: has no voltage of joint 'small'; map a column to the signal voltage"),
        ("angle", r"log: has no angle of joint 'small'; map a column to the signal angle"),
    ],
)
def test_a_log_that_lacks_a_signal(missing: str, expected: str, tmp_path: Path) -> None:
    table = {name: values for name, values in columns().items() if name != missing}
    with pytest.raises(InputError, match=expected):
        prepare_identification([written(tmp_path / "log.csv", table)], SMALL, tmp_path)


@pytest.mark.parametrize(
    ("machine", "expected"),
    [
        ("paper-arm", r"has no angle of joint 'large'.*every joint: large, small"),
        ("rig-kevlar", r"rig-kevlar: has no valve; give a machine with a valve; or logs with torque"),
        ("friction-rig", r"has no force; map a column to the signal force"),
        ("blow-down-vessel", r"has fewer than 3 samples of pressure"),
        ("regulated-elbow", r"has no setpoint_a; a regulated joint needs setpoint_a, setpoint_b, angle"),
        ("nosuch", r"nosuch: no such machine"),
        ("nosuch.rig.yml", r"nosuch.rig.yml: can't be read"),
    ],
)
def test_a_log_of_another_bench(machine: str, expected: str, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=expected):
        prepare_identification([written(tmp_path / "log.csv", columns())], machine, tmp_path)


@pytest.mark.parametrize("blocks", ["bogus", "", "valve,,hose"])
def test_an_unknown_block(blocks: str, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"blocks: unknown block '.*'; choose from valve, hose, losses"):
        prepare_identification([written(tmp_path / "log.csv", columns())], SMALL, tmp_path, blocks=blocks)


def test_logs_need_names_of_their_own(tmp_path: Path) -> None:
    (tmp_path / "other").mkdir()
    log = written(tmp_path / "log.csv", columns())
    with pytest.raises(InputError, match=r"log.csv: is given twice"):
        prepare_identification([log, log], SMALL, tmp_path)
    with pytest.raises(InputError, match=r"log.csv: is given twice"):
        prepare_identification([log], SMALL, tmp_path, validate=[log])
    with pytest.raises(InputError, match=r"has the same name as"):
        prepare_identification([log], SMALL, tmp_path, validate=[written(tmp_path / "other" / "log.csv", columns())])


def test_names_that_are_not_our_own_need_a_mapping_that_makes_sense(tmp_path: Path) -> None:
    log = written(tmp_path / "log.csv", columns(), time="t", angle="theta", voltage="u", pressure="dp")
    with pytest.raises(InputError, match=r"its columns \(t, theta, u, dp\) are not .*`layflat log map` writes one"):
        prepare_identification([log], SMALL, tmp_path)
    entry = '[[column]]\nfrom = "{}"\nsignal = "{}"\njoint = "small"\nunit = "{}"\n'
    time = '[time]\ncolumn = "t"\nunit = "s"\n'
    mapping = tmp_path / "twice.toml"
    mapping.write_text(time + entry.format("theta", "angle", "deg") + entry.format("dp", "angle", "deg"))
    with pytest.raises(InputError, match=r"twice.toml: theta and dp are both angle.small; keep one"):
        prepare_identification([log], SMALL, tmp_path, mapping=mapping)


def test_a_folder_that_cannot_be_written(tmp_path: Path) -> None:
    log = written(tmp_path / "log.csv", columns())
    with pytest.raises(InputError, match="can't write here"):
        prepare_identification([log], SMALL, log / "out")


def test_a_late_signal_is_waited_for_and_told(tmp_path: Path) -> None:
    table = columns() | {"angle": np.where(columns()["time"] < 0.3, np.nan, columns()["angle"])}
    session = prepare_identification([written(tmp_path / "log.csv", table)], SMALL, tmp_path, blocks="friction")
    log = session.logs["log"]
    assert float(log["time"][0]) == 0.0
    assert log.sizes["time"] == len(table["time"]) - 60
    assert np.isfinite(log["angle"][0].item())
    row = next(row for row in issue_table(session.issues).rows if "left out" in row[3])
    assert row[:3] == ["log", "warning", "angle.small"]
    assert "first 0.3 s" in row[3]


def test_logs_of_loops_keep_their_stamps(tmp_path: Path) -> None:
    random = np.random.default_rng(1)
    time = np.cumsum(random.uniform(0.005, 0.02, 3000))
    turn = 30.0 * np.sin(0.5 * time)
    torque = 5.0 + np.sign(np.cos(0.5 * time)) + 0.01 * random.standard_normal(3000)
    names = {"turn": "angle [deg]", "torque": "torque [N m]", "p": "pressure_a [bar]"}
    table = {"time": time, "turn": turn, "torque": torque, "p": np.full(3000, 3.0)}
    session = prepare_identification([written(tmp_path / "log.csv", table, **names)], SMALL, tmp_path)
    assert session.blocks == ["torque", "losses"]
    assert session.logs["log"]["time"].to_numpy() == pytest.approx(time - time[0], abs=1e-6)
    assert session.logs["log"]["angle"].to_numpy().ravel() == pytest.approx(np.radians(turn), abs=1e-7)
    assert not [row for row in issue_table(session.issues).rows if row[1] == "error" or "command" in row[3]]


def test_a_short_log_says_what_it_does_not_tell_and_what_to_record(tmp_path: Path) -> None:
    table = {name: values[90:150] for name, values in columns().items()}
    session = prepare_identification([written(tmp_path / "log.csv", table)], SMALL, tmp_path, blocks="friction")
    found = session.fit(starts=0)
    values = session.values(found)
    doubtful = [value for value in values if not value.identified]
    assert count_identified(values).startswith("None of 2" if len(doubtful) == 2 else f"{2 - len(doubtful)} of 2")
    assert [path for _, path in experiment_rows(values)] == [value.path for value in doubtful]
    assert any("shorter than a move" in row[3] for row in issue_table(session.issues).rows)
    session.write_results(found)
    source = load(session.path).provenance[doubtful[0].path]
    assert source.source == "assumed"
    assert source.note.startswith(("not identifiable from log (sha256", "at its bound from log (sha256"))


def test_the_page_says_first_what_was_fitted_and_how_well_it_predicts(tmp_path: Path) -> None:
    log = written(tmp_path / "log.csv", columns())
    other = written(tmp_path / "other.csv", columns(seed=3))
    session = prepare_identification([log], SMALL, tmp_path, blocks="friction", validate=[other])
    found = session.fit(starts=0)
    assert distrust_reason(found, session.values(found)) is None
    session.write_results(found)
    text = write_page(session, found, tmp_path / "page.html").read_text(encoding="utf-8")
    start = text[text.index("<h1>") : text.index("<h2>")]
    assert "Friction of paper-small-joint fitted to one log" in start
    assert "validated with other" in start
    assert describe_prediction(found) in start.replace("&#39;", "'")
    assert "identified by the logs" in start
    assert text.count("<figure") == 2
    assert "None of it was fitted: all is predicted." in text
    kept = json.loads(session.path.with_suffix(".json").read_text(encoding="utf-8"))
    assert kept["values"]["joint.small.brake.torque"]["value"] == pytest.approx(3.1, rel=0.05)
    assert kept["logs"]["log"] == session.checksums["log"]


def test_a_fit_that_goes_astray_where_it_was_not_fitted_is_not_to_be_trusted(tmp_path: Path) -> None:
    session = prepare_identification([written(tmp_path / "log.csv", columns())], SMALL, tmp_path, blocks="friction")
    found = session.fit(starts=0)
    assert found.trusted
    place = session.model.slices[0]
    simulated = found.simulated.copy()
    simulated[place.stop - 50 : place.stop] += 2.0
    lost = replace(found, simulated=simulated)
    assert not lost.trusted
    text = distrust_reason(lost, session.values(lost))
    assert text is not None
    assert text.startswith("angle is missed by ")
    session.write_results(lost)
    assert load(session.path).title.startswith("not to be trusted")


MAPPINGS = Path(__file__).parents[2] / "research" / "measured_logs"


def test_measured_loops_are_taken_sample_by_sample(measured_data: Path, tmp_path: Path) -> None:
    """On an even grid, samples that jitter are smoothed, and the force of KDN at 5 bar is missed by a tenth more."""
    files = [measured_data / "zillen" / f"KDN_{bar}bar.csv" for bar in (1, 5)]
    session = prepare_identification(
        files[:1], "friction-rig", tmp_path, validate=files[1:], mapping=MAPPINGS / "zillen.toml"
    )
    for file, log in zip(files, (session.logs["KDN_1bar"], session.validation["KDN_5bar"]), strict=True):
        time, force = np.loadtxt(file, usecols=(0, 6), unpack=True)
        assert log.sizes["time"] == len(np.unique(time))
        assert set(log["force"].to_numpy()) <= set(force)


def test_a_measured_vessel_and_its_hyddown_description(measured_data: Path, tmp_path: Path) -> None:
    """Points read off two curves at times of their own: all are used, as research/measured_logs/vessel.py does."""
    log = measured_data / "vessel" / "Air_790kPa_21mm.csv"
    session = prepare_identification([log], log.with_suffix(".rig.yml"), tmp_path, mapping=MAPPINGS / "vessel.toml")
    found = session.fit(starts=2)
    rms = {one.validation: one.rms for one in found.qualities() if one.output == "pressure"}
    assert rms[False] < 2e3
    assert rms[True] < 1e3
    kept = session.write_results(found)
    assert session.path.name == "Air_790kPa_21mm-identified.toml"
    assert type(kept) is type(session.described)


def test_measured_runs_of_a_regulated_joint(measured_data: Path, tmp_path: Path) -> None:
    files = [measured_data / "affetto" / f"motion_data_00{i}.csv" for i in (0, 6)]
    session = prepare_identification(
        files[:1], "regulated-elbow", tmp_path, validate=files[1:], mapping=MAPPINGS / "affetto.toml"
    )
    assert session.blocks == ["valve", "gas", "motion"]
    assert list(session.validation) == ["motion_data_006"]
    assert np.diff(session.logs["motion_data_000"]["time"]) == pytest.approx(1.0 / 30.0, rel=1e-3)


def test_a_result_that_could_not_be_written_is_refused_before_the_search(tmp_path: Path) -> None:
    """A name of 95 letters is one; with "-identified" behind it it is too long for a description."""
    text = BENCH_LIBRARY.text("regulated-elbow")
    rig = tmp_path / f"{'e' * 95}.toml"
    rig.write_text(text.replace("regulated-elbow", "e" * 95), encoding="utf-8")
    time = np.arange(90) / 30.0
    swing = 0.5 * np.sin(3.0 * time)
    angle = -20.0 * np.cos(3.0 * time)
    signals = {"setpoint_a": 5 + swing, "setpoint_b": 5 - swing, "pressure_a": 5 + swing, "pressure_b": 5 - swing}
    table = {"time": time, "angle": angle} | signals
    log = written(tmp_path / "log.csv", table, **{name: f"{name} [bar]" for name in signals}, angle="angle [deg]")
    with pytest.raises(InputError, match=r"e-identified.toml: the result could not be written there \(name: "):
        prepare_identification([log], rig, tmp_path)


def test_figures_are_kept_and_said_where_no_description_holds_what_was_found(tmp_path: Path) -> None:
    session = prepare_identification([written(tmp_path / "log.csv", columns())], SMALL, tmp_path, blocks="friction")
    found = session.fit(starts=0)
    spoilt = replace(found, estimates=tuple(replace(one, value=np.inf, high=np.nan) for one in found.estimates))
    with pytest.raises(InputError):
        session.write_results(spoilt)
    kept = json.loads(session.figures_path.read_text(encoding="utf-8"))
    assert {one["value"] for one in kept["values"].values()} == {None}
    assert not session.path.exists()
    assert session.values(spoilt)[0].value == "inf N m"
