from pathlib import Path

import numpy as np
import pytest

from layflat.errors import InputError
from layflat.identify.logs import find_issues, guess_mapping, read_log, read_mapping, write_mapping
from layflat.identify.logs.mapping import parse_mapping
from layflat.identify.logs.table import split_words
from layflat.identify.logs.vocabulary import signal_for_roles, word_roles
from layflat.machine import load
from tests.identify.logs.recordings import changed, mapping, recorded, ticks, write_csv


@pytest.mark.parametrize(
    ("name", "signal"),
    [
        ("pA", "pressure_a"), ("p_b", "pressure_b"), ("rpa", "pressure_a"), ("Pressure B", "pressure_b"),
        ("/rig/hose_a.fluid_pressure", "pressure_a"), ("dp", "measured_pressure"),
        ("diff_pressure", "measured_pressure"),
        ("theta", "angle"), ("Encoder", "angle"), ("q", "angle"), ("q_des", "demand"), ("qdes", "demand"),
        ("angle_ref", "demand"), ("demand", "demand"), ("p_ref_a", "setpoint_a"),
        ("ca", "setpoint_a"), ("cmd_pressure_b", "setpoint_b"), ("supply_pressure", "supply"), ("Psup", "supply"),
        ("valve", "voltage"), ("u", "voltage"), ("cmd_voltage", "voltage"), ("tau", "torque"),
        ("load_cell_force", "force"),
        ("brake", "brake"), ("payload", "payload"), ("temp_gas", "temperature"), ("gas_pressure", "pressure"),
        ("laser", "position"), ("colour", None), ("battery", None),
    ],
)  # fmt: skip
def test_what_names_mean(name: str, signal: str | None) -> None:
    assert signal_for_roles(word_roles(split_words(name))) == signal


def test_a_guess_from_units_in_headers_reads_as_the_right_mapping_would(tmp_path: Path) -> None:
    columns = recorded()
    named = {"t [ms]": "time_ms", "theta_deg": "theta", "p_A [bar gauge]": "pA", "p_B (barg)": "pB", "valve_V": "valve",
             "ref": "ref", "comment": "ref"}  # fmt: skip
    path = write_csv(tmp_path / "rig.csv", {name: columns[old] for name, old in named.items()})
    right = read_log(write_csv(tmp_path / "right.csv", columns), mapping(), joints=["small"])
    guess = guess_mapping(path, ["small"])
    log = read_log(path, read_mapping(write_mapping(guess.mapping, tmp_path / "m.toml", guess.notes)), joints=["small"])
    for name in right.data_vars:
        assert log[name].values == pytest.approx(right[name].values, rel=1e-12), name
    assert not find_issues(log, load("paper-small-joint-fast"))
    assert "its name says nothing that is known here" in guess.notes["comment"]
    assert guess.notes["theta_deg"] == "angle by its name; unit as in the header"


@pytest.mark.parametrize(("factor", "unit"), [(1.0, "bar"), (14.5038, "psi"), (100.0, "kPa"), (1e5, "Pa")])
def test_units_from_the_range_of_values(tmp_path: Path, factor: float, unit: str) -> None:
    columns = changed(recorded(), "pA", lambda x: factor * (x - x.min()))
    guess = guess_mapping(write_csv(tmp_path / "rig.csv", columns), ["small"])
    entry = next(entry for entry in guess.mapping.column if entry.signal == "pressure_a")
    assert (entry.unit, entry.gauge) == (unit, True)
    assert "check it" in guess.notes["pA"]
    angle = next(entry for entry in guess.mapping.column if entry.signal == "angle")
    assert angle.unit == "deg"
    radians = guess_mapping(write_csv(tmp_path / "rad.csv", changed(columns, "theta", np.radians)), ["small"])
    assert next(entry for entry in radians.mapping.column if entry.signal == "angle").unit == "rad"


@pytest.mark.parametrize(("period", "unit"), [(0.005, "s"), (5.0, "ms"), (5e3, "us"), (5e6, "ns")])
def test_the_clock_and_its_unit(tmp_path: Path, period: float, unit: str) -> None:
    columns = {"q": np.sin(np.arange(50.0)), "count": np.arange(50.0) % 7, "stamp": ticks(period, 50)}
    time = guess_mapping(write_csv(tmp_path / "x.csv", columns)).mapping.time
    assert time is not None
    assert (time.column, time.unit) == ("stamp", unit)


