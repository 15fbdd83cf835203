"""Tables of recorders, controllers and databases: a sample a row, clocks of their own, headings with labels."""

from collections.abc import Callable, Sequence
from datetime import UTC, datetime, timedelta
from pathlib import Path

import numpy as np
import pytest

from layflat.errors import InputError
from layflat.identify.logs import guess_mapping, read_log, read_table
from tests.identify.logs.recordings import ticks

COUNT = 200
TIME = ticks(0.01, COUNT)
DEGREES = 40.0 * np.sin(5.0 * TIME)
BAR = 2.0 + 1.9 * np.sin(5.0 * TIME)
VOLTS = 5.0 + np.cos(5.0 * TIME)
SIGNALS = {"Angle_deg": DEGREES, "pA_bar_g": BAR, "pB_bar_g": 4.0 - BAR, "Valve_V": VOLTS}
TRUE = {
    "angle": np.radians(DEGREES),
    "pressure_a": 1e5 * BAR + 101325.0,
    "pressure_b": 1e5 * (4.0 - BAR) + 101325.0,
    "voltage": VOLTS,
}
START = datetime(2026, 3, 14, 9, 26, 53, tzinfo=UTC)


def clock(i: int) -> datetime:
    return START + timedelta(seconds=float(TIME[i]))


def iso(i: int) -> str:
    return f"{clock(i):%Y-%m-%dT%H:%M:%S}.{clock(i).microsecond // 1000:03d}Z"


def long_rows(row: Callable[[int, str, float], str], *, by_signal: bool) -> str:
    """Rows of a table with a sample a row, in the order of the signals or of the times."""
    places = [(i, name) for name in SIGNALS for i in range(COUNT)]
    places = places if by_signal else sorted(places, key=lambda place: place[0])
    return "".join(row(i, name, float(SIGNALS[name][i])) + "\n" for i, name in places)


def comma(value: float) -> str:
    return f"{value:.6f}".replace(".", ",")


def influx(i: int, name: str, value: float) -> str:
    return f",,0,2026-03-14T09:00:00Z,2026-03-14T10:00:00Z,{iso(i)},{value:.6f},{name},rig"


def wincc(i: int, name: str, value: float) -> str:
    days = 46095.393669 + TIME[i] / 86400.0
    return f'"{name}";"{clock(i):%d.%m.%Y %H:%M:%S}";{comma(value)};1;{comma(1e6 * days)}'


ANNOTATED = (
    "#group,false,false,true,true,false,false,true,true\n"
    "#datatype,string,long,dateTime:RFC3339,dateTime:RFC3339,dateTime:RFC3339,double,string,string\n"
    "#default,_result,,,,,,,\n,result,table,_start,_stop,_time,_value,_field,_measurement\n"
)
LONG = {
    "influx": ANNOTATED + long_rows(influx, by_signal=True),
    "influx in blocks": "\n".join(
        ANNOTATED + "".join(influx(i, name, float(values[i])) + "\n" for i in range(COUNT))
        for name, values in SIGNALS.items()
    ),
    "wincc": '"VarName";"TimeString";"VarValue";"Validity";"Time_ms"\n'
    + long_rows(wincc, by_signal=False)
    + f'"$RT_COUNT$";{4 * COUNT};;;\n',
    "grafana": '"Series","Time","Value"\n'
    + long_rows(lambda i, name, value: f'"{name}",{iso(i)},{value:.6f}', by_signal=True),
    "prometheus": "timestamp,metric,value\n"
    + long_rows(lambda i, name, value: f"{1773480413000 + 10 * i},{name},{value:.6f}", by_signal=False),
    "opc": "NodeId;SourceTimestamp;ServerTimestamp;Value;StatusCode\n"
    + long_rows(lambda i, name, value: f"{name};{iso(i)};{iso(0)};{value:.6f};Good", by_signal=False),
    "melted": ",time,variable,value\n"
    + long_rows(lambda i, name, value: f"{i},{TIME[i]:.2f},{name},{value:.6f}", by_signal=True),
}


