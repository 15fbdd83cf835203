"""Tables of text as people and devices write them."""

from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from layflat.errors import LayflatError
from layflat.identify.logs import find_issues, guess_mapping, read_log, read_mapping, read_table, write_mapping
from layflat.identify.logs.table import parse_header, split_words
from layflat.identify.logs.text.numbers import find_decimal_sign, parse_number, read_numbers
from layflat.identify.logs.text.stamps import read_stamps
from layflat.identify.logs.vocabulary import signal_for_roles, word_roles
from tests.identify.logs.recordings import Array

PRESSURE_UNITS = {
    "kPa": 1e3, "kPa (g)": 1e3, "bar": 1e5, "mbar(g)": 100.0, "bar abs": 1e5, "psig": 6894.757293168,
    "kgf/cm2": 98066.5,
    "atm": 101325.0, "Torr": 133.32236842105263, "mmHg": 133.322387415, "Pa": 1.0, "MPa": 1e6, "N/mm²": 1e6,
    "inHg": 3386.38864034,
}  # fmt: skip
ANGLE_UNITS = {"deg": np.pi / 180.0, "°": np.pi / 180.0, "rad": 1.0, "Grad": np.pi / 180.0}
GAUGE = {"kPa (g)", "mbar(g)", "psig"}


def written(value: float, decimal: str, thousands: str, minus: str) -> str:
    text = f"{value:,.4f}" if thousands else f"{value:.4f}"
    return text.replace(",", "T").replace(".", decimal).replace("T", thousands).replace("-", minus)


@st.composite
def written_tables(draw: st.DrawFn) -> tuple[bytes, Array, Array, Array]:
    """Return a file, and times in s, angles in rad and absolute pressures in Pa as they stand in it."""
    decimal = draw(st.sampled_from([".", ","]))
    delimiter = draw(st.sampled_from([";", "\t", "|"] + ([",", " "] if decimal == "." else [])))
    thousands = draw(st.sampled_from(["", "'", "\u202f", "\u2019"] + ([","] if decimal == "." != delimiter else [])
                                     + (["."] if decimal == "," else [])))  # fmt: skip
    if (delimiter, thousands) in {(",", ","), (" ", "\u202f")}:
        thousands = ""
    encoding = draw(st.sampled_from(["utf-8", "utf-8-sig", "utf-16", "cp1252"]))
    minus = "-" if encoding == "cp1252" else draw(st.sampled_from(["-", "\u2212"]))
    thousands = "" if encoding == "cp1252" and thousands == "\u202f" else thousands
    pressure_unit = draw(st.sampled_from(sorted(PRESSURE_UNITS)))
    angle_unit, hose = draw(st.sampled_from(sorted(ANGLE_UNITS))), draw(st.sampled_from("AB"))
    names = [draw(st.sampled_from(["t", "Zeit", "Time"])), draw(st.sampled_from(["theta", "Winkel", "angle"])),
             draw(st.sampled_from([f"p_{hose}", f"Druck {hose}", f"pressure {hose}"]))]  # fmt: skip
    units = ["s", angle_unit, pressure_unit]
    size = draw(st.integers(12, 40))
    rng = np.random.default_rng(draw(st.integers(0, 10**6)))
    time = np.round(0.01 * np.arange(size), 4)
    angle = np.round(rng.uniform(-0.5, 0.5, size) * (1.0 if angle_unit == "rad" else 57.0), 4)
    pressure = np.round((1.5e5 + 2e5 * rng.uniform(0.0, 1.0, size)) / PRESSURE_UNITS[pressure_unit], 4)
    rows = [[written(v, decimal, thousands, minus) for v in row] for row in zip(time, angle, pressure, strict=True)]
    in_row = draw(st.booleans()) and delimiter != " "
    names = names if in_row else [f"{name} [{unit}]" for name, unit in zip(names, units, strict=True)]
    if delimiter == " ":
        names = [name.replace(" ", "_") for name in names]
    head = [["A log of mine"], ["by me", "2"]][: draw(st.integers(0, 2))] if delimiter != " " else []
    lines = [*head, names, *([units] if in_row else []), *rows]
    text = draw(st.sampled_from(["", "# a comment\n"])) + "".join(delimiter.join(line) + "\n" for line in lines)
    absolute = pressure * PRESSURE_UNITS[pressure_unit] + (101325.0 if pressure_unit in GAUGE else 0.0)
    return text.encode(encoding), time, angle * ANGLE_UNITS[angle_unit], absolute


