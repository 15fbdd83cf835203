"""Signals in labelled tables: DataFrames and Series of pandas, DataArrays of xarray, with joints as labels.

Neither library is imported here: a caller with such a table has imported it.
"""

import re
from typing import Any

import numpy as np
from numpy.typing import NDArray

from layflat.arrays import Array
from layflat.description import units as u
from layflat.errors import InputError
from layflat.motion.signal_values import SignalKind, check_names, check_real, read_number

SIGNAL_CLASSES = {("pandas", "DataFrame"), ("pandas", "Series"), ("xarray", "DataArray")}
OTHER_CLASSES = {("xarray", "Dataset"), ("pandas", "Index")}  # that are no signals
UNIT_KEYS = {"unit", "units"}
UNIT_IN_NAME = re.compile(r".*[\[(](?P<bracketed>[^\])]*)[\])]|(?:.*_)?(?P<bare>[^\W\d_]+)")
"""Name of an index that ends in a unit: "time [ms]", "t (ms)", "t_ms", "ms"."""

UNITS_OF_TIME = {"ms": 1e-3, "us": 1e-6, "ns": 1e-9}  # as bare words in names, s; "min" and "h" are ambiguous

TIMES_ADVICE = "give times as numbers in s, as timedeltas, or as texts with units"


def is_labelled(signal: object) -> bool:
    """Return whether a value is a table of pandas or xarray, also one that is no signal (Dataset, Index)."""
    return bool((SIGNAL_CLASSES | OTHER_CLASSES) & _class_names(signal))


def read_labelled_row(signal: Any, kind: SignalKind) -> Any:
    """Return the constant values of a table without times, by name or a single one; None for a table with times.

    Numbers are in SI units; texts are returned as they are.

    Raises:
        InputError: the table is no signal; it has other dimensions than time and names, no coordinate, a label twice,
            an unknown name, or a wrong unit or value.
    """
    classes = _class_names(signal)
    if not SIGNAL_CLASSES & classes:
        raise InputError(f"a {type(signal).__name__} is no signal", where=kind.where, right="give one of its variables")
    if ("xarray", "DataArray") in classes:
        return _read_array_row(signal, kind)
    _refuse_levels(signal.index, kind)
    if ("pandas", "Series") in classes and len(signal) and all(map(_is_name, signal.index)):
        check_names(signal.index, kind)
        _refuse_repeated(signal.index, kind)
        scale = _unit_factor(_read_unit(signal, kind), kind)
        return {name: _scale_value(value, scale, kind) for name, value in signal.items()}
    return None


def read_labelled_steps(signal: Any, kind: SignalKind) -> tuple[Array, Array]:
    """Return the times (s) of a table's rows, and its values (rows, names) in SI units, NaN for names that it lacks.

    Raises:
        InputError: times or values are missing, of a wrong type or not finite, or a name is unknown.
    """
    classes = _class_names(signal)
    if ("xarray", "DataArray") in classes:
        columns, times = _read_array_columns(signal, kind)
    elif ("pandas", "Series") in classes:
        columns, times = dict.fromkeys(kind.names, signal.to_numpy()), signal.index
        columns = {
            name: _read_values(values, _unit_factor(_read_unit(signal, kind), kind), kind)
            for name, values in columns.items()
        }
    else:
        _refuse_levels(signal.columns, kind)
        _refuse_repeated(signal.columns, kind)
        _check_columns(signal, kind)
        units = _read_unit(signal, kind)
        each = units if isinstance(units, dict) else dict.fromkeys(signal.columns, units)
        check_names(each, kind)
        columns = {
            name: _read_values(signal[name].to_numpy(), _unit_factor(each.get(name), kind), kind)
            for name in signal.columns
        }
        times = signal.index
    if not columns or not len(times):
        raise InputError("is an empty table", where=kind.where, right="give a row for each time")
    rows = np.full((len(times), len(kind.names)), np.nan)
    for name, values in columns.items():
        rows[:, kind.names.index(name)] = values
    return _read_times(times, kind.where), rows


def _is_name(label: object) -> bool:
    """Return whether a label is a name rather than a time such as "0.5 s"."""
    return isinstance(label, str) and label.strip()[:1].strip("+-.0123456789") != ""


def _class_names(signal: object) -> set[tuple[str, str]]:
    """Return package and name of a value's class and its bases."""
    return {(base.__module__.partition(".")[0], base.__name__) for base in type(signal).__mro__}


def _read_array_row(array: Any, kind: SignalKind) -> Any:
    """Return a DataArray without times as a value, or as values by name; None if it has times.

    Raise InputError for a dimension other than time and names, one without a coordinate, or a repeated label.
    """
    odd = [name for name in array.dims if name not in {"time", kind.noun}]
    if odd:
        right = f"dimensions are time and {kind.noun}" if kind.noun else "its dimension is time"
        raise InputError(f"has a dimension {odd[0]!r}", where=kind.where, right=right)
    for name in array.dims:
        if name not in array.coords:
            right = TIMES_ADVICE if name == "time" else f"name its {kind.noun}: {', '.join(kind.names)}"
            raise InputError(f"has no coordinate {name!r}", where=kind.where, right=right)
    if "time" in array.dims:
        return None
    scale = _unit_factor(_read_unit(array, kind), kind)
    if not array.dims:
        return _scale_value(array.to_numpy()[()], scale, kind)
    labels = array[kind.noun].to_numpy().tolist()
    _refuse_repeated(labels, kind)
    return {name: _scale_value(value, scale, kind) for name, value in zip(labels, array.to_numpy(), strict=True)}


