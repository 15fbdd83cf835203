"""DataFrames, Series and DataArrays as signals."""

from math import radians
from typing import Any

import numpy as np
import pytest
import xarray

from layflat.arrays import Array
from layflat.description import units as u
from layflat.errors import InputError
from layflat.motion.signal_rows import expand_signal
from layflat.motion.signal_values import Sampling, SignalKind, single_kind

pandas = pytest.importorskip("pandas")

DEMAND = SignalKind("demand", u.ANGLE, ["large", "small"])
STEPS = [(0.0, {"large": 0.1, "small": 0.2}), (0.5, {"large": 0.3, "small": 0.4})]
VALUES = {"large": [0.1, 0.3], "small": [0.2, 0.4]}


def rows(signal: Any, kind: SignalKind = DEMAND) -> Array:
    return expand_signal(signal, kind, np.full(len(kind.names), 0.05), Sampling(0.005, 200))


def frame(index: Any = (0.0, 0.5), **columns: Any) -> Any:
    return pandas.DataFrame(columns or VALUES, index=list(index) if isinstance(index, tuple) else index)


def array(values: Any, **attrs: Any) -> Any:
    return xarray.DataArray(values, {"time": [0.0, 0.5], "joint": ["large", "small"]}, ("time", "joint"), attrs=attrs)


@pytest.mark.parametrize(
    "index",
    [
        (0.0, 0.5),
        ("0 s", "500 ms"),
        pandas.to_timedelta([0, 500], unit="ms"),
        pandas.Index([0.0, 0.5], dtype="float32"),
    ],
)
def test_a_frame_means_the_steps_that_it_shows(index: Any) -> None:
    assert np.array_equal(rows(frame(index)), rows(STEPS))


def test_columns_and_units_go_by_their_names() -> None:
    assert np.array_equal(rows(frame()[["small", "large"]]), rows(STEPS))
    assert np.array_equal(rows(frame(large=[0.1, 0.3])), rows([(0.0, {"large": 0.1}), (0.5, {"large": 0.3})]))
    degrees = frame(large=["10 deg", "20 deg"])
    assert np.array_equal(rows(degrees), rows([(0.0, {"large": "10 deg"}), (0.5, {"large": "20 deg"})]))
    told = frame(large=[10.0, 20.0])
    told.attrs["units"] = {"large": "deg"}
    assert rows(told) == pytest.approx(rows(degrees))
    assert rows(array([[10.0, 0.0], [20.0, 0.0]], units="deg"))[-1] == pytest.approx([radians(20.0), 0.0])


def test_series_are_by_time_or_by_joint() -> None:
    assert np.array_equal(rows(pandas.Series([0.1, 0.2], ["large", "small"])), rows([0.1, 0.2]))
    assert np.array_equal(rows(pandas.Series([0.1, 0.2], [0.0, 0.5])), rows([(0.0, 0.1), (0.5, 0.2)]))
    assert np.array_equal(
        rows(pandas.Series(["1 deg", "2 deg"], ["0 s", "0.5 s"])), rows([(0, "1 deg"), (0.5, "2 deg")])
    )
    payload = single_kind("payload", u.MASS)
    assert rows(pandas.Series([1.0, 2.0], [0.0, 0.5]), payload)[-1] == 2.0
    assert rows(pandas.DataFrame({"payload": [1.0, 2.0]}, [0.0, 0.5]), payload)[0] == 1.0


def test_arrays_go_by_their_dimensions() -> None:
    values = np.array([[0.1, 0.2], [0.3, 0.4]])
    assert np.array_equal(rows(array(values)), rows(STEPS))
    assert np.array_equal(rows(array(values).T), rows(STEPS))
    assert np.array_equal(rows(array(values).isel(time=1)), rows([0.3, 0.4]))
    assert np.array_equal(rows(array(values).isel(joint=0)), rows([(0.0, 0.1), (0.5, 0.3)]))
    assert np.all(rows(array(values).isel(joint=0, time=0)) == 0.1)
    milliseconds = array(values).assign_coords(time=("time", [0.0, 500.0], {"units": "ms"}))
    assert np.array_equal(rows(milliseconds), rows(STEPS))
    whole = xarray.DataArray(np.zeros(201), {"time": 0.005 * np.arange(201)}, ("time",))  # a run's last record, too
    assert np.all(rows(whole) == 0.0)


def with_units(table: Any, units: Any, key: str = "units") -> Any:
    table.attrs[key] = units
    return table


