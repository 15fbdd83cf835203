"""Parquet and NetCDF of others: each type of column is read as numbers, or named with the reason."""

from decimal import Decimal
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pyarrow
import pytest
import xarray
from pyarrow import parquet
from scipy.io import netcdf_file

from layflat.errors import InputError
from layflat.identify.logs import guess_mapping, read_log, read_table


def columns(path: Path) -> dict[str, list[float]]:
    return {name: column.values.tolist() for name, column in read_table(path).columns.items()}


def of_parquet(folder: Path, **arrays: Any) -> Path:
    parquet.write_table(pyarrow.table(arrays), folder / "x.parquet")
    return folder / "x.parquet"


BOOL8 = pyarrow.ExtensionArray.from_storage(pyarrow.bool8(), pyarrow.array([1, 0, 1], pyarrow.int8()))
DAYS = pyarrow.array([20000, None, 20002], pyarrow.date32())


@pytest.mark.parametrize(
    ("array", "expected"),
    [
        (pyarrow.array([1, 2, 3], pyarrow.int8()), {"x": [1, 2, 3]}),
        (pyarrow.array([1, 2, None], pyarrow.uint64()), {"x": [1, 2, np.nan]}),
        (pyarrow.array([1, 2, 2**62 + 1], pyarrow.int64()), {"x": [1, 2, 2.0**62]}),
        (pyarrow.array(np.array([1.0, 2.0, 3.0], np.float16)), {"x": [1, 2, 3]}),
        (pyarrow.array([True, None, False]), {"x": [1, np.nan, 0]}),
        (pyarrow.array([Decimal("1.25"), Decimal("-2.50"), None]), {"x": [1.25, -2.5, np.nan]}),
        (pyarrow.array([0, 1500, None], pyarrow.duration("ms")), {"x": [0, 1.5, np.nan]}),
        (pyarrow.array([0, 5, 7], pyarrow.duration("ns")), {"x": [0, 5e-9, 7e-9]}),
        (pyarrow.array([0, 1500, 3000], pyarrow.time32("ms")), {"x": [0, 1.5, 3]}),
        (pyarrow.array([0, 1500, 3000], pyarrow.time64("us")), {"x": [0, 1.5e-3, 3e-3]}),
        (pyarrow.array([5000, 5500, None], pyarrow.timestamp("ms")), {"x": [0, 0.5, np.nan]}),
        (pyarrow.array([None, 9, 11], pyarrow.timestamp("s", "Europe/Berlin")), {"x": [np.nan, 0, 2]}),
        (pyarrow.array([0, 2**62, 0], pyarrow.timestamp("us")), {"x": [0, 2**62 / 1e6, 0]}),
        (DAYS, {"x": [0, np.nan, 2 * 86400]}),
        (DAYS.cast(pyarrow.date64()), {"x": [0, np.nan, 2 * 86400]}),
        (pyarrow.array(["1", "2", "x"]).dictionary_encode(), {"x": [1, 2, np.nan]}),
        (pyarrow.array([1.5, None, 1.5]).dictionary_encode(), {"x": [1.5, np.nan, 1.5]}),
        (pyarrow.array(["1", None, "3"], pyarrow.large_string()), {"x": [1, np.nan, 3]}),
        (BOOL8, {"x": [1, 0, 1]}),
        (pyarrow.array([[1, 2], [3], None]), {"x.0": [1, 3, np.nan], "x.1": [2, np.nan, np.nan]}),
        (pyarrow.array([[1.0, 2.0]] * 3, pyarrow.list_(pyarrow.float32(), 2)), {"x.0": [1] * 3, "x.1": [2] * 3}),
        (pyarrow.array([{"a": 1, "b": [2]}, None, {"a": 3}]), {"x.a": [1, np.nan, 3], "x.b.0": [2, np.nan, np.nan]}),
    ],
    ids=lambda value: str(value.type) if isinstance(value, pyarrow.Array) else "",
)  # fmt: skip
def test_every_type_of_parquet_is_read(tmp_path: Path, array: Any, expected: dict[str, list[float]]) -> None:
    read = columns(of_parquet(tmp_path, n=pyarrow.array([7.0, 8.0, 9.0]), x=array))
    assert set(read) == {"n", *expected}
    for name, values in expected.items():
        assert read[name] == pytest.approx(values, rel=1e-15, nan_ok=True), name


