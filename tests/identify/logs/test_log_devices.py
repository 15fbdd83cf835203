"""Logs as devices and spreadsheets write them, each against what it truly holds."""

import gzip
from pathlib import Path

import numpy as np
import pytest

from layflat.errors import InputError
from layflat.identify.logs import guess_mapping, read_log, read_table
from layflat.identify.logs.clocks import unwrap_counter
from layflat.identify.logs.guess import MappingGuess
from tests.identify.logs.recordings import Array, ticks

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


def guessed(folder: Path, header: str, *columns: Array | list[str]) -> tuple[MappingGuess, dict[str, Array], Array]:
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
    assert "write a mapping with" in next(iter(guess.ignored.values()))


@pytest.mark.parametrize(("name", "scale"), [("angle_mdeg", 1e3), ("angle [mdeg]", 1e3), ("angle (Deg.)", 1.0)])
def test_prefixes_and_points_of_units_are_understood(tmp_path: Path, name: str, scale: float) -> None:
    _, read, _ = guessed(tmp_path, f"Time (s),{name}", TIME, scale * DEGREES)
    assert read["angle"] == pytest.approx(np.radians(DEGREES), rel=1e-9)


@pytest.mark.parametrize("name", ["valve DAC", "valve_counts", "valve PWM", "angle"])
def test_numbers_that_are_no_quantity_yet_are_asked_for(tmp_path: Path, name: str) -> None:
    guess, read, _ = guessed(tmp_path, f"Time (s),Pressure A (bar abs),{name}", TIME, BAR, 1000.0 * DEGREES)
    assert set(read) == {"pressure_a"}
    assert "write a mapping with" in guess.ignored[name]


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


@pytest.mark.parametrize("unit", ["0.1ms", "x 0.1 ms", "100 us"])
def test_a_clock_in_a_unit_with_a_number(tmp_path: Path, unit: str) -> None:
    _, _, time = guessed(tmp_path, f"t [{unit}],angle_deg", 1e4 * TIME, DEGREES)
    assert time == pytest.approx(TIME)