@pytest.mark.parametrize("name", ["t_ms", "time [ms]", "time (ms)", "ms"])
def test_times_are_in_the_unit_that_the_index_names(name: str) -> None:
    given = frame(pandas.Index([0.0, 500.0], name=name))
    assert np.array_equal(rows(given), rows(frame((0.0, 0.5))))
    assert np.array_equal(rows(frame(pandas.Index([0.0, 0.5], name="time"))), rows(frame((0.0, 0.5))))


@pytest.mark.parametrize("key", ["units", "unit", "Units", "UNIT"])
def test_a_unit_counts_however_its_attribute_is_spelt(key: str) -> None:
    degrees = frame(large=[10.0, 20.0], small=[0.0, 0.0])
    radians = frame(large=np.radians([10.0, 20.0]), small=[0.0, 0.0])
    assert np.allclose(rows(with_units(degrees, "deg", key)), rows(radians), rtol=1e-15)


@pytest.mark.parametrize(
    ("signal", "expected"),
    [
        (frame(wrist=[0.0, 1.0]), "unknown joint 'wrist'; joints are large, small"),
        (frame(time=[0.0, 1.0]), "has its times in the column 'time', not in its index; set it as the index"),
        (pandas.DataFrame(VALUES), "has row numbers in place of times"),
        (frame((0.0, 1.2)), "its last row, at 1.2 s, is after the end; the run ends at 1 s"),
        (frame((0.5, 0.0)), "its times must begin at 0 or later, and increase"),
        (frame((-0.5, 0.0)), "its times must begin at 0 or later, and increase"),
        (frame((0.0, float("nan"))), "is not finite"),
        (frame(pandas.to_datetime(["2024-01-01", "2024-01-02"])), "has dates as times; give times since the start"),
        (frame((True, False)), "has times of type bool"),
        (frame(("soon", "later")), "is not one number with one unit"),
        (frame(large=[0.1, float("nan")]), "holds a value that is not finite"),
        (frame(large=[0.1, 1j]), "an array of complex128 holds no numbers"),
        (frame(large=[True, False]), "an array of bool holds no numbers"),
        (frame(large=["1 kg", "2 kg"]), "'1 kg' is not an angle"),
        (frame(large=pandas.array([1, None], dtype="Int64")), "is not"),
        (pandas.DataFrame([[0.1, 0.2]], [0.0], ["large", "large"]), "has 'large' twice"),
        (pandas.DataFrame([[0.1]], [0.0], pandas.MultiIndex.from_tuples([("a", "b")])), "labels of several levels"),
        (pandas.DataFrame({"large": []}, []), "is an empty table"),
        (pandas.Series([0.1, 0.2], ["large", "wrist"]), "unknown joint 'wrist'"),
        (pandas.Index([0.0, 1.0]), "is no signal"),
        (xarray.Dataset({"demand": ("time", [0.1])}), "a Dataset is no signal; give one of its variables"),
        (xarray.DataArray([0.1, 0.2]), "has a dimension 'dim_0'; dimensions are time and joint"),
        (xarray.DataArray([0.1, 0.2], dims="time"), "has no coordinate 'time'"),
        (xarray.DataArray([[0.1, 0.2]], {"time": [0.0]}, ("time", "joint")), "has no coordinate 'joint'"),
        (array([[0.1, 0.2], [0.3, 0.4]], units="bar"), "'1 bar' is not an angle"),
        (array([[0.1, 0.2], [0.3, 0.4]], Unit="bar"), "'1 bar' is not an angle"),
        (array([[0.1, 0.2], [0.3, 0.4]], unit="deg", units="rad"), "has attributes unit and units; give one: units"),
        (with_units(frame(), {"lareg": "deg"}), "unknown joint 'lareg'"),
        (frame(pandas.Index([0.0, 0.5], name="t [m]")), "'1 m' is not a time"),
        (frame(pandas.to_datetime(["2024-01-01", "2024-01-02"]).tz_localize("UTC")), "has dates as times"),
    ],
)
def test_tables_that_are_no_signals_are_named(signal: Any, expected: str) -> None:
    with pytest.raises(InputError) as caught:
        rows(signal)
    assert str(caught.value).startswith("demand: ")
    assert expected in str(caught.value)
    assert "\n" not in str(caught.value)


def test_rows_between_the_cycles_are_not_lost_silently() -> None:
    times = 0.001 * np.arange(1000)
    slow, fast = (pandas.Series(np.sin(2.0 * np.pi * f * times + 0.3), times) for f in (3.0, 230.0))
    assert np.array_equal(rows(slow)[:, 0], slow.to_numpy()[::5])
    with pytest.raises(InputError, match="changes faster than control cycles of 5 ms can follow"):
        rows(fast)