def test_what_parquet_holds_besides_is_named(tmp_path: Path) -> None:
    path = of_parquet(
        tmp_path,
        time=pyarrow.array([0.0, 0.1, 0.2]),
        angle=pyarrow.array([0.1, 0.2, 0.3]),
        raw=pyarrow.array([b"a", b"b", b"c"]),
        scan=pyarrow.array([[0.0] * 100] * 3),
        pairs=pyarrow.array([[("a", 1)]] * 3, pyarrow.map_(pyarrow.string(), pyarrow.int64())),
    )
    assert read_table(path).words == {
        "raw": "is of type binary, which is no number",
        "scan": "has 100 items a row, and an array of more than 64 is no signal",
        "pairs": "is of type map<string, int64 ('pairs')>, which is no number",
    }
    assert "binary" in guess_mapping(path).ignored["raw"]


def test_two_columns_of_one_name_in_parquet(tmp_path: Path) -> None:
    table = pyarrow.Table.from_arrays([pyarrow.array([1.0]), pyarrow.array([2.0])], names=["a", "a"])
    parquet.write_table(table, tmp_path / "x.parquet")
    with pytest.raises(InputError, match="has two columns named 'a'; rename one of them"):
        read_table(tmp_path / "x.parquet")


def classic(path: Path, version: int = 1, time: str = "time") -> Path:
    """A file of NetCDF-3, of two joints, with packed numbers and with places that were never written."""
    file = netcdf_file(path, "w", version=version)
    file.createDimension(time, None)
    file.createDimension("joint", 2)
    file.createDimension("letters", 8)
    clock: Any = file.createVariable(time, "d", (time,))
    clock[:] = 0.1 * np.arange(5)
    clock.units = b"s"
    names = file.createVariable("joint", "c", ("joint", "letters"))
    names[:] = np.array([list("shoulder"), list("elbow   ")], dtype="S1")
    angle: Any = file.createVariable("angle", "f", (time, "joint"))
    angle[:] = np.arange(10.0).reshape(5, 2)
    angle.units = b"deg"
    packed: Any = file.createVariable("force", "h", (time,))
    packed[:] = np.arange(5)
    packed.scale_factor, packed.add_offset = 0.5, 10.0
    unwritten = file.createVariable("torque.elbow", "d", (time,))
    unwritten[:] = np.array([1.0, 9.969209968386869e36, 3.0, 4.0, 9.969209968386869e36])
    file.close()
    return path


@pytest.mark.parametrize("version", [1, 2])
@pytest.mark.parametrize("name", ["x.nc", "x.cdf"])
def test_netcdf_3_is_read(tmp_path: Path, version: int, name: str) -> None:
    log = read_log(classic(tmp_path / name, version), joints=["shoulder", "elbow"])
    assert log["time"].values == pytest.approx(0.1 * np.arange(5))
    assert log["angle"].sel(joint="elbow").values == pytest.approx(np.radians([1.0, 3.0, 5.0, 7.0, 9.0]))
    assert log["force"].values == pytest.approx(10.0 + 0.5 * np.arange(5))
    unwritten = columns(tmp_path / name)["torque.elbow"]
    assert unwritten == pytest.approx([1.0, np.nan, 3.0, 4.0, np.nan], nan_ok=True)


