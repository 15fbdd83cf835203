"""Logs as devices and spreadsheets write them, each against what it truly holds."""

import gzip
from pathlib import Path

import numpy as np
import pytest
from recordings import Array, ticks

from layflat.errors import InputError
from layflat.identify.logs import guess_mapping, read_log, read_table
from layflat.identify.logs.clocks import unwrap_counter
from layflat.identify.logs.guess import Guess

COUNT = 120
TIME = ticks(0.01, COUNT)
DEGREES = 40.0 * np.sin(5.0 * TIME)
BAR = 2.0 + 1.5 * np.sin(5.0 * TIME)


def written(folder: Path, header: str, *columns: Array | list[str]) -> Path:
    rows = (
        ",".join(cell if isinstance(cell, str) else f"{cell:.12g}" for cell in row)
        for row in zip(*columns, strict=True)
    )
    path = folder / "log.csv"
    path.write_text(header + "\n" + "\n".join(rows) + "\n", encoding="utf-8")
    return path


def guessed(folder: Path, header: str, *columns: Array | list[str]) -> tuple[Guess, dict[str, Array], Array]:
    """The guess of a log, and what its signals and its clock are read as."""
    path = written(folder, header, *columns)
    guess = guess_mapping(path, ["small"])
    log = read_log(path, guess.mapping, joints=["small"], as_recorded=True)
    return guess, {str(name): log[name].values.ravel() for name in log.data_vars}, log["time"].values


def number(value: float) -> str:
    return f"{value:.6f}".replace(".", ",")


@pytest.mark.parametrize("clocked", [True, False])
@pytest.mark.parametrize("size", [40, 600])
def test_all_segments_of_a_labview_file(tmp_path: Path, clocked: bool, size: int) -> None:
    text = (
        "LabVIEW Measurement\t\nSeparator\tTab\nDecimal_Separator\t,\nMulti_Headings\tYes\n"
        f"X_Columns\t{'One' if clocked else 'No'}\n***End_of_Header***\t\n\n"
    )
    time, angle = 0.01 * np.arange(3 * size), 40.0 * np.sin(0.05 * np.arange(3 * size))
    for first in range(0, 3 * size, size):
        text += (
            f"Channels\t1\t\t\nSamples\t{size}\t\t\nY_Unit_Label\tdeg\t\nX_Dimension\tTime\t\nX0\t{number(time[first])}\t\n"
            "Delta_X\t0,010000\t\n***End_of_Header***\t\t\nX_Value\tangle\tComment\n"
        )
        text += "".join(
            f"{number(time[i]) if clocked else ''}\t{number(angle[i])}\t\n" for i in range(first, first + size)
        )
    path = tmp_path / "log.lvm"
    path.write_text(text)
    columns = read_table(path).columns
    assert columns["X_Value"].values == pytest.approx(time)
    assert columns["angle"].values == pytest.approx(angle, abs=1e-6)


@pytest.mark.parametrize(
    "unit",
    [
        "[10 bar]",
        "(x 10 bar)",
        "(bar x 10)",
        "[bar*10]",
        "[10^5 Pa]",
        "[Pa x1000]",
        "/10 bar",
        "[mA]",
        "[counts]",
        "_dV",
    ],
)
def test_a_unit_with_a_number_or_of_another_quantity_is_asked_for(tmp_path: Path, unit: str) -> None:
    guess, read, _ = guessed(tmp_path, f"Time (s),Angle (deg),Pressure B {unit}", TIME, DEGREES, BAR)
    assert set(read) == {"angle"}
    assert "write a mapping with" in next(iter(guess.left.values()))


@pytest.mark.parametrize(("name", "scale"), [("angle_mdeg", 1e3), ("angle [mdeg]", 1e3), ("angle (Deg.)", 1.0)])
def test_prefixes_and_points_of_units_are_understood(tmp_path: Path, name: str, scale: float) -> None:
    _, read, _ = guessed(tmp_path, f"Time (s),{name}", TIME, scale * DEGREES)
    assert read["angle"] == pytest.approx(np.radians(DEGREES), rel=1e-9)


@pytest.mark.parametrize("name", ["valve DAC", "valve_counts", "valve PWM", "angle"])
def test_numbers_that_are_no_quantity_yet_are_asked_for(tmp_path: Path, name: str) -> None:
    guess, read, _ = guessed(tmp_path, f"Time (s),Pressure A (bar abs),{name}", TIME, BAR, 1000.0 * DEGREES)
    assert set(read) == {"pressure_a"}
    assert "write a mapping with" in guess.left[name]


@pytest.mark.parametrize("name", ["SecondsOfDay", "time of day", "Sec. since midnight", "Seconds of Day"])
def test_seconds_of_a_day_are_no_days_and_go_on_past_midnight(tmp_path: Path, name: str) -> None:
    _, _, time = guessed(tmp_path, f"{name},angle_deg", (86399.5 + TIME) % 86400.0, DEGREES)
    assert time - time[0] == pytest.approx(TIME, abs=1e-9)


def test_parts_of_a_day(tmp_path: Path) -> None:
    guess, _, time = guessed(tmp_path, "Time,angle_deg", 0.4 + TIME / 86400.0, DEGREES)
    assert time - time[0] == pytest.approx(TIME, abs=1e-5)
    assert "parts of a day: check it" in guess.notes[""]


