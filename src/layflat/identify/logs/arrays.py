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
from layflat.identify.logs.arrangement import arrange_columns
from layflat.identify.logs.messages import MAX_ITEMS, error_reason
from layflat.identify.logs.table import Cells, FileContent

if TYPE_CHECKING:
    import xarray

T = TypeVar("T")

CLASSIC_MAGIC = b"CDF\x01"  # first bytes of NetCDF-3
CLASSIC_64_MAGIC = b"CDF\x02"  # of NetCDF-3 with 64-bit offsets
CDF5_MAGIC = b"CDF\x05"
FLOAT_FILL = 9.969209968386869e36
DEFAULT_FILL_VALUES = {"f4": FLOAT_FILL, "f8": FLOAT_FILL, "i4": -2147483647, "i8": -9223372036854775806}
"""Default fill values of NetCDF by type; those of shorter integers are left out, as they may be samples."""
TIME_NAMES = ("time", "t", "timestamp", "time_s")
TICK_SIZES = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9}  # size of the units of Arrow's times, s
SECONDS_PER_DAY = 86400.0  # s


def read_parquet(path: Path) -> FileContent:
    """Read a Parquet file, units from metadata of its fields ("unit" or "units"); raise InputError if broken.

    Times, dates and durations are seconds; structures and lists become columns "name.field" and "name.0".
    """
    extras.require("logs", "pyarrow", where=str(path))
    from pyarrow import parquet  # noqa: PLC0415

    table = _read_damaged(lambda: parquet.ParquetFile(path).read(), path, "Parquet")
    cells: dict[str, Cells] = {}
    units: dict[str, str] = {}
    left_out: dict[str, str] = {}
    for field, column in zip(table.schema, table.columns, strict=True):
        metadata = {key.decode(): value.decode(errors="replace") for key, value in (field.metadata or {}).items()}
        stated = metadata.get("unit", metadata.get("units"))
        columns = _read_damaged(partial(_list_columns, field.name, column), path, "Parquet")
        for name, values, unit in columns:
            if name in cells or name in left_out:
                raise InputError(f"has two columns named {name!r}", where=str(path), right="rename one of them")
            if unit is None:
                left_out[name] = str(values)
                continue
            cells[name] = values
            if unit or stated is not None:
                units[name] = unit or str(stated)
    content = arrange_columns(cells, units)
    return content._replace(words={**content.words, **left_out})


def _list_columns(name: str, column: Any) -> list[tuple[str, Any, str | None]]:
    return list(_arrow_columns(name, column))


def _arrow_columns(name: str, column: Any) -> Iterator[tuple[str, Any, str | None]]:
    """Yield name, cells and unit of each column that an Arrow column makes.

    The unit is "" where the type has none. Where it is None, the column holds no numbers, and the cells are a reason.
    """
    from pyarrow import BaseExtensionType, chunked_array, compute, float64, types  # noqa: PLC0415

    kind = column.type
    if types.is_dictionary(kind):
        yield from _arrow_columns(name, column.cast(kind.value_type))
    elif types.is_run_end_encoded(kind):
        yield from _arrow_columns(name, compute.run_end_decode(column.combine_chunks()))
    elif types.is_temporal(kind) and not types.is_interval(kind):
        yield name, _arrow_seconds(column), "s"
    elif types.is_primitive(kind) or types.is_decimal(kind) or types.is_null(kind):
        yield name, _floats(column.cast(float64(), safe=False)), ""
    elif types.is_string(kind) or types.is_large_string(kind) or types.is_string_view(kind):
        yield name, ["" if value is None else value for value in column.to_pylist()], ""
    elif isinstance(kind, BaseExtensionType):
        stored = chunked_array([chunk.storage for chunk in column.chunks], kind.storage_type)
        yield from _arrow_columns(name, stored)
    elif types.is_struct(kind):
        for i in range(kind.num_fields):
            yield from _arrow_columns(f"{name}.{kind.field(i).name}", compute.struct_field(column, i))
    elif types.is_list(kind) or types.is_large_list(kind) or types.is_fixed_size_list(kind):
        yield from _item_columns(name, column)
    else:
        yield name, f"is of type {kind}, which is no number", None


def _item_columns(name: str, column: Any) -> Iterator[tuple[str, Any, str | None]]:
    """Yield a column for each item of a column of lists, NaN where a list is shorter; a reason above `MAX_ITEMS`."""
    import pyarrow  # noqa: PLC0415

    rows = column.to_pylist()
    longest = max((len(row) for row in rows if row is not None), default=0)
    if longest > MAX_ITEMS:
        yield name, f"has {longest} items a row, and an array of more than {MAX_ITEMS} is no signal", None
        return
    for i in range(longest):
        items = [row[i] if row is not None and len(row) > i else None for row in rows]
        yield from _arrow_columns(f"{name}.{i}", pyarrow.chunked_array([pyarrow.array(items, column.type.value_type)]))


def _arrow_seconds(column: Any) -> Array:
    """Return durations and times of day in s, and dates as seconds since the first; NaN where there is none."""
    from pyarrow import int32, int64, types  # noqa: PLC0415

    kind = column.type
    days = types.is_date32(kind)
    unit_size = SECONDS_PER_DAY if days else 1e-3 if types.is_date64(kind) else TICK_SIZES[kind.unit]
    integers = column.cast(int32()).cast(int64()) if days or types.is_time32(kind) else column.cast(int64())
    ticks = integers.drop_null().to_numpy()
    dated = types.is_timestamp(kind) or types.is_date(kind)
    seconds = np.full(len(integers), np.nan)
    seconds[integers.is_valid().to_numpy()] = (ticks - ticks[0] if dated and ticks.size else ticks) * unit_size
    return seconds


