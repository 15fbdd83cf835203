from pathlib import Path

import numpy as np
import pytest
from recordings import changed, mapping, recorded, ticks, write_csv

from layflat.errors import InputError
from layflat.identify.logs import check, guess_mapping, read_log, read_mapping, write_mapping
from layflat.identify.logs.headers import meanings, signal_of, words_of
from layflat.machine import load


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
    assert signal_of(meanings(words_of(name))) == signal


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
    assert not check(log, load("paper-small-joint-fast"))
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
    assert guess.notes["small_theta"] == "angle by its name, but small.angle is angle.small already"


def test_a_log_that_says_nothing(tmp_path: Path) -> None:
    path = write_csv(tmp_path / "x.csv", {"a": np.arange(9.0), "b": np.ones(9)}, header=False)
    with pytest.raises(InputError, match="no column looks like a signal; write a mapping file by hand"):
        guess_mapping(path)
    falling = write_csv(tmp_path / "y.csv", {"q": -np.arange(9.0)})
    with pytest.raises(InputError, match="no column rises as a clock does"):
        guess_mapping(falling)