def test_a_clock_in_a_fraction_of_a_unit_is_asked_for(tmp_path: Path) -> None:
    path = written(tmp_path, "t [ms/10],angle_deg", 1e4 * TIME, DEGREES)
    with pytest.raises(InputError, match=r'a mapping may say unit = "0.1 ms"'):
        guess_mapping(path)
    mapping = tmp_path / "m.toml"
    mapping.write_text(
        '[time]\ncolumn = "t [ms/10]"\nunit = "0.1 ms"\n'
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


def thousands(sign: str) -> str:
    rows = (
        f"{10 * i:,};{int(1e3 * d):,};{int(1e5 * b):,}".replace(",", sign)
        for i, (d, b) in enumerate(zip(DEGREES, BAR, strict=True))
    )
    return "Time [ms];Angle [mdeg];PA [Pa abs]\n" + "\n".join(rows) + "\n"


@pytest.mark.parametrize("sign", [".", ",", "'", " "])
def test_whole_numbers_with_thousands_are_no_fractions(tmp_path: Path, sign: str) -> None:
    path = tmp_path / "log.csv"
    path.write_text(thousands(sign))
    columns = read_table(path).columns
    assert columns["Time [ms]"].values == pytest.approx(10.0 * np.arange(COUNT))
    assert columns["PA [Pa abs]"].values == pytest.approx(np.trunc(1e5 * BAR))


def test_fractions_with_three_digits_stay_fractions(tmp_path: Path) -> None:
    rows = (f"{t:.2f};{a:.3f};{0 if i % 9 == 0 else format(b, '.3f')}" for i, (t, a, b) in enumerate(
        zip(TIME, DEGREES, BAR, strict=True)))  # fmt: skip
    path = tmp_path / "log.csv"
    path.write_text("time_s;angle_deg;p_bar\n" + "\n".join(rows) + "\n")
    assert read_table(path).columns["angle_deg"].values == pytest.approx(DEGREES, abs=1e-3)
    assert read_table(path).columns["p_bar"].values.max() == pytest.approx(BAR.max(), abs=1e-3)


@pytest.mark.parametrize(
    ("name", "unit", "gauge"),
    [
        ("Presión A (kPa man.)", "kPa", True), ("Pressure A (mbar sensor)", "mbar", None),
        ("pA bar(rel.)", "bar", True), ("p A (0-10 bar)", "bar", None), ("p_A [bar Überdruck]", "bar", True),
        ("pressureAKPa", "kPa", None), ("hosePressureABar", "bar", None), ("p_A [\u33aa]", "kPa", None),
        ("Tryck A (kPa)", "kPa", None), ("Давление A, кПа", "kPa", None), ("pₐ [bar]", "bar", None),
    ],
)  # fmt: skip
def test_units_that_other_words_stand_beside(tmp_path: Path, name: str, unit: str, gauge: bool | None) -> None:
    size = {"kPa": 100.0, "mbar": 1e3, "bar": 1.0}[unit]
    path = tmp_path / "log.csv"
    rows = (f"{t:.2f};{size * b:.6g}" for t, b in zip(TIME, BAR, strict=True))
    path.write_text(f"time_s;{name}\n" + "\n".join(rows) + "\n", encoding="utf-8")
    column = read_table(path).columns[name]
    assert (column.header.unit, column.header.gauge) == (unit, gauge)
    assert [entry.signal for entry in guess_mapping(path).mapping.column] == ["pressure_a"]


@pytest.mark.parametrize(
    ("names", "signals"),
    [
        (("position [deg]", "Druck A [bar]"), ["angle", "pressure_a"]),
        (("current angle [deg]", "valve current [A]"), ["angle"]),
        (("angle_deg", "p_amb_bar"), ["angle"]),
        (("Angle_deg", "angle_deg"), []),
        (("theta", "pB_bar"), ["pressure_b"]),
        (("pA_bar", "p_tank_bar"), ["pressure_a"]),
    ],
)
def test_what_names_and_units_say_together(tmp_path: Path, names: tuple[str, str], signals: list[str]) -> None:
    sizes = {"theta": 0.1 * DEGREES, "Angle_deg": DEGREES + 3.0}
    values = [sizes.get(name, 2.0 * BAR if "p" in name else DEGREES) for name in names]
    path = written(tmp_path, ",".join(["time_s", *names]), TIME, *values)
    if not signals:
        with pytest.raises(InputError, match="may all be angle"):
            guess_mapping(path)
        return
    guess = guess_mapping(path)
    assert [entry.signal for entry in guess.mapping.column] == signals
    assert set(guess.ignored) == set(names) - {column for entry in guess.mapping.column for column in entry.columns}


def test_a_pressure_without_zero_follows_those_that_state_it(tmp_path: Path) -> None:
    guess = guess_mapping(written(tmp_path, "time_s,pA_bar_g,p_supply_bar", TIME, BAR, 6.0 + 0.1 * BAR))
    assert [entry.gauge for entry in guess.mapping.column] == [True, True]
    assert "gauge as others are: check it" in guess.notes["p_supply_bar"]


@pytest.mark.parametrize("name", ["ticks", "sample counter", "tick"])
def test_ticks_are_asked_for(tmp_path: Path, name: str) -> None:
    path = written(tmp_path, f"{name},angle_deg", 62500.0 * TIME, DEGREES)
    with pytest.raises(InputError, match=r"counts ticks, .* `period=\"5 ms\"`"):
        guess_mapping(path)
    guess_mapping(path, period="10 ms")


@pytest.mark.parametrize("form", ["[{:12.6f}] ", "({:.6f}) ", "\x1b[32m{:.6f} \x1b[0m"])
def test_a_time_in_brackets_before_labels(tmp_path: Path, form: str) -> None:
    rows = (f"{form.format(t)}rig: angle={a:.5f} pA={b:.5f}" for t, a, b in zip(TIME, DEGREES, BAR, strict=True))
    path = tmp_path / "log.txt"
    path.write_text("\n".join(rows) + "\n")
    table = read_table(path)
    assert table.columns["1"].values == pytest.approx(TIME)
    assert table.columns["angle"].values == pytest.approx(DEGREES, abs=1e-4)


def test_numbers_of_rows_as_r_writes_them(tmp_path: Path) -> None:
    rows = (f'"{i + 1}" {t:.2f} {a:.5f}' for i, (t, a) in enumerate(zip(TIME, DEGREES, strict=True)))
    path = tmp_path / "log.txt"
    path.write_text('"time" "angle"\n' + "\n".join(rows) + "\n")
    assert read_table(path).columns["angle"].values == pytest.approx(DEGREES, abs=1e-4)


def test_units_that_differ_within_a_column_are_named(tmp_path: Path) -> None:
    cells = [f"{1e3 * b:.0f} mbar" if b < 2.0 else f"{b:.4f} bar" for b in BAR]
    words = read_table(written(tmp_path, "time_s,pA", TIME, cells)).words
    assert "numbers with different units, 'bar', 'mbar': write all with one" in words["pA"]


def test_a_table_without_header_says_what_would_do(tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    path.write_text("".join(f"{t},{a},{b}\n" for t, a, b in zip(TIME, DEGREES, BAR, strict=True)))
    with pytest.raises(InputError, match="give it a header, such as time_s,angle_deg"):
        guess_mapping(path)
    path.write_text("time_s,angle_deg,pA_kPa_gauge\n" + path.read_text())
    assert len(guess_mapping(path).mapping.column) == 2


def test_thousands_alone_are_read_as_the_rest_shows(tmp_path: Path) -> None:
    rows = (f"{10 * i:,};{1000 * (1 + i % 7):,}".replace(",", ".") for i in range(COUNT))
    path = tmp_path / "log.csv"
    path.write_text("Time [ms];PA [Pa abs]\n" + "\n".join(rows) + "\n")
    assert read_table(path).columns["PA [Pa abs]"].values.max() == pytest.approx(7000.0)


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("odd", ["inf", "-inf", "1e400", "nan"])
def test_numbers_that_are_not_finite_are_missing_without_a_warning(tmp_path: Path, odd: str) -> None:
    cells = [odd if i == 7 else f"{d:.3f}" for i, d in enumerate(DEGREES)]
    path = written(tmp_path, "time_s,angle_deg,pA_bar,pB_bar", TIME, cells, BAR, BAR)
    log = read_log(path, guess_mapping(path).mapping)
    assert np.isfinite(log["angle"].values).all()  # a single sample is filled in