@pytest.mark.parametrize("turn", [65536.0, 2.0**32, 86.4e6, 65.536, 86400.0])
def test_counters_and_days_that_start_anew_go_on(turn: float) -> None:
    step = 1e-2 if turn in {65.536, 86400.0} else 10.0
    stamps, anew = unwrap_counter((turn - 20.0 * step + ticks(step, 60)) % turn)
    assert np.diff(stamps) == pytest.approx(step, rel=1e-6)
    assert anew == [21]


def test_a_clock_in_a_unit_with_a_number(tmp_path: Path) -> None:
    path = written(tmp_path, "t [0.1ms],angle_deg", 1e4 * TIME, DEGREES)
    with pytest.raises(InputError, match=r'a mapping may say unit = "0.1 ms"'):
        guess_mapping(path)
    mapping = tmp_path / "m.toml"
    mapping.write_text(
        '[time]\ncolumn = "t [0.1ms]"\nunit = "0.1 ms"\n'
        '[[column]]\nfrom = "angle_deg"\nsignal = "angle"\nunit = "deg"\n'
    )
    assert read_log(path, mapping, as_recorded=True)["time"].values == pytest.approx(TIME)


@pytest.mark.parametrize(
    ("names", "signals"),
    [
        (("p1", "p2"), {"pressure_a", "pressure_b"}), (("p0", "p1"), {"pressure_a", "pressure_b"}),
        (("port 4 pressure", "port 2 pressure"), set()), (("p1", "p2", "p3"), set()), (("p1",), {"pressure_a"}),
    ],
)  # fmt: skip
def test_numbers_of_hoses_come_in_pairs(tmp_path: Path, names: tuple[str, ...], signals: set[str]) -> None:
    pressures = [BAR + i for i in range(len(names))]
    header = ",".join(f"{name} (bar abs)" for name in names)
    _, read, _ = guessed(tmp_path, f"Time (s),Angle (deg),{header}", TIME, DEGREES, *pressures)
    assert set(read) - {"angle"} == signals
    if len(signals) == 2:
        assert read["pressure_a"] == pytest.approx(1e5 * BAR)


@pytest.mark.parametrize("code", ["-9999", "9999", "-999", "99999.9", "9.91E+37"])
def test_codes_of_missing_samples_are_missing_and_said(tmp_path: Path, code: str) -> None:
    cells = [code if i in {40, 41, 90} else f"{value:.6f}" for i, value in enumerate(DEGREES)]
    guess, read, _ = guessed(tmp_path, "Time (s),Angle (deg)", TIME, cells)
    assert np.isfinite(read["angle"]).sum() == COUNT - 3
    assert "3 samples of" in guess.notes["Angle (deg)"]
    assert "are taken for missing" in guess.notes["Angle (deg)"]


def test_numbers_that_only_look_like_codes_stay(tmp_path: Path) -> None:
    values = np.linspace(990.0, 1010.0, COUNT)
    values[5] = 999.0
    _, read, _ = guessed(tmp_path, "Time (s),Pressure A (mbar abs)", TIME, values)
    assert read["pressure_a"] == pytest.approx(100.0 * values)


@pytest.mark.parametrize("glitch", ["inf", "35537000"])
def test_a_glitch_does_not_make_a_stated_unit_wrong(tmp_path: Path, glitch: str) -> None:
    cells = [glitch if i == 40 else f"{value:.6f}" for i, value in enumerate(DEGREES)]
    guess, _, _ = guessed(tmp_path, "Time (s),Angle (deg)", TIME, cells)
    assert "1 sample beyond what can be" in guess.notes["Angle (deg)"]


def test_a_row_of_types_names_nothing(tmp_path: Path) -> None:
    _, read, _ = guessed(tmp_path, "Time (s),Angle (deg)\ndouble,double", TIME, DEGREES)
    assert read["angle"] == pytest.approx(np.radians(DEGREES))


def test_a_clock_that_never_falls_goes_before_one_that_does(tmp_path: Path) -> None:
    seconds = [f"2024/03/01 10:00:{int(2.5 * i // 100):02d}" for i in range(COUNT)]
    milliseconds = ticks(25.0, COUNT) % 1000.0
    _, _, time = guessed(tmp_path, "Date&Time,ms,angle_deg", seconds, milliseconds, DEGREES)
    assert time - time[0] == pytest.approx(2.5 * TIME)


@pytest.mark.parametrize(
    ("content", "advice"),
    [
        (gzip.compress(b"t,a\n0,1\n", mtime=0), "is compressed by gzip; unpack it first"),
        (b"PK\x03\x04" + bytes(40), "save its sheet as CSV"),
        (b'{"time": 0.0, "angle": 1.0}\n{"time": 0.1, "angle": 1.0}\n', "holds JSON; write it as CSV"),
        (b'[{"time": 0.0, "angle": 1.0}]', "holds JSON; write it as CSV"),
        (b"<!DOCTYPE html>\n<table></table>", "holds a page of HTML; write its table as CSV"),
        (b"\n<?xml version='1.0'?><log/>", "holds XML; write its table as CSV"),
    ],
)
def test_files_without_a_table_say_what_would_do(content: bytes, advice: str, tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    path.write_bytes(content)
    with pytest.raises(InputError, match=advice):
        read_table(path)


@pytest.mark.parametrize("order", ["reversed", "shuffled"])
def test_rows_out_of_order_are_to_be_ordered(order: str, tmp_path: Path) -> None:
    rows = np.arange(COUNT)[::-1] if order == "reversed" else np.random.default_rng(0).permutation(COUNT)
    with pytest.raises(InputError, match="order the rows by it"):
        guessed(tmp_path, "time [s],angle [deg]", TIME[rows], DEGREES[rows])
