"""A log comes back the same through every kind of file."""

import gc
from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pyarrow
import pytest
import xarray
from hypothesis import given, settings
from hypothesis import strategies as st
from pyarrow import parquet

from layflat.errors import InputError
from layflat.identify.logs import read_log, read_table, save_run
from layflat.identify.logs.mapping import parse_mapping
from layflat.motion.scenario import SIGNALS as ACTING
from tests.identify.logs.bags import write_json
from tests.identify.logs.recordings import Array, changed, entry, mapping, recorded, run, write_csv

Columns = dict[str, Array]


def to_csv(path: Path, columns: Columns) -> Path:
    return write_csv(path.with_suffix(".csv"), columns)


def to_tabs(path: Path, columns: Columns) -> Path:
    return write_csv(path.with_suffix(".txt"), columns, "\t")


def to_parquet(path: Path, columns: Columns) -> Path:
    parquet.write_table(pyarrow.table(columns), path.with_suffix(".parquet"))
    return path.with_suffix(".parquet")


def to_netcdf(path: Path, columns: Columns) -> Path:
    time = columns["time"]
    data = xarray.Dataset({k: ("time", v) for k, v in columns.items() if k != "time"}, coords={"time": time})
    return save_run(data, path.with_suffix(".nc"))


def to_mcap(path: Path, columns: Columns) -> Path:
    messages = []
    for i, time in enumerate(columns["time"]):
        for name, values in columns.items():
            topic, _, field = name.partition(".")
            if name != "time" and np.isfinite(values[i]):
                messages.append((f"/{topic}", float(time), {field: values[i]} if field else float(values[i])))
    return write_json(path.with_suffix(".mcap"), messages)


numbers = st.floats(-1e6, 1e6, allow_nan=False, width=64)


@st.composite
def tables(draw: st.DrawFn) -> Columns:
    size = draw(st.integers(3, 40))
    period = draw(st.sampled_from([0.001, 0.005, 0.01, 0.25]))
    column = st.lists(numbers, min_size=size, max_size=size).map(np.array)
    names = ("angle.large", "angle.small", "voltage.large", "measured_pressure.small", "supply", "payload")
    return {"time": period * np.arange(size)} | {name: draw(column) for name in names}


@pytest.mark.parametrize("write", [to_csv, to_tabs, to_parquet, to_netcdf, to_mcap])
@settings(max_examples=8)
@given(columns=tables())
def test_our_own_names_come_back_from_every_file(write: Callable[[Path, Columns], Path], columns: Columns) -> None:
    with TemporaryDirectory() as folder:
        log = read_log(write(Path(folder) / "log", columns))
    assert log["time"].values == pytest.approx(columns["time"], rel=1e-9, abs=1e-9)
    for name, values in list(columns.items())[1:]:
        signal, _, joint = name.partition(".")
        back = log[signal].sel(joint=joint) if joint else log[signal]
        assert np.array_equal(back.values, values), name
    assert np.isnan(log["voltage"].sel(joint="small")).all()


@settings(max_examples=30)
@given(columns=tables(), scale=st.floats(0.1, 10.0), offset=st.floats(-5.0, 5.0), sign=st.sampled_from([1, -1]))
def test_a_mapping_undoes_what_a_rig_did(columns: Columns, scale: float, offset: float, sign: int) -> None:
    raw = np.degrees(columns["angle.large"]) / (sign * scale) + offset
    kpa = (columns["supply"] - 101325.0) / 1e3
    with TemporaryDirectory() as folder:
        path = write_csv(Path(folder) / "x.csv", {"t": 1e3 * columns["time"], "q": raw, "ps": kpa})
        turned = {"unit": f"{scale!r} deg", "offset": offset, "sign": sign}
        angle = {"from": "q", "signal": "angle", "joint": "large", **turned}
        supply = {"from": "ps", "signal": "supply", "unit": "kPa", "gauge": True}
        plain = {"time": {"column": "t", "unit": "ms"}, "column": [angle, supply]}
        log = read_log(path, parse_mapping(plain))
    expected = columns["angle.large"]
    assert log["angle"].values[:, 0] == pytest.approx(expected, rel=1e-9, abs=1e-9 * max(1.0, np.abs(expected).max()))
    assert log["supply"].values == pytest.approx(columns["supply"], rel=1e-9, abs=1e-4)