def test_numbered_groups_go_to_the_joints_that_move(tmp_path: Path) -> None:
    time = ticks(0.01, 200)
    columns = {"t": time}
    for i, swing in enumerate((0.01, 1.0, 0.02, 0.8)):
        columns |= {f"q{i}": swing * np.sin(time), f"pa{i}": 2.0 + swing * np.sin(time), f"dq{i}": np.cos(time)}
    path = write_csv(tmp_path / "x.csv", columns)
    guess = guess_mapping(path, ["large", "small"])
    assert {entry.columns[0]: entry.joint for entry in guess.mapping.column} == {
        "q1": "large", "pa1": "large", "q3": "small", "pa3": "small",
    }  # fmt: skip
    assert guess.notes["q0"] == "angle by its name, but of none of the joints"
    assert guess.notes["dq1"] == "a rate, which follows from the rest"
    assert {entry.joint for entry in guess_mapping(path).mapping.column} == {f"joint{i}" for i in range(4)}


def test_joints_by_name_and_what_stands_there_twice(tmp_path: Path) -> None:
    time = ticks(0.01, 100)
    columns = {"t": time, "Large angle": np.sin(time), "small.angle": np.cos(time), "small_theta": np.cos(time)}
    guess = guess_mapping(write_csv(tmp_path / "x.csv", columns), ["large", "small"])
    assert {e.columns[0]: e.joint for e in guess.mapping.column} == {"Large angle": "large", "small.angle": "small"}
    assert (
        guess.notes["small_theta"] == "angle by its name, but small.angle is angle.small already, with the same values"
    )


def test_a_log_that_says_nothing(tmp_path: Path) -> None:
    path = write_csv(tmp_path / "x.csv", {"a": 0.1 * np.arange(9.0), "b": np.ones(9)}, header=False)
    with pytest.raises(
        InputError,
        match=r"no column looks like a signal: the table has no header; give it a header, .* or write a mapping",
    ):
        guess_mapping(path)
    falling = write_csv(tmp_path / "y.csv", {"q": -np.arange(9.0)})
    with pytest.raises(InputError, match="no column rises as a clock does"):
        guess_mapping(falling)


def text_log(folder: Path, header: str, *columns: str) -> Path:
    """A log of 60 samples: columns as expressions of i."""
    rows = (",".join(str(eval(column, {"i": i, "sin": np.sin})) for column in columns) for i in range(60))
    path = folder / "log.csv"
    path.write_text(header + "\n" + "\n".join(rows) + "\n", encoding="utf-8")
    return path


def test_own_names_make_no_other_column_vanish(tmp_path: Path) -> None:
    columns = ("i / 100", "30 * sin(i / 5)", "250 + i", "240 + i", "5")
    for header in (
        "time,angle,p_a,p_b,u",
        "time_s,angle_deg,pA_kPa,pB_kPa,valve_V",
        "time,theta,pressure_a,p_b,voltage",
    ):
        guess = guess_mapping(text_log(tmp_path, header, *columns), ["small"])
        found = {entry.signal: entry.unit for entry in guess.mapping.column}
        assert found == {"angle": "deg", "pressure_a": "kPa", "pressure_b": "kPa", "voltage": "V"}, header
        assert not guess.ignored


def test_a_clock_is_never_a_column_of_another_unit(tmp_path: Path) -> None:
    path = text_log(tmp_path, "Zeit,pressure [bar],angle [deg]", "f'gestern {i}'", "1 + i / 100", "sin(i)")
    with pytest.raises(
        InputError, match="no column rises as a clock does: column 'Zeit' holds words, such as 'gestern 0'"
    ):
        guess_mapping(path, ["small"])
    guess = guess_mapping(path, ["small"], "5 ms")
    assert "Zeit" in guess.ignored
    mapping = write_mapping(guess.mapping, tmp_path / "m.toml")
    assert read_log(path, mapping).attrs["log_period"] == pytest.approx(0.005)
    with pytest.raises(InputError, match=r"column 'Zeit' of log.csv holds words, such as 'gestern 0'; write numbers"):
        read_log(path, parse_mapping({"time": {"period": "5 ms"}, "column": [
            {"from": "Zeit", "signal": "force", "unit": "N"}]}))  # fmt: skip


