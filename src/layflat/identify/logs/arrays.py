"""Tables of arrays: Parquet, and NetCDF as `layflat simulate` writes it or from elsewhere."""

import gc
import sys
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from layflat import extras
from layflat.arrays import Array
from layflat.errors import InputError
from layflat.identify.logs.arrangement import arranged
from layflat.identify.logs.messages import MAX_ITEMS, reason_of
from layflat.identify.logs.table import Cells, Content

if TYPE_CHECKING:
    import xarray

T = TypeVar("T")

CLASSIC, CLASSIC_64, CDF5 = b"CDF\x01", b"CDF\x02", b"CDF\x05"  # first bytes of NetCDF-3, with 64-bit offsets, of CDF-5
FLOAT_FILL = 9.969209968386869e36
UNWRITTEN = {"f4": FLOAT_FILL, "f8": FLOAT_FILL, "i4": -2147483647, "i8": -9223372036854775806}
"""Fill values of NetCDF where a file states none, by type; those of shorter integers may be samples."""
TIME_NAMES = ("time", "t", "timestamp", "time_s")
TICKS = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9}  # units of Arrow's times, s
DAY = 86400.0  # s


def read_parquet(path: Path) -> Content:
    """Read a Parquet file, units from metadata of its fields ("unit" or "units"); raise InputError if broken.

    Times, dates and durations are seconds; structures and lists become columns "name.field" and "name.0".
    """
    extras.require("logs", "pyarrow", where=str(path))
    from pyarrow import parquet  # noqa: PLC0415

    table = _attempt(lambda: parquet.ParquetFile(path).read(), path, "Parquet")
    cells: dict[str, Cells] = {}
    units: dict[str, str] = {}
    left_out: dict[str, str] = {}
    for field, column in zip(table.schema, table.columns, strict=True):
        told = {key.decode(): value.decode(errors="replace") for key, value in (field.metadata or {}).items()}
        stated = told.get("unit", told.get("units"))
        columns = _attempt(partial(_listed_columns, field.name, column), path, "Parquet")
        for name, found, unit in columns:
            if name in cells or name in left_out:
                raise InputError(f"column {name!r} stands there twice", where=str(path), right="rename one of them")
            if unit is None:
                left_out[name] = str(found)
                continue
            cells[name] = found
            if unit or stated is not None:
                units[name] = unit or str(stated)
    content = arranged(cells, units)
    return content._replace(words={**content.words, **left_out})


def _listed_columns(name: str, column: Any) -> list[tuple[str, Any, str | None]]:
    return list(_columns(name, column))


def _columns(name: str, column: Any) -> Iterator[tuple[str, Any, str | None]]:
    """Yield name, cells and unit ("" where the type has none) of an Arrow column; what makes none, with its reason.

    Unit None says that the cells are a reason.
    """
    from pyarrow import BaseExtensionType, chunked_array, compute, float64, types  # noqa: PLC0415

    kind = column.type
    if types.is_dictionary(kind):
        yield from _columns(name, column.cast(kind.value_type))
    elif types.is_run_end_encoded(kind):
        yield from _columns(name, compute.run_end_decode(column.combine_chunks()))
    elif types.is_temporal(kind) and not types.is_interval(kind):
        yield name, _seconds(column), "s"
    elif types.is_primitive(kind) or types.is_decimal(kind) or types.is_null(kind):
        yield name, _floats(column.cast(float64(), safe=False)), ""
    elif types.is_string(kind) or types.is_large_string(kind) or types.is_string_view(kind):
        yield name, ["" if value is None else value for value in column.to_pylist()], ""
    elif isinstance(kind, BaseExtensionType):
        stored = chunked_array([chunk.storage for chunk in column.chunks], kind.storage_type)
        yield from _columns(name, stored)
    elif types.is_struct(kind):
        for i in range(kind.num_fields):
            yield from _columns(f"{name}.{kind.field(i).name}", compute.struct_field(column, i))
    elif types.is_list(kind) or types.is_large_list(kind) or types.is_fixed_size_list(kind):
        yield from _listed(name, column)
    else:
        yield name, f"is of type {kind}, which is no number", None


def _listed(name: str, column: Any) -> Iterator[tuple[str, Any, str | None]]:
    """Yield the columns of a column of lists, an item each; shorter lists have nothing in the last ones."""
    import pyarrow  # noqa: PLC0415

    rows = column.to_pylist()
    longest = max((len(row) for row in rows if row is not None), default=0)
    if longest > MAX_ITEMS:
        yield name, f"has {longest} items a row, and an array of more than {MAX_ITEMS} is no signal", None
        return
    for i in range(longest):
        items = [row[i] if row is not None and len(row) > i else None for row in rows]
        yield from _columns(f"{name}.{i}", pyarrow.chunked_array([pyarrow.array(items, column.type.value_type)]))


def _seconds(column: Any) -> Array:
    """Return durations and times of day in s, and dates as seconds since the first; NaN where there is none."""
    from pyarrow import int32, int64, types  # noqa: PLC0415

    kind = column.type
    days = types.is_date32(kind)
    size = DAY if days else 1e-3 if types.is_date64(kind) else TICKS[kind.unit]
    whole = column.cast(int32()).cast(int64()) if days or types.is_time32(kind) else column.cast(int64())
    ticks = whole.drop_null().to_numpy()
    dated = types.is_timestamp(kind) or types.is_date(kind)
    seconds = np.full(len(whole), np.nan)
    seconds[whole.is_valid().to_numpy()] = (ticks - ticks[0] if dated and ticks.size else ticks) * size
    return seconds