def test_a_simulated_run_gives_what_its_sensors_saw(tmp_path: Path) -> None:
    simulated = run()
    log = read_log(save_run(simulated, tmp_path / "run.nc"), joints=["small"])
    acting = {"demand", *(name for name, row in ACTING.items() if not row.by_joint)}
    assert set(log.data_vars) == {"angle", "measured_pressure", "voltage", *acting}
    assert np.array_equal(log["angle"].values, simulated["measured_angle"].values)
    for name in ("measured_pressure", "voltage", *acting):
        assert np.array_equal(log[name].values, simulated[name].values), name
    assert log["time"].values == pytest.approx(simulated["time"].values, abs=1e-12)
    assert log.attrs["log_period"] == pytest.approx(0.005)


def test_true_pressures_of_a_run_are_had_by_a_mapping_only(tmp_path: Path) -> None:
    path = save_run(run(), tmp_path / "run.nc")
    pressure = entry("pressure_a.small", "pressure_a", "Pa", gauge=False)
    angle = entry("angle.small", "angle", "rad")
    log = read_log(path, parse_mapping({"time": {"column": "time", "unit": "s"}, "column": [pressure, angle]}))
    assert np.array_equal(log["pressure_a"].values, run()["pressure_a"].values)
    assert np.array_equal(log["angle"].values, run()["angle"].values)


def test_a_saved_log_reads_as_it_was_and_tells_where_it_is_from(tmp_path: Path) -> None:
    path = write_csv(tmp_path / "rig.csv", recorded())
    log = read_log(path, mapping(), joints=["small"])
    back = read_log(save_run(log, tmp_path / "log.nc"))
    for name in log.data_vars:
        assert np.array_equal(log[name].values, back[name].values), name
    assert log.attrs["log_name"] == "rig.csv"
    assert len(log.attrs["log_sha256"]) == 64
    other = write_csv(tmp_path / "other.csv", changed(recorded(), "theta", lambda x: x + 1.0))
    assert read_table(other).sha256 != log.attrs["log_sha256"] == read_table(path).sha256


def written(folder: Path, text: str) -> Path:
    path = folder / "log.csv"
    path.write_text(text, encoding="utf-8")
    return path


@pytest.mark.parametrize(
    "text",
    [
        "time,force,position [mm]\n0,1.5,10\n0.1,2.5,20\n0.2,,30\n",
        "# a rig\n\ntime;force;position [mm]\n0;1,5;10\n0,1;2,5;20\n0,2;;30\n",
        "time\tforce\tposition\ns\tN\tmm\n0\t1.5\t10\n0.1\t2.5\t20\n0.2\t\t30\n",
        "time_ms, force (N), position_mm\n0, 1.5, 10\n100, 2.5, 20\n200, nan, 30\n",
        "time,force,position,word\n2026-01-01T00:00:00,1.5,0.01,a\n2026-01-01T00:00:00.1,2.5,0.02,b\n"
        "2026-01-01T00:00:00.2,,0.03,c\n",
        "signal,time_s,value,unit\nforce,0,1.5,N\nforce,0.1,2.5,N\nposition,0,10,mm\nposition,0.1,20,mm\n"
        "position,0.2,30,mm\n",
        "\ufefftime|force|position [mm]\n0|1.5|10\n0.1|2.5|20\n0.2||30\n",
    ],
    ids=["comma", "decimal comma", "line of units", "units in names", "dates", "long", "byte order mark"],
)
def test_the_same_log_in_many_hands(tmp_path: Path, text: str) -> None:
    log = read_log(written(tmp_path, text))
    assert log["time"].values == pytest.approx([0.0, 0.1, 0.2])
    assert log["force"].values == pytest.approx([1.5, 2.5, np.nan], nan_ok=True)
    assert log["position"].values == pytest.approx([0.01, 0.02, 0.03])


def test_columns_without_header_go_by_their_number(tmp_path: Path) -> None:
    table = read_table(write_csv(tmp_path / "x.txt", {"a": np.arange(3.0), "b": np.ones(3)}, "\t", header=False))
    assert list(table.columns) == ["1", "2"]
    assert np.array_equal(table.columns["1"].values, np.arange(3.0))