def test_a_stated_unit_that_can_not_be_is_not_used(tmp_path: Path) -> None:
    path = text_log(tmp_path, "t [s],angle [rad],p_a [mPa],T [K],p_b [V]", "i / 100", "i", "0.2", "20", "2 + i / 50")
    with pytest.raises(InputError, match="no column looks like a signal") as caught:
        guess_mapping(path, ["small"])
    for words in (
        "59 rad by its stated unit 'rad', which can't be",
        "'mPa', which can't be",
        "'V' is not a unit of it",
    ):
        assert words in str(caught.value)


def test_two_columns_for_one_signal_are_asked_about_unless_one_is_ahead(tmp_path: Path) -> None:
    header = "t [s],angle_filt [deg],angle_raw [deg],p_a [kPa],Druck A [kPa],p,p"
    path = text_log(tmp_path, header, "i / 100", "sin(i)", "2 * sin(i)", "200 + i", "201 + i", "1", "2")
    guess = guess_mapping(path, ["small"])
    assert [entry.columns for entry in guess.mapping.column] == [("angle_raw [deg]",)]
    assert "p_a [kPa] and Druck A [kPa] may all be pressure_a.small: name one" in guess.ignored["p_a [kPa]"]
    assert "p (column 6) and p (column 7) may all be pressure" in guess.ignored["p (column 7)"]


def test_a_clock_with_a_missing_cell(tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    path.write_text("millis,theta_deg\n0,1\n10,2\n20,3\n,4\n40,5\n50,6\n")
    guess = guess_mapping(path, ["small"])
    assert guess.mapping.time is not None
    assert guess.mapping.time.unit == "ms"
    texts = [issue.text for issue in find_issues(read_log(path, guess.mapping, joints=["small"]))]
    assert "1 sample without stamp, first sample 4, left out" in texts


def test_a_clock_in_days_is_told_with_the_right_factor(tmp_path: Path) -> None:
    path = text_log(tmp_path, "time,angle [deg]", "i * 0.005 / 86400", "sin(i)")
    plain = {"time": {"column": "time", "unit": "s"}, "column": [
        {"from": "angle [deg]", "signal": "angle", "unit": "deg", "joint": "small"}]}  # fmt: skip
    issues = find_issues(read_log(path, parse_mapping(plain), joints=["small"]), load("paper-small-joint-fast"))
    assert any("a factor of 86400 would fit" in issue.right for issue in issues)


def test_what_an_own_name_can_not_be_is_no_dead_end(tmp_path: Path) -> None:
    guess = guess_mapping(text_log(tmp_path, "t,brake [%],angle [%]", "i / 100", "i", "i"), ["small"])
    assert [entry.signal for entry in guess.mapping.column] == ["brake"]
    assert "'%' is not a unit of it" in guess.ignored["angle [%]"]
    falling = text_log(tmp_path, "time [s],angle [deg]", "-i / 100", "sin(i)")
    with pytest.raises(InputError, match=r"column 'time \[s\]' falls 59 times, first at sample 2"):
        guess_mapping(falling, ["small"])


def test_set_points_beside_what_was_measured(tmp_path: Path) -> None:
    header = "t [s],p_set_A [bar(g)],p_ist_A [bar(g)],Sollwinkel [deg],Istwinkel [deg]"
    guess = guess_mapping(text_log(tmp_path, header, "i / 100", "2", "sin(i)", "10", "sin(i)"), ["small"])
    assert [entry.signal for entry in guess.mapping.column] == ["setpoint_a", "pressure_a", "demand", "angle"]


def test_points_that_may_be_thousands_are_said(tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    path.write_text("t [s];p_a [mbar]\n" + "".join(f"{i};{2 + i % 3}.{500 + i}\n" for i in range(40)))
    guess = guess_mapping(path, ["small"])
    assert (
        "the point in '2.500' is taken for the decimal sign, which nothing proves: check it"
        in guess.notes["p_a [mbar]"]
    )