def check_read(path: Path, signals: Sequence[str] = tuple(TRUE), tolerance: float = 1e-4) -> None:
    """Check that a guess reads the signals as they are, over the right time."""
    guess = guess_mapping(path)
    log = read_log(path, guess.mapping)
    assert set(log.data_vars) == set(signals)
    assert log["time"].values == pytest.approx(TIME, abs=2e-4)
    for name in signals:
        assert log[name].values.ravel() == pytest.approx(TRUE[name], rel=tolerance, abs=tolerance)


@pytest.mark.parametrize("kind", LONG)
def test_a_sample_a_row(tmp_path: Path, kind: str) -> None:
    path = tmp_path / "log.csv"
    path.write_text(LONG[kind])
    check_read(path, tolerance=0.05 if kind == "wincc" else 1e-4)  # whose times are rounded to 9 us
    assert "a sample a row" in " ".join(read_table(path).notes)


def test_samples_of_another_quality_are_missing(tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    path.write_text("name;time;value;quality\n" + "".join(f"angle_deg;{t};{t};{int(t != 3)}\n" for t in range(20)))
    column = read_table(path).columns["angle_deg"]
    assert np.flatnonzero(np.isnan(column.values)).tolist() == [3]
    assert "1 sample is missing, whose quality" in column.notes[0]


def test_words_beside_a_name_tell_signals_of_one_name_apart(tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    rows = (f"{t},{joint},angle_deg,{t + shift}\n" for t in range(9) for joint, shift in (("elbow", 0), ("wrist", 50)))
    path.write_text("time,joint,field,value\n" + "".join(rows))
    assert list(read_table(path).columns) == ["elbow angle_deg", "wrist angle_deg"]


def pairs(names: str, shift: float, unit: float = 1.0) -> str:
    """A table in which each signal follows its times, which are later from signal to signal."""
    rows = (
        ";".join(f"{unit * (TIME[i] + k * shift):.4f};{values[i]:.6f}" for k, values in enumerate(SIGNALS.values()))
        for i in range(COUNT)
    )
    return names + "\n" + "\n".join(rows) + "\n"


@pytest.mark.parametrize(
    ("names", "unit"),
    [
        ("Time;Angle [deg];Time;pA [bar g];Time;pB [bar g];Time;Valve [V]", 1.0),
        ("t1 [ms];Angle [deg];t2 [ms];pA [bar g];t3 [ms];pB [bar g];t4 [ms];Valve [V]", 1e3),
        ("Angle_deg_X;Angle_deg_Y;pA_bar_g_X;pA_bar_g_Y;pB_bar_g_X;pB_bar_g_Y;Valve_V_X;Valve_V_Y", 1.0),
        ("Angle Time;Angle Value [deg];pA Time;pA Value [bar g];pB Time;pB Value [bar g];u Time;u Value [V]", 1.0),
    ],
)
@pytest.mark.parametrize("shift", [0.0, 0.005])
def test_each_signal_goes_by_its_own_times(tmp_path: Path, names: str, unit: float, shift: float) -> None:
    path = tmp_path / "log.csv"
    path.write_text(pairs(names, shift, unit))
    if shift == 0.0:
        check_read(path)
        return
    table = read_table(path)
    assert "4 clocks: each column goes by the times before it" in table.notes[-1]
    stamps = [column.stamps[0] / unit for column in table.columns.values() if column.stamps is not None]
    assert stamps == pytest.approx([0.0, shift, 2.0 * shift, 3.0 * shift])
    log = read_log(path, guess_mapping(table).mapping, as_recorded=True)
    angle = log["angle"].values[np.isfinite(log["angle"].values)]
    assert angle == pytest.approx(TRUE["angle"], abs=1e-4)


def test_dates_of_two_clocks_are_compared(tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    rows = (f"{clock(i):%H:%M:%S.%f};{i};{clock(i + 50):%H:%M:%S.%f};{i}\n" for i in range(100))
    path.write_text("Time;angle_deg;Time;valve_V\n" + "".join(rows))
    first, second = (column.stamps for column in read_table(path).columns.values())
    assert first is not None
    assert second is not None
    assert (first[0], second[0]) == pytest.approx((0.0, 0.5))


def test_one_clock_in_two_units_is_no_pair(tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    path.write_text("time_s,angle_deg,time_ms,valve_V\n" + "".join(f"{t},{t},{1e3 * t},{t}\n" for t in TIME))
    assert read_table(path).clock is None


def test_each_signal_of_a_labview_file_has_times(tmp_path: Path) -> None:
    path = tmp_path / "log.lvm"
    path.write_text(
        "LabVIEW Measurement\t\nSeparator\tTab\nX_Columns\tMulti\n***End_of_Header***\t\n\nChannels\t2\t\t\t\n"
        "Y_Unit_Label\tdeg\t\tVolts\t\nX_Dimension\tTime\t\tTime\t\nX0\t0\t\t0\t\nDelta_X\t0.01\t\t0.01\t\n"
        "***End_of_Header***\t\t\t\t\nX_Value\tAngle\tX_Value\tValve\tComment\n"
        + "".join(f"{t}\t{a}\t{t}\t{v}\n" for t, a, v in zip(TIME, DEGREES, VOLTS, strict=True))
    )
    check_read(path, ("angle", "voltage"))


def labelled(rows: dict[str, list[str]], sep: str = "\t", *, repeated: bool = False) -> str:
    return "".join(
        (sep.join(f"{label}{sep}{cell}" for cell in cells) if repeated else sep.join([label, *cells])) + "\n"
        for label, cells in rows.items()
    )


SCOPE = {
    "Name": ["angle", "pA", "pB", "valve"],
    "Data-Type": ["REAL32"] * 4,
    "SampleTime[ms]": ["10"] * 4,
    "SymbolName": ["MAIN.fbAxis.position", "MAIN.p1", "MAIN.p2", "MAIN.u"],
    "NetID": ["192.168.178.20.1.1"] * 4,
    "ScaleFactor": ["1"] * 4,
    "Unit": ["deg (Angle)", "bar (Pressure)", "bar (Pressure)", "V (Voltage)"],
    "Unit Offset": ["0"] * 4,
}
RECORDER = {
    '"TraceName  "': ["Angle", "P_A", "P_B", "Valve"],
    '"BlockSize  "': [str(COUNT)] * 4,
    '"VUnit      "': ["deg", "bar", "bar", "V"],
    '"HResolution"': ["1.0E-02"] * 4,
    '"HUnit      "': ["s"] * 4,
    '"Date       "': ["2026/03/14"] * 4,
    '"Time       "': ["09:26:53.00"] * 4,
}
TRACES = {
    "path": [f"Model Root/{name}" for name in ("Angle", "pA", "pB", "Valve")],
    "unit": ["deg", "bar", "bar", "V"],
    "trace_values": [""] * 4,
}


def rows_of(before: Callable[[int], str], sep: str, after: str = "") -> str:
    return "".join(before(i) + sep.join(f"{v[i]:.6f}" for v in SIGNALS.values()) + after + "\n" for i in range(COUNT))


HEADINGS = {
    "a label before each value": "Name\trig\nFile\tC:\\rig.csv\n\n"
    + labelled(SCOPE, repeated=True)
    + "\n"
    + "".join("\t".join(f"{10 * i}\t{v[i]:.6f}" for v in SIGNALS.values()) + "\n" for i in range(COUNT)),
    "a label for all": "Name\trig\n\n" + labelled(SCOPE) + "\n" + rows_of(lambda i: f"{10 * i}\t", "\t"),
    "a step and no times": '"Model Name","DL850E"\n'
    + labelled(RECORDER, ",")
    + "\n"
    + rows_of(lambda _: ",", ",", ","),
    "units above traces": labelled(TRACES, ";") + rows_of(lambda i: f"{TIME[i]:.2f};", ";"),
    "types and units in cells": "time,angle,pA,pB,valve\n"
    + ",".join(["Type: double"] * 5)
    + "\nUnits: s,Units: deg,Units: bar,Units: bar,Units: V\n"
    + ",".join(["Interp: linear"] * 5)
    + "\n"
    + rows_of(lambda i: f"{TIME[i]:.2f},", ","),
    "two rows of names": '"","Angle","p_A","p_B","Valve"\n'
    '"Time[s]","CH1-1[deg]","CH1-2[bar]","CH2-1[bar]","CH2-2[V]"\n' + rows_of(lambda i: f"{TIME[i]:.2f},", ","),
}


@pytest.mark.parametrize("kind", HEADINGS)
def test_headings_of_recorders(tmp_path: Path, kind: str) -> None:
    path = tmp_path / "log.csv"
    path.write_text(HEADINGS[kind])
    check_read(path)


def test_units_of_a_labelled_row_go_with_the_names_below(tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    path.write_text("Vertical Units,V,V\nLabel,valve,pA\nTIME,CH1,CH2\n" + "".join(f"{t},{t},{t}\n" for t in TIME))
    guess = guess_mapping(path)
    assert [entry.signal for entry in guess.mapping.column] == ["voltage"]
    assert "'V' is not a unit of it" in next(iter(guess.ignored.values()))


@pytest.mark.parametrize("form", ["[{}]", "({})", "{{{}}}", "[{}],"])
def test_rows_in_brackets(tmp_path: Path, form: str) -> None:
    path = tmp_path / "log.txt"
    rows = (form.format(f"{t:.2f}, {a:.4f}, {v:.4f}") for t, a, v in zip(TIME, DEGREES, VOLTS, strict=True))
    path.write_text("time_s, angle_deg, valve_V\n" + "\n".join(rows) + "\n")
    check_read(path, ("angle", "voltage"))


def test_labels_and_units_between_blanks(tmp_path: Path) -> None:
    path = tmp_path / "log.txt"
    rows = (
        f"t: {1e3 * t:.0f} ms angle: {a:.4f} deg valve: {v:.4f} V" for t, a, v in zip(TIME, DEGREES, VOLTS, strict=True)
    )
    path.write_text("\n".join(rows) + "\n")
    check_read(path, ("angle", "voltage"))


def test_numbers_as_python_shows_them(tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    rows = (f"np.float64({t}),tensor({a})" for t, a in zip(TIME, DEGREES, strict=True))
    path.write_text("time_s,angle_deg\n" + "\n".join(rows) + "\n")
    check_read(path, ("angle",))


def test_a_header_that_stands_there_again_is_no_sample(tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    rows = [f"{1e3 * t:.0f},{a:.4f}" for t, a in zip(TIME, DEGREES, strict=True)]
    path.write_text("\n".join(["millis,angle_deg", *rows[:90], "millis,angle_deg", *rows[90:], ""]))
    table = read_table(path)
    assert table.columns["angle_deg"].values.size == COUNT
    assert not table.columns["angle_deg"].notes


def test_words_beside_signals_make_no_table_of_a_sample_a_row(tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    rows = (f"{t},run1,{i % 7},{a},{v}\n" for i, (t, a, v) in enumerate(zip(TIME, DEGREES, VOLTS, strict=True)))
    path.write_text("time_s,name,value,angle_deg,valve_V\n" + "".join(rows))
    check_read(path, ("angle", "voltage"))


def test_units_behind_the_values_of_each_signal(tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    rows = (
        f"{t},{name},{value:.6f} {unit}\n"
        for t, a, v in zip(TIME, DEGREES, VOLTS, strict=True)
        for name, value, unit in (("angle", a, "deg"), ("valve", v, "V"))
    )
    path.write_text("time,variable,value\n" + "".join(rows))
    check_read(path, ("angle", "voltage"))


def test_joints_that_only_names_tell_are_asked_for(tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    rows = (f"{t},{a},{a / 2.0}\n" for t, a in zip(TIME, DEGREES, strict=True))
    path.write_text("time_s,shoulder_deg,elbow_deg\n" + "".join(rows))
    with pytest.raises(InputError, match=r"say which joints the names may have \(`joints`\)"):
        guess_mapping(path)
    guess = guess_mapping(path, ["shoulder", "elbow"])
    assert [entry.channel for entry in guess.mapping.column] == ["angle.shoulder", "angle.elbow"]