def test_parquet_with_dates_units_and_words(tmp_path: Path) -> None:
    dates = pyarrow.array(np.array(["2026-01-01T00:00:00", "2026-01-01T00:00:00.5"], dtype="datetime64[us]"))
    fields = [pyarrow.field("time", dates.type), pyarrow.field("force", pyarrow.int32(), metadata={"unit": "kN"})]
    table = pyarrow.table([dates, pyarrow.array([1, 2], pyarrow.int32())], schema=pyarrow.schema(fields))
    parquet.write_table(table.append_column("word", pyarrow.array(["a", "b"])), tmp_path / "x.parquet")
    log = read_log(tmp_path / "x.parquet")
    assert log["time"].values == pytest.approx([0.0, 0.5])
    assert log["force"].values == pytest.approx([1000.0, 2000.0])


@pytest.mark.parametrize(
    ("name", "text", "expected"),
    [
        ("none.csv", None, "can't be read (No such file or directory); give a CSV, Parquet, NetCDF or MCAP file"),
        ("log.csv", "", "holds no samples; give a table with a row a sample"),
        ("log.csv", "a,b\n", "holds no samples"),
        ("log.csv", "a,b\nx,y\n", "holds no numbers"),
        ("log.csv", "a,a\n1,2\n", "its columns (a (column 1), a (column 2)) are not layflat's own signals"),
        ("log.csv", "a,b\n1,2\n3\n", "line 3 ('3') has 1 values in place of 2; give each row as many values"),
        ("log.csv", "a,b\n1,5,2,5\n2,5,3,5\n", "its header has 2 names and its rows 4 values; give each column a name"),
        (
            "log.csv",
            "time,speed\n0,1\n1,2\n",
            "its columns (time, speed) are not layflat's own signals; give a mapping",
        ),
        ("log.csv", "stamp,angle\n0,1\n1,2\n", "its columns (stamp, angle) are not layflat's own signals"),
        ("log.parquet", "no", "can't be read as Parquet"),
        ("log.nc", "no", "can't be read as NetCDF"),
        ("log.csv", "time,force\n1,1\n", "has less than two samples; give a log of a motion"),
        (
            "log.csv",
            "time,force\n1,1\n1,2\n",
            "all 2 samples have the stamp 1 s; name a column that rises as its clock",
        ),
        ("log.csv", "time,force\n0,1\n1e-12,2\n2e-12,3\n9999,3\n", "too many; check the unit of time"),
    ],
)
def test_what_can_not_be_read_is_told_in_one_line(tmp_path: Path, name: str, text: str | None, expected: str) -> None:
    path = tmp_path / name
    if text is not None:
        path.write_text(text, encoding="utf-8")
    with pytest.raises(InputError) as caught:
        read_log(path)
    assert str(caught.value).startswith(str(path))
    assert expected in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_file_that_is_no_text(tmp_path: Path) -> None:
    path = tmp_path / "x.csv"
    path.write_bytes(bytes(range(256)))
    with pytest.raises(InputError, match="is not a text file; give a table of text"):
        read_log(path)


def test_a_cycle_that_is_none(tmp_path: Path) -> None:
    path = written(tmp_path, "time,force\n0,1\n1,2\n")
    for cycle, expected in (("0 s", "cycle: 0 s is out of range"), ("5", "cycle: '5' is a bare number")):
        with pytest.raises(InputError, match=expected):
            read_log(path, cycle=cycle)


@pytest.mark.parametrize("kind", ["nc", "parquet"])
def test_a_damaged_file_is_refused_in_one_line(kind: str, tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    """Flipped bits, anywhere: what can still be read is read, all else is one line, and nothing else is said."""
    time = np.arange(40) * 0.01
    whole = tmp_path / f"whole.{kind}"
    if kind == "nc":
        signals = {"angle": ("time", np.sin(time), {"units": "rad"}), "voltage": ("time", np.cos(time))}
        xarray.Dataset(signals, {"time": ("time", time, {"units": "s"})}).to_netcdf(whole, engine="h5netcdf")
    else:
        pytest.importorskip("pandas").DataFrame({"time": time, "angle": np.sin(time)}).to_parquet(whole)
    content, random, lines = whole.read_bytes(), np.random.default_rng(0), list[str]()
    gc.collect()
    gc.freeze()  # else each of the files would be looked for among all that the tests before have left
    for _ in range(60):
        flipped = bytearray(content)
        flipped[random.integers(len(content))] ^= 1 << int(random.integers(8))
        damaged = tmp_path / f"damaged.{kind}"
        damaged.write_bytes(flipped)
        try:
            read_table(damaged)
        except InputError as error:
            lines.append(str(error))
    assert len(lines) > 2
    assert all(str(damaged) in line and "\n" not in line for line in lines)
    assert capfd.readouterr().err == ""
