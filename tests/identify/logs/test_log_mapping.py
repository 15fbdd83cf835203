from math import radians
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from layflat.errors import InputError
from layflat.identify.logs import read_log, read_mapping, write_mapping
from layflat.identify.logs.mapping import LogMapping, format_mapping, parse_mapping
from layflat.identify.logs.vocabulary import SIGNALS
from tests.identify.logs.recordings import ENTRIES, mapping, recorded, write_csv

TEXT = """
[time]
column = "t"
unit = "s"

[[column]]
from = "rpa5"
signal = "pressure_a"
joint = "elbow"
unit = "kPa"
gauge = true
"""
ANGLE = '\n[[column]]\nfrom = "q"\nsignal = "angle"\njoint = "elbow"\nunit = "deg"\n'


def file(folder: Path, text: str) -> Path:
    path = folder / "m.toml"
    path.write_text(text, encoding="utf-8")
    return path


def test_a_value_is_sign_times_raw_less_offset_times_scale_times_unit_above_ambient(tmp_path: Path) -> None:
    text = TEXT.replace("[time]", 'ambient = "0.95 bar"\n[time]', 1) + "sign = -1\noffset = 3.0\nscale = 2.0\n"
    log = read_log(write_csv(tmp_path / "x.csv", {"t": np.arange(3.0), "rpa5": np.array([3.0, -7.0, 0.5])}),
                   file(tmp_path, text))  # fmt: skip
    expected = [0.95e5, 0.95e5 + 20e3, 0.95e5 + 5e3]
    assert log["pressure_a"].sel(joint="elbow").values == pytest.approx(expected)


@pytest.mark.parametrize(
    ("signal", "unit", "raw", "expected"),
    [
        ("temperature", "degC", 20.0, 293.15),
        ("temperature", "K", 20.0, 20.0),
        ("force", "kN", 1.5, 1500.0),
        ("torque", "N m", 1.5, 1.5),
        ("angle", "0.6 deg", 50.0, radians(30.0)),
        ("brake", "%", 50.0, 0.5),
        ("brake", "1", 0.5, 0.5),
        ("measured_pressure", "psi", 1.0, 6894.757),
    ],
)
def test_units(tmp_path: Path, signal: str, unit: str, raw: float, expected: float) -> None:
    path = write_csv(tmp_path / "x.csv", {"t": np.arange(2.0), "x": np.full(2, raw)})
    plain = {"time": {"column": "t", "unit": "s"}, "column": [{"from": "x", "signal": signal, "unit": unit}]}
    assert read_log(path, parse_mapping(plain))[signal].values == pytest.approx([expected] * 2)


def test_several_columns_of_one_thing_are_its_mean(tmp_path: Path) -> None:
    path = write_csv(tmp_path / "x.csv", {"t": np.arange(3.0), "x": np.arange(3.0), "y": np.full(3, 4.0)})
    plain = {"time": {"column": "t", "unit": "s"}, "column": [{"from": ["x", "y"], "signal": "force", "unit": "N"}]}
    assert read_log(path, parse_mapping(plain))["force"].values == pytest.approx([2.0, 2.5, 3.0])


def test_of_optional_columns_those_that_are_there_are_used(tmp_path: Path) -> None:
    path = write_csv(tmp_path / "x.csv", {"t": np.arange(2.0), "x": np.arange(2.0), "y": np.ones(2)})
    entries = [{"from": name, "signal": "force", "unit": "N", "optional": True} for name in ("x", "z")]
    plain: dict[str, Any] = {"time": {"column": "t", "unit": "s"}, "column": entries}
    assert read_log(path, parse_mapping(plain))["force"].values == pytest.approx([0.0, 1.0])
    entries[1]["from"] = "y"
    with pytest.raises(InputError, match="x and y are both force; both are in this log: keep one"):
        read_log(path, parse_mapping(plain))


@st.composite
def mappings(draw: st.DrawFn) -> LogMapping:
    words = st.text("abc_ .[]\"'5/", min_size=1, max_size=8)
    names = draw(st.lists(words, min_size=3, max_size=3, unique=True))
    signals = draw(st.permutations(["angle", "pressure_a", "supply", "force"]))
    entries = []
    for name, word in zip(names[:2], signals[:2], strict=True):
        signal = SIGNALS[word]
        entry: dict[str, Any] = {"from": name, "signal": word, "unit": signal.unit}
        if signal.by_joint:
            entry["joint"] = draw(st.sampled_from(["elbow", "a b"]))
        if signal.absolute:
            entry["gauge"] = draw(st.booleans())
        entry |= {
            "offset": draw(st.floats(-9, 9)),
            "scale": draw(st.floats(0.1, 9)),
            "sign": draw(st.sampled_from([1, -1])),
        }
        entries.append(entry | {"optional": draw(st.booleans())})
    return parse_mapping({"ambient": "0.9 bar", "time": {"column": names[2], "unit": "ms"}, "column": entries})


@settings(max_examples=30)
@given(mapping=mappings())
def test_a_written_mapping_reads_as_it_was(mapping: LogMapping, tmp_path_factory: pytest.TempPathFactory) -> None:
    notes = {entry.columns[0]: "why" for entry in mapping.column} | {"": "the clock", "other": "left\nout"}
    path = write_mapping(mapping, tmp_path_factory.mktemp("m") / "m.toml", notes, "a head")
    assert read_mapping(path) == mapping
    assert "# why" in format_mapping(mapping, notes)