def _floats(column: Any) -> Array:
    return np.asarray(column.to_numpy(), dtype=np.float64)


def _attempt(read: Callable[[], T], path: Path, kind: str) -> T:
    """Read a file; whatever a library raises becomes one line, as a damaged file can make it raise nearly anything."""
    what, hook = None, sys.unraisablehook
    sys.unraisablehook = lambda _: None  # files that were half opened complain when they are dropped
    try:
        return read()
    except Exception as error:
        what = reason_of(error)
    finally:
        if what is not None:  # to look for them takes long beside all that a program has in memory
            gc.collect()
        sys.unraisablehook = hook
    right = f"give a whole {kind} file: this one is damaged, cut off, or of another kind"
    raise InputError(f"can't be read as {kind} ({what})", where=str(path), right=right)


def read_netcdf(path: Path) -> Content:
    """Read a NetCDF file: variables over time, with joints as "angle.elbow"; raise InputError if it has none."""
    with path.open("rb") as file:
        start = file.read(4)
    if start == CDF5:
        right = f"`nccopy -k nc4 {path.name} NEW.nc` makes one that is"
        raise InputError("is NetCDF of the kind CDF-5, which is not read here", where=str(path), right=right)
    data, groups = _attempt(lambda: _opened(path, classic=start in {CLASSIC, CLASSIC_64}), path, "NetCDF")
    along = _time_dimension(data)
    if along is None:
        what = "has no variable of time" + (f", and its groups ({', '.join(groups)}) are not read" if groups else "")
        right = 'give a file with variables over a dimension "time"'
        raise InputError(what, where=str(path), right=right)
    cells: dict[str, Cells] = {}
    units: dict[str, str] = {}
    left_out = {f"group {name}": "variables in groups are not read: put them at the top" for name in groups}
    for name, stored in data.variables.items():
        variable = stored.transpose(along, ...) if along in stored.dims else stored
        reason = _reason(str(name), variable, data, along)
        if reason is not None:
            left_out |= {str(name): reason} if reason else {}
            continue
        values = _written(variable)
        if variable.ndim == 1:
            columns = {str(name): values}
        else:
            labels = data[variable.dims[1]].values if variable.dims[1] in data.coords else range(variable.shape[1])
            columns = {f"{name}.{_label(label)}": values[:, i] for i, label in enumerate(labels)}
        cells.update(columns)
        stated = str(variable.attrs.get("units", "")).partition(" since ")[0]
        units.update(dict.fromkeys(columns, stated))
    content = arranged(cells, {name: unit for name, unit in units.items() if unit})
    return content._replace(words={**content.words, **left_out})


def _opened(path: Path, *, classic: bool) -> "tuple[xarray.Dataset, list[str]]":
    """Return the variables at the top of a file, and the names of its groups."""
    import h5py  # noqa: PLC0415
    import xarray  # noqa: PLC0415  # takes long to import

    options: dict[str, Any] = {"engine": "scipy"} if classic else {"engine": "h5netcdf", "phony_dims": "sort"}
    with xarray.open_dataset(path, decode_times=False, **options) as opened:
        data = opened.load()
    if classic:
        return data, []
    with h5py.File(path) as file:
        return data, [name for name, entry in file.items() if isinstance(entry, h5py.Group)]


def _time_dimension(data: "xarray.Dataset") -> str | None:
    """Return the dimension that samples go along: "time", or that of a variable of time; None where there is none."""
    if "time" in data.dims:
        return "time"
    lines = {str(name): variable for name, variable in data.variables.items() if variable.ndim == 1}
    named = [variable for name, variable in lines.items() if name.lower() in TIME_NAMES]
    dated = [variable for variable in lines.values() if " since " in str(variable.attrs.get("units", ""))]
    return next((str(variable.dims[0]) for variable in [*named, *dated]), None)


def _reason(name: str, variable: "xarray.Variable", data: "xarray.Dataset", along: str) -> str | None:
    """Return why a variable makes no column, or None for one that does; nothing for labels and constants."""
    if variable.dims[:1] == (along,):
        if variable.dtype.kind not in "fiub":
            return f"is of type {variable.dtype}, which is no number"
        if variable.ndim > 2:
            return f"has {variable.ndim} dimensions"
        many = variable.ndim == 2 and variable.shape[1] > MAX_ITEMS
        return f"has {variable.shape[1]} items each, and more than {MAX_ITEMS} are no signal" if many else None
    other = next(iter(variable.dims), None)
    clocked = other is not None and other != name and other in data.indexes and data[other].dtype.kind in "fiu"
    return f"goes along {other!r}, and the clock along {along!r}" if clocked and variable.ndim == 1 else ""


def _written(variable: "xarray.Variable") -> Array:
    """Return the values of a variable, NaN where nothing was written: xarray shows NetCDF's own fill value."""
    values = np.asarray(variable.values, dtype=np.float64)
    stored = variable.encoding
    fill = UNWRITTEN.get(np.dtype(stored.get("dtype", variable.dtype)).str[1:])
    if fill is None or "_FillValue" in stored:
        return values
    return np.where(values == fill * stored.get("scale_factor", 1.0) + stored.get("add_offset", 0.0), np.nan, values)


def _label(label: object) -> str:
    return label.decode(errors="replace").strip("\0 ") if isinstance(label, bytes) else str(label)