def test_the_clock_of_netcdf_may_have_another_name(tmp_path: Path) -> None:
    assert columns(classic(tmp_path / "x.nc", time="t"))["t"] == pytest.approx(0.1 * np.arange(5))
    data = xarray.Dataset({"time": ("obs", [0.0, 0.1]), "force": ("obs", [1.0, 2.0])})
    data.to_netcdf(tmp_path / "obs.nc", engine="h5netcdf")
    assert columns(tmp_path / "obs.nc") == {"time": [0.0, 0.1], "force": [1.0, 2.0]}


def test_time_need_not_be_the_first_dimension(tmp_path: Path) -> None:
    angles = ("joint", "time"), np.array([[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]])
    data = xarray.Dataset({"angle": angles}, {"time": [0.0, 1.0, 2.0], "joint": [1, 2]})
    data.to_netcdf(tmp_path / "x.nc", engine="h5netcdf")
    table = read_table(tmp_path / "x.nc")
    assert table.columns["angle.2"].values.tolist() == [4.0, 5.0, 6.0]
    assert table.words == {}


def test_what_netcdf_holds_besides_is_named(tmp_path: Path) -> None:
    data = xarray.Dataset(
        {
            "force": ("time", [1.0, 2.0]),
            "image": (("time", "x", "y"), np.zeros((2, 2, 2))),
            "pressure": ("time_p", [1.0, 2.0, 3.0]),
            "word": ("time", ["a", "b"]),
            "line": (("time", "pixel"), np.zeros((2, 65))),
            "constant": 7.0,
        },
        {"time": [0.0, 0.1], "time_p": [0.0, 0.05, 0.1]},
    )
    path = tmp_path / "x.nc"
    data.to_netcdf(path, engine="h5netcdf")
    with h5py.File(path, "a") as file:
        file.create_group("second")["v"] = [1.0]
    table = read_table(path)
    assert set(table.columns) == {"time", "force"}
    assert table.words["image"] == "has 3 dimensions"
    assert table.words["pressure"] == "goes along 'time_p', and the clock along 'time'"
    assert "which is no number" in table.words["word"]
    assert "groups are not read" in table.words["group second"]
    assert table.words["line"] == "has 65 items each, and more than 64 are no signal"
    assert "constant" not in table.words


@pytest.mark.parametrize(
    ("content", "expected"),
    [
        (
            b"CDF\x05" + bytes(30),
            "is NetCDF of the kind CDF-5, which is not read here; convert it: `nccopy -k nc4 x.nc NEW.nc`",
        ),
        (b"CDF\x01" + b"\xff" * 30, "can't be read as NetCDF"),
        (b"CDF\x02", "can't be read as NetCDF"),
    ],
)
def test_netcdf_3_that_is_none(tmp_path: Path, content: bytes, expected: str) -> None:
    (tmp_path / "x.nc").write_bytes(content)
    with pytest.raises(InputError, match=expected) as caught:
        read_table(tmp_path / "x.nc")
    assert "\n" not in str(caught.value)


def test_plain_hdf5_with_a_clock_is_read_and_without_is_told(tmp_path: Path) -> None:
    with h5py.File(tmp_path / "x.h5", "w") as file:
        file["t"], file["force"] = np.arange(4.0), np.ones(4)
    assert columns(tmp_path / "x.h5") == {"t": [0.0, 1.0, 2.0, 3.0], "force": [1.0] * 4}
    with h5py.File(tmp_path / "y.h5", "w") as file:
        file.create_group("run")["t"] = np.arange(4.0)
    with pytest.raises(InputError, match=r"has no variable of time, and its groups \(run\) are not read"):
        read_table(tmp_path / "y.h5")


def test_a_file_is_read_by_what_it_begins_with(tmp_path: Path) -> None:
    path = of_parquet(tmp_path, time=[0.0, 0.1], force=[1.0, 2.0])
    path.rename(tmp_path / "log.dat")
    assert columns(tmp_path / "log.dat")["force"] == [1.0, 2.0]