def _read_array_columns(array: Any, kind: SignalKind) -> tuple[dict[str, Array], Any]:
    """Return the columns of a DataArray by name, and its times (s, or labels); without names, all have its values.

    Raise InputError for an unknown or repeated name, a wrong unit, or values that are not finite numbers or texts.
    """
    scale, time = _unit_factor(_read_unit(array, kind), kind), array["time"]
    times = time.to_numpy()
    if times.dtype.kind in "iuf":
        times = times * _unit_factor(_read_unit(time, kind), SignalKind(kind.where, u.TIME, ()))
    if kind.noun not in array.dims:
        return dict.fromkeys(kind.names, _read_values(array.to_numpy(), scale, kind)), times
    labels = array[kind.noun].to_numpy().tolist()
    _refuse_repeated(labels, kind)
    check_names(labels, kind)
    values = array.transpose("time", kind.noun).to_numpy()
    return {name: _read_values(values[:, j], scale, kind) for j, name in enumerate(labels)}, times


def _check_columns(frame: Any, kind: SignalKind) -> None:
    """Raise InputError if a DataFrame has its times in a column "time", or columns of unknown names."""
    if "time" in frame.columns and "time" not in kind.names:
        right = 'set it as the index: frame.set_index("time")'
        raise InputError("has its times in the column 'time', not in its index", where=kind.where, right=right)
    check_names(frame.columns, kind)


def _refuse_levels(index: Any, kind: SignalKind) -> None:
    """Raise InputError if an index of pandas has several levels."""
    if index.nlevels > 1:
        raise InputError("has labels of several levels", where=kind.where, right="give one level of names")


def _refuse_repeated(labels: Any, kind: SignalKind) -> None:
    """Raise InputError if a label is there twice."""
    names = list(labels)
    twice = next((name for name in names if names.count(name) > 1), None)
    if twice is not None:
        raise InputError(f"has {twice!r} twice", where=kind.where, right="give each once")


def _read_unit(table: Any, kind: SignalKind) -> Any:
    """Return the unit in a table's attribute `units` or `unit`; None if it has neither; raise InputError for both."""
    units = {key: unit for key, unit in table.attrs.items() if isinstance(key, str) and key.lower() in UNIT_KEYS}
    if len(units) > 1:
        raise InputError(f"has attributes {' and '.join(units)}", where=kind.where, right="give one: units")
    return next(iter(units.values()), None)


def _unit_factor(unit: object, kind: SignalKind) -> float:
    """Return the factor from a unit to SI, 1 for None; raise InputError if it is no unit of the signal."""
    if unit is None or (kind.quantity is None and unit in {"", "1"}):
        return 1.0
    if kind.quantity is None:
        raise InputError(f"is in {unit}", where=kind.where, right="give numbers without unit")
    if unit == kind.quantity.unit:
        return 1.0
    return read_number(f"1 {unit}", kind.quantity, kind.where)


def _scale_value(value: Any, scale: float, kind: SignalKind) -> Any:
    return value if isinstance(value, str) else scale * read_number(value, kind.quantity, kind.where)


def _read_values(values: NDArray[Any], scale: float, kind: SignalKind) -> Array:
    """Return the values of a column, in SI units; raise InputError if they are not finite numbers or texts."""
    if values.ndim != 1:
        raise InputError("has several values in a row of a column", where=kind.where, right="give one value a row")
    check_real(values, kind)
    if values.dtype.kind in "UO":
        return np.array([read_number(_scale_value(v, scale, kind), kind.quantity, kind.where) for v in values.tolist()])
    if not np.isfinite(values).all():
        raise InputError("holds a value that is not finite", where=kind.where, right="give numbers only")
    return scale * values.astype(np.float64)


def _read_times(index: Any, where: str) -> Array:
    """Return the times of an index, s, increasing from zero or later; raise InputError for others."""
    if type(index).__name__ == "RangeIndex" and index.start == 0 and index.step == 1:
        raise InputError("has row numbers in place of times", where=where, right=f"{TIMES_ADVICE}, as its index")
    labels = np.asarray(index)
    if getattr(index, "tz", None) is not None or labels.dtype.kind == "M":
        right = "give times since the start: frame.index - frame.index[0]"
        raise InputError("has dates as times", where=where, right=right)
    if labels.dtype.kind == "m":
        times = labels / np.timedelta64(1, "s")
    elif labels.dtype.kind in "iufUOT":
        scale = _factor_in_name(getattr(index, "name", None), where)
        times = np.array(
            [
                read_number(x, u.TIME, where) if isinstance(x, str) else scale * read_number(x, u.TIME, where)
                for x in labels.tolist()
            ]
        )
    else:
        raise InputError(f"has times of type {labels.dtype}", where=where, right=TIMES_ADVICE)
    if not np.isfinite(times).all():
        raise InputError("has a time that is not finite", where=where, right=TIMES_ADVICE)
    if times[0] < 0.0 or np.any(np.diff(times) <= 0.0):
        raise InputError("its times must begin at 0 or later, and increase", where=where, right=TIMES_ADVICE)
    return np.asarray(times, dtype=np.float64)


def _factor_in_name(name: object, where: str) -> float:
    """Return the factor to s of the unit in an index's name; 1 without brackets or a word of `UNITS_OF_TIME`."""
    match = UNIT_IN_NAME.fullmatch(name.strip()) if isinstance(name, str) else None
    if match is None:
        return 1.0
    if match["bracketed"] is not None:
        return read_number(f"1 {match['bracketed']}", u.TIME, where)
    return UNITS_OF_TIME.get(match["bare"], 1.0)