def _floats(column: Any) -> Array:
    return np.asarray(column.to_numpy(), dtype=np.float64)


def _read_damaged(read: Callable[[], T], path: Path, format_name: str) -> T:
    """Return the result of `read`; whatever it raises becomes an InputError, as damaged files can raise any error."""
    reason, hook = None, sys.unraisablehook
    sys.unraisablehook = lambda _: None  # files that were half opened complain when they are dropped
    try:
        return read()
    except Exception as error:
        reason = error_reason(error)
    finally:
        if reason is not None:  # collecting takes long in a program with much in memory
            gc.collect()
        sys.unraisablehook = hook
    right = f"give a whole {format_name} file: this one is damaged, cut off, or of another kind"
    raise InputError(f"can't be read as {format_name} ({reason})", where=str(path), right=right)


def read_netcdf(path: Path) -> FileContent:
    """Read a NetCDF file: variables over time, those of joints as "angle.elbow".

    Raises:
        InputError: the file is damaged, of the kind CDF-5, or has no variable of time.
    """
    with path.open("rb") as file:
        magic = file.read(4)
    if magic == CDF5_MAGIC:
        right = f"convert it: `nccopy -k nc4 {path.name} NEW.nc`"
        raise InputError("is NetCDF of the kind CDF-5, which is not read here", where=str(path), right=right)
    data, groups = _read_damaged(
        lambda: _open_netcdf(path, classic=magic in {CLASSIC_MAGIC, CLASSIC_64_MAGIC}), path, "NetCDF"
    )
    dimension = _time_dimension(data)
    if dimension is None:
        problem = "has no variable of time" + (f", and its groups ({', '.join(groups)}) are not read" if groups else "")
        right = 'give a file with variables over a dimension "time"'
        raise InputError(problem, where=str(path), right=right)
    content = list_dataset(data, dimension)
    left_out = {f"group {name}": "variables in groups are not read: put them at the top" for name in groups}
    return content._replace(words={**content.words, **left_out})


def list_dataset(data: "xarray.Dataset", dimension: str = "time") -> FileContent:
    """Return the columns of a data set's variables over a dimension, those of joints as "angle.elbow"."""
    cells: dict[str, Cells] = {}
    units: dict[str, str] = {}
    left_out: dict[str, str] = {}
    for name, stored in data.variables.items():
        variable = stored.transpose(dimension, ...) if dimension in stored.dims else stored
        reason = _exclusion_reason(str(name), variable, data, dimension)
        if reason is not None:
            left_out |= {str(name): reason} if reason else {}
            continue
        values = _mask_unwritten(variable)
        if variable.ndim == 1:
            columns = {str(name): values}
        else:
            labels = data[variable.dims[1]].values if variable.dims[1] in data.coords else range(variable.shape[1])
            columns = {f"{name}.{_label_text(label)}": values[:, i] for i, label in enumerate(labels)}
        cells.update(columns)
        stated = str(variable.attrs.get("units", "")).partition(" since ")[0]
        units.update(dict.fromkeys(columns, stated))
    content = arrange_columns(cells, {name: unit for name, unit in units.items() if unit})
    return content._replace(words={**content.words, **left_out})


def _open_netcdf(path: Path, *, classic: bool) -> "tuple[xarray.Dataset, list[str]]":
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
    """Return the dimension of the samples: "time", or that of a variable of time; None where there is none."""
    if "time" in data.dims:
        return "time"
    lines = {str(name): variable for name, variable in data.variables.items() if variable.ndim == 1}
    named = [variable for name, variable in lines.items() if name.lower() in TIME_NAMES]
    dated = [variable for variable in lines.values() if " since " in str(variable.attrs.get("units", ""))]
    return next((str(variable.dims[0]) for variable in [*named, *dated]), None)


def _exclusion_reason(name: str, variable: "xarray.Variable", data: "xarray.Dataset", dimension: str) -> str | None:
    """Return why a variable makes no column; None for one that does, "" for labels and constants."""
    if variable.dims[:1] == (dimension,):
        if variable.dtype.kind not in "fiub":
            return f"is of type {variable.dtype}, which is no number"
        if variable.ndim > 2:
            return f"has {variable.ndim} dimensions"
        too_many = variable.ndim == 2 and variable.shape[1] > MAX_ITEMS
        return f"has {variable.shape[1]} items each, and more than {MAX_ITEMS} are no signal" if too_many else None
    other = next(iter(variable.dims), None)
    clocked = other is not None and other != name and other in data.indexes and data[other].dtype.kind in "fiu"
    return f"goes along {other!r}, and the clock along {dimension!r}" if clocked and variable.ndim == 1 else ""


def _mask_unwritten(variable: "xarray.Variable") -> Array:
    """Return the values of a variable with NaN for NetCDF's default fill value, which xarray leaves."""
    values = np.asarray(variable.values, dtype=np.float64)
    encoding = variable.encoding
    fill = DEFAULT_FILL_VALUES.get(np.dtype(encoding.get("dtype", variable.dtype)).str[1:])
    if fill is None or "_FillValue" in encoding:
        return values
    return np.where(
        values == fill * encoding.get("scale_factor", 1.0) + encoding.get("add_offset", 0.0), np.nan, values
    )


def _label_text(label: object) -> str:
    return label.decode(errors="replace").strip("\0 ") if isinstance(label, bytes) else str(label)