@settings(max_examples=60, deadline=None)
@given(table=written_tables())
def test_a_table_gives_its_values_however_it_is_written(table: tuple[bytes, Array, Array, Array]) -> None:
    content, time, angle, pressure = table
    with TemporaryDirectory() as folder:
        path = Path(folder) / "log.csv"
        path.write_bytes(content)
        guess = guess_mapping(path, ["small"])
        log = read_log(path, guess.mapping, joints=["small"])
    hose = next(entry.signal for entry in guess.mapping.column if entry.signal.startswith("pressure"))
    assert log["time"].values == pytest.approx(time, abs=1e-9)
    assert log["angle"].values[:, 0] == pytest.approx(angle, abs=1e-9)
    entry = next(entry for entry in guess.mapping.column if entry.signal == hose)
    stated_zero = "header" in guess.notes[entry.columns[0]].rsplit(";", 1)[-1]
    shift = 101325.0 if entry.gauge and not stated_zero else 0.0
    assert log[hose].values[:, 0] - shift == pytest.approx(pressure, rel=1e-6)


@settings(max_examples=150, deadline=None)
@given(content=st.one_of(
    st.text("0123456789,;. \t-:/\n\"'abtpz[]()#|eE%", max_size=300).map(lambda text: text.encode()),
    st.lists(st.lists(st.sampled_from(["1", "2,5", "x", "", "10:12:13", "1.1.2024", "3 kPa", "nan", '"', "[bar]"]),
                      max_size=5), max_size=15).map(lambda rows: "\n".join(";".join(row) for row in rows).encode()),
    st.binary(max_size=200),
))  # fmt: skip
def test_nothing_but_our_errors_comes_of_any_text(content: bytes) -> None:
    told = ""
    with TemporaryDirectory() as folder:
        path = Path(folder) / "log.csv"
        path.write_bytes(content)
        try:
            guess = guess_mapping(path, ["small"])
            find_issues(
                read_log(path, read_mapping(write_mapping(guess.mapping, Path(folder) / "m.toml", guess.notes)))
            )
        except LayflatError as error:
            told = str(error)
    assert "\n" not in told


@pytest.mark.parametrize(
    ("header", "signal", "unit", "gauge"),
    [
        ("p_b [kPa (g)]", "pressure_b", "kPa", True), ("pressure_b_kPa_raw", "pressure_b", "kPa", None),
        ("pBkPa", "pressure_b", "kPa", None), ("p_A_bar", "pressure_a", "bar", None),
        ("p_bar_A", "pressure_a", "bar", None),
        ("p_a_bar_a", "pressure_a", "bar", False), ("p_B (barg)", "pressure_b", "bar", True),
        ("p_a [kgf/cm2]", "pressure_a", "kgf/cm^2", None), ("p_a [mbar(g)]", "pressure_a", "mbar", True),
        ("p_rel_a [bar]", "pressure_a", "bar", True), ("Druck Kammer A [barü]", "pressure_a", "bar", True),
        ("p_A / bar", "pressure_a", "bar", None), ("pressure a abs (bar)", "pressure_a", "bar", False),
        ("/rig/pA", "pressure_a", "", None), ("hose A pressure (psia)", "pressure_a", "psi", False),
        ("Winkel [Grad]", "angle", "deg", None), ("valve_V", "voltage", "V", None),
        ("Torque[Nm]", "torque", "N m", None),
        ("Pressure A (g)", "pressure_a", "", True), ("temp_C", "temperature", "degC", None),
        ("p_a [mPa]", "pressure_a", "mPa", None),
    ],
)  # fmt: skip
def test_units_and_hoses_come_from_whole_words(header: str, signal: str, unit: str, gauge: bool | None) -> None:
    read = parse_header(header)
    assert (read.unit, read.gauge, signal_for_roles(word_roles(split_words(read.stem)))) == (unit, gauge, signal)


@pytest.mark.parametrize("header", ["p_a [counts]", "Winkel [grad]", "p_a [raw]", "p_a [Furlong]"])
def test_a_unit_that_is_not_understood_is_said_and_nothing_is_guessed(header: str, tmp_path: Path) -> None:
    assert parse_header(header).unknown == header[header.index("[") + 1 : -1]
    path = tmp_path / "x.csv"
    path.write_text(f"t [s],angle [deg],{header}\n" + "".join(f"{i / 10},{i},{i * 100}\n" for i in range(20)))
    guess = guess_mapping(path, ["small"])
    assert [entry.signal for entry in guess.mapping.column] == ["angle"]
    assert "is not known: write a mapping with a unit" in guess.ignored[header]


