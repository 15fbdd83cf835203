"""Tables of arrays: Parquet, and NetCDF as `layflat simulate` writes it or from elsewhere."""

import gc
import sys
from collections.abc import Callable
from pathlib import Path
from typing import TypeVar

import numpy as np

from layflat import extras
from layflat.errors import InputError
from layflat.identify.logs.table import Cells

T = TypeVar("T")

LONGEST = 120  # characters of a library's own message that are passed on


def read_parquet(path: Path) -> tuple[dict[str, Cells], dict[str, str]]:
    """Columns of a Parquet file, units from metadata of its fields ("unit" or "units"); raise InputError if broken."""
    extras.require("logs", "pyarrow", where=str(path))
    import pyarrow  # noqa: PLC0415
    from pyarrow import parquet  # noqa: PLC0415

    table = _attempt(lambda: parquet.read_table(path), path, "Parquet")
    cells: dict[str, Cells] = {}
    units = {}
    for field in table.schema:
        kind, column = field.type, table.column(field.name).combine_chunks()
        if pyarrow.types.is_timestamp(kind):
            dates = np.asarray(column.cast(pyarrow.timestamp("ns"))).astype("datetime64[ns]")
            first = next(iter(dates[~np.isnat(dates)]), np.datetime64("NaT"))
            cells[field.name] = (dates - first) / np.timedelta64(1, "s")  # NaN where there is none
            units[field.name] = "s"
        elif pyarrow.types.is_integer(kind) or pyarrow.types.is_floating(kind) or pyarrow.types.is_boolean(kind):
            cells[field.name] = np.asarray(column.cast(pyarrow.float64()).to_numpy(zero_copy_only=False))
        elif pyarrow.types.is_string(kind) or pyarrow.types.is_dictionary(kind):
            cells[field.name] = [str(value) for value in column.to_pylist()]
        told = {key.decode(): value.decode() for key, value in (field.metadata or {}).items()}
        said = told.get("unit", told.get("units"))
        if said is not None:
            units[field.name] = said
    return cells, units


def _attempt(read: Callable[[], T], path: Path, kind: str) -> T:
    """Read a file; whatever a library raises becomes one line, as a damaged file can make it raise nearly anything."""
    hook = sys.unraisablehook
    sys.unraisablehook = lambda _: None  # files that were half opened complain when they are dropped
    try:
        return read()
    except Exception as error:
        what = " ".join(str(error).split())[:LONGEST] or type(error).__name__
    finally:
        gc.collect()
        sys.unraisablehook = hook
    right = f"give a whole {kind} file: this one is damaged, cut off, or of another kind"
    raise InputError(f"can't be read as {kind} ({what})", where=str(path), right=right)


def read_netcdf(path: Path) -> tuple[dict[str, Cells], dict[str, str]]:
    """Columns of a NetCDF file: variables over time, with joints as "angle.elbow"; raise InputError if it has none."""
    import xarray  # noqa: PLC0415  # takes long to import

    def read() -> xarray.Dataset:
        with xarray.open_dataset(path, engine="h5netcdf", decode_times=False) as opened:
            return opened.load()

    data = _attempt(read, path, "NetCDF")
    if "time" not in data.dims:
        raise InputError("has no dimension time", where=str(path), right="give a file with variables over time")
    cells: dict[str, Cells] = {}
    units = {}
    for name, variable in data.variables.items():
        if variable.dims[:1] != ("time",) or variable.dtype.kind not in "fiub" or variable.ndim > 2:
            continue
        values = np.asarray(variable.values, dtype=np.float64)
        if variable.ndim == 1:
            columns = {str(name): values}
        else:
            labels = data[variable.dims[1]].values if variable.dims[1] in data.coords else range(variable.shape[1])
            columns = {f"{name}.{label}": values[:, i] for i, label in enumerate(labels)}
        cells.update(columns)
        said = str(variable.attrs.get("units", "")).partition(" since ")[0]
        units.update(dict.fromkeys(columns, said))
    return cells, {name: unit for name, unit in units.items() if unit}