@pytest.mark.parametrize(
    ("old", "new", "expected"),
    [
        ('"kPa"', '"V"', "column 1.rpa5: 'V' is not a unit of a pressure; give one such as \"bar\""),
        ('"kPa"', '"-1 bar"', "column 1.rpa5: '-1 bar' is not a unit of a pressure"),
        ('"kPa"', '"0 bar"', "column 1.rpa5: '0 bar' is not positive; turn a signal round with sign = -1"),
        ('"pressure_a"', '"presure_a"', "column 1.rpa5: 'presure_a' is not a signal; did you mean 'pressure_a'?"),
        ("gauge = true\n", "", "column 1.rpa5: pressure_a does not say what it counts from; say gauge = true"),
        ('"pressure_a"', '"angle"', "column 1.rpa5: 'kPa' is not a unit of an angle"),
        ('"pressure_a"', '"measured_pressure"', "gauge does not apply to measured_pressure: it is no absolute"),
        ('"pressure_a"', '"supply"', "column 1.rpa5: supply belongs to no joint; leave joint out"),
        ("gauge = true", "guage = true", "column 1.guage: unknown key; did you mean 'gauge'?"),
        ('unit = "s"', 'unit = "bar"', "time.unit: 'bar' is not a unit of a time; give one such as \"s\" or \"ms\""),
        ('unit = "s"\n', "", "time.unit: is missing; a mapping has [[column]]"),
        ('from = "rpa5"\n', "", "column 1.from: is missing"),
        ("gauge = true", "gauge = true\nsign = 2", "column 1.sign: 2 is not known; give 1 or -1"),
        ("gauge = true", "gauge = true\nscale = 0.0", "column 1.scale: 0.0 is out of range; give more than 0"),
        ('from = "rpa5"', 'from = ["x", "x"]', "from has 'x' twice; name each column once"),
        ('from = "rpa5"', 'from = "t"', "column 't' is both time and pressure_a.elbow; keep one"),
        ("[time]", "[tme]", "tme: unknown key; did you mean 'time'?"),
        ("[time]", 'ambient = "1 m"\n[time]', "ambient: '1 m' is not a pressure; give a pressure such as \"4 bar\""),
        ("[time]", "[time", "is not TOML"),
    ],
)  # fmt: skip
def test_what_is_wrong_in_a_mapping_is_told_in_one_line(tmp_path: Path, old: str, new: str, expected: str) -> None:
    assert old in TEXT
    path = file(tmp_path, TEXT.replace(old, new, 1))
    with pytest.raises(InputError) as caught:
        read_mapping(path)
    assert str(caught.value).startswith(f"{path}: ")
    assert expected in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("more", "expected"),
    [
        (ANGLE + ANGLE.replace('"q"', '"q2"'), "q and q2 are both angle.elbow; keep one, or put both in one list"),
        (ANGLE.replace('"q"', '"rpa5"'), "column 'rpa5' is both pressure_a.elbow and angle.elbow; keep one"),
    ],
)
def test_entries_that_contradict_each_other(tmp_path: Path, more: str, expected: str) -> None:
    with pytest.raises(InputError) as caught:
        read_mapping(file(tmp_path, TEXT + more))
    assert expected in str(caught.value)


def test_mappings_of_measured_logs_are_sound() -> None:
    mappings = sorted((Path(__file__).parents[3] / "research" / "measured_logs").glob("*.toml"))
    assert [path.stem for path in mappings] == ["affetto", "vessel", "zillen"]
    assert all(read_mapping(path).time is not None for path in mappings)


def test_a_mapping_that_is_not_there(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="`layflat log map` writes one to start from"):
        read_mapping(tmp_path / "none.toml")


@pytest.mark.parametrize(
    ("changes", "joints", "expected"),
    [
        ({"theta": {"from": "thta"}}, ["small"], "no column 'thta' in rig.csv; did you mean 'theta'?"),
        ({"theta": {"joint": "smal"}}, ["small"], "'smal' is not a joint of the machine; its joints are small"),
        ({"theta": {"joint": None}}, ["large", "small"], "angle from 'theta' does not say of which joint"),
        ({"theta": {"joint": None}}, None, "angle from 'theta' does not say of which joint; say joint = 'small'"),
    ],
)
def test_a_mapping_that_does_not_fit_the_log(
    tmp_path: Path, changes: dict[str, Any], joints: list[str] | None, expected: str
) -> None:
    path = write_csv(tmp_path / "rig.csv", recorded())
    with pytest.raises(InputError) as caught:
        read_log(path, mapping(**changes), joints=joints)
    assert expected in str(caught.value)


@pytest.mark.parametrize(
    ("time", "expected"),
    [
        (None, "does not say which column is the clock; give [time] with"),
        ({"column": "tme_ms", "unit": "s"}, "time.column: no column 'tme_ms' in rig.csv; did you mean 'time_ms'?"),
    ],
)
def test_a_clock_that_is_not_there(tmp_path: Path, time: dict[str, str] | None, expected: str) -> None:
    path = write_csv(tmp_path / "rig.csv", recorded())
    plain = {"column": [ENTRIES["theta"]]} | ({"time": time} if time else {})
    with pytest.raises(InputError) as caught:
        read_log(path, parse_mapping(plain))
    assert expected in str(caught.value)


def test_the_only_joint_goes_without_saying(tmp_path: Path) -> None:
    path = write_csv(tmp_path / "rig.csv", recorded())
    plain = {"time": {"column": "time_ms", "unit": "ms"}, "column": [{**ENTRIES["theta"], "joint": None}]}
    assert list(read_log(path, parse_mapping(plain), joints=["small"])["joint"].values) == ["small"]
    assert read_log(path, parse_mapping(plain))["angle"].dims == ("time",)