@pytest.mark.parametrize(
    ("cells", "sign"),
    [
        (["0.5", "0.25", "7"], "."),
        (["7", "0,5", "1.234"], ","),
        (["1.234", "7", "", "x"], None),
        (["1.234.567", "7"], ","),
        (["0.5", "1.234.567"], None),
        (["0,5", "1,234,567"], None),
        (["0.5", "8", "0,5"], None),
        (["1.234,5"], ","),
        (["np.float64(0.5)", "1,234"], "."),
    ],
)
def test_one_cell_that_reads_otherwise_proves_a_decimal_sign(cells: list[str], sign: str | None) -> None:
    assert find_decimal_sign(cells) == find_decimal_sign(cells[::-1]) == sign


@pytest.mark.parametrize(
    ("text", "point", "comma"),
    [
        ("1.5", 1.5, None), ("1,5", None, 1.5), ("1.234", 1.234, 1234.0), ("0.234", 0.234, None),
        ("1'234.5", 1234.5, None),
        ("1.234,5", None, 1234.5), ("1 234", 1234.0, 1234.0), ("1_0", None, None), ("1,2,3", None, None),
        ("-3", -3.0, -3.0),
        ("1.5D+01", 15.0, None), ("0x10", None, None), ("", None, None), (".", None, None),
        ("1.234.567", None, 1234567.0),
    ],
)  # fmt: skip
def test_numbers_with_either_decimal_sign(text: str, point: float | None, comma: float | None) -> None:
    assert (parse_number(text, "."), parse_number(text, ",")) == (point, comma)


def test_a_doubtful_sign_follows_the_rest_or_is_said() -> None:
    assert read_numbers(["1.234", "2.345"], ",", "x").values.tolist() == [1234.0, 2345.0]
    alone = read_numbers(["1,234", "2,345"], None, "x")
    assert alone.values.tolist() == [1.234, 2.345]
    assert alone.doubtful == "1,234"
    assert read_numbers(["1,234", "0,345"], None, "x").doubtful == ""
    with pytest.raises(LayflatError, match=r"has a decimal comma in '1,5' and a decimal point in '2.5'"):
        read_numbers(["1,5", "2.5"], None, "x")


@pytest.mark.parametrize(
    ("cells", "seconds"),
    [
        (["11.03.2024 10:12:13,00", "11.03.2024 10:12:13,25"], [0.0, 0.25]),
        (["3/4/2024 11:59:59 PM", "3/5/2024 12:00:00 AM"], [0.0, 1.0]),
        (["2024-03-11T10:12:13.1+01:00", "2024-03-11T09:12:13.3Z"], [0.0, 0.2]),
        (["11-Mar-2024 10:12:13", "11-Mar-2024 10:12:14"], [0.0, 1.0]),
        (["20240311_101213", "20240311_101214"], [0.0, 1.0]),
        (["23:59:59.5", "00:00:00.5"], [0.0, 1.0]),
        (["59:59.5", "00:00.5"], [0.0, 1.0]),
        (["10:12:13:100", "10:12:13:350"], [0.0, 0.25]),
        (["0 days 00:00:01.5", "0 days 00:00:02"], [0.0, 0.5]),
        (["10:12:13.123456789", "10:12:13.123457789"], [0.0, 1e-6]),
    ],
)
def test_dates_and_clock_times(cells: list[str], seconds: list[float]) -> None:
    stamps = read_stamps(cells)
    assert stamps is not None
    assert stamps.seconds == pytest.approx(seconds, abs=1e-12)


@pytest.mark.parametrize(
    "cells", [["10:12", "10:13"], ["31.02.2024", "1.3.2024"], ["Foo 3, 2024", "Foo 4, 2024"], ["x", "y"]]
)
def test_what_is_no_clear_time_is_none(cells: list[str]) -> None:
    assert read_stamps(cells) is None


def test_dates_whose_order_is_open_are_said() -> None:
    stamps = read_stamps(["01/02/2024", "02/02/2024", "03/02/2024"])
    assert stamps is not None
    assert stamps.seconds.tolist() == [0.0, 86400.0, 172800.0]
    assert "are read as day/month" in stamps.note


ROWS = [(0.01 * i, 20.0 * np.sin(0.1 * i), 250.0 + i) for i in range(120)]
FILES = {
    "serial plotter": "boot\n" + "".join(f"t:{t:.2f},angle:{a:.3f},pA:{p:.1f}\n" for t, a, p in ROWS),
    "units in cells": "time,angle,pA\n" + "".join(f"{t:.2f} sec,{a:.3f}°,{p:.1f} kPa\n" for t, a, p in ROWS),
    "serial monitor": "10:12:12.900 -> t_s,angle,pA\n"
    + "".join(f"10:12:13.{i:03d} -> {t:.2f},{a:.3f},{p:.1f}\n" for i, (t, a, p) in enumerate(ROWS)),
    "ROS": "header.stamp.sec,header.stamp.nanosec,frame_id,angle,pA\n"
    + "".join(f"{1700000000 + i // 100},{i % 100 * 10**7},x,{a:.3f},{p:.1f}\n" for i, (_, a, p) in enumerate(ROWS)),
    "PlotJuggler": "__time,/rig/angle,/rig/pA\n" + "".join(f"{1.7e9 + t:.6f},{a:.3f},{p:.1f}\n" for t, a, p in ROWS),
    "PLC": "Date,Time,Millitm,angle,pA\n"
    + "".join(f"03/11/2024,10:12:{13 + i // 100},{i % 100 * 10},{a:.3f},{p:.1f}\n" for i, (_, a, p) in enumerate(ROWS)),
    "spreadsheet": "Stamp;angle;pA\n"
    + "".join(f"{45362 + t / 86400:.12f};{a:.3f};{p:.1f}\n".replace(".", ",") for t, a, p in ROWS),
    "TOA5": '"TOA5","x","y"\n"TIMESTAMP","angle","pA"\n"TS","deg","kPa"\n"","Smp","Avg"\n'
    + "".join(f'"2024-03-11 10:12:{13 + t:05.2f}",{a:.3f},{p:.1f}\n' for t, a, p in ROWS),
    "LabVIEW": "LabVIEW Measurement\nSeparator\tTab\nDecimal_Separator\t,\nX_Columns\tNo\n***End_of_Header***\n\n"
    "Channels\t2\n"
    "X_Dimension\tTime\tTime\nX0\t0\t0\nDelta_X\t0,01\t0,01\n***End_of_Header***\nX_Value\tangle\tpA\tComment\n"
    + "".join(f"\t{a:.3f}\t{p:.1f}\n".replace(".", ",") for _, a, p in ROWS),
    "commented header": "# t_s angle pA\n" + "".join(f"{t:.2f}   {a:.3f} {p:.1f}\n" for t, a, p in ROWS),
    "markdown": "| t_s | angle | pA |\n|---|---|---|\n"
    + "".join(f"| {t:.2f} | {a:.3f} | {p:.1f} |\n" for t, a, p in ROWS),
    "counter of 32 bits": "micros,angle,pA\n"
    + "".join(f"{(2**32 - 300000 + i * 10000) % 2**32},{a:.3f},{p:.1f}\n" for i, (_, a, p) in enumerate(ROWS)),
}


@pytest.mark.parametrize("kind", FILES)
def test_files_of_many_devices_are_one_log(kind: str, tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    path.write_text(FILES[kind], encoding="utf-8")
    guess = guess_mapping(path, ["small"])
    log = read_log(path, guess.mapping, joints=["small"])
    assert log["time"].values == pytest.approx([t for t, _, _ in ROWS], abs=1e-5)
    assert np.degrees(log["angle"].values[:, 0]) == pytest.approx([a for _, a, _ in ROWS], abs=1e-2)
    assert log["pressure_a"].values[:, 0] == pytest.approx([1e3 * p for _, _, p in ROWS], rel=1e-3)


def test_cells_that_are_no_numbers_are_named_and_rows_that_are_broken(tmp_path: Path) -> None:
    rows = [f"{t:.2f},{a:.2f},{'OVER' if i in (7, 9) else p}" for i, (t, a, p) in enumerate(ROWS)]
    path = tmp_path / "log.csv"
    path.write_text("t [s],angle [deg],pA [kPa]\n" + "\n".join(rows) + "\n1.2,3")
    table = read_table(path)
    assert table.columns["pA [kPa]"].notes == ("2 cells hold no number and are missing, the first 'OVER' in sample 8",)
    assert table.notes == (
        "1 row of another length left out, the first: line 122 ('1.2,3') has 2 values in place of 3",
    )
    log = read_log(path, guess_mapping(table, ["small"]).mapping, joints=["small"])
    told = [issue.text for issue in find_issues(log)]
    assert any("column pA [kPa]: 2 cells hold no number" in text for text in told)
    assert any("1 row of another length left out" in text for text in told)
