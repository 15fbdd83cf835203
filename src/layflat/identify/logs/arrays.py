"""Tables of arrays: Parquet, and NetCDF as `layflat simulate` writes it or from elsewhere."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from layflat import extras
from layflat.errors import InputError
from layflat.identify.logs.table import Array, Cells


def read_parquet(path: Path) -> tuple[dict[str, Cells], dict[str, str]]:
    """Columns of a Parquet file by name, and the units that its fields carry as metadata ("unit" or "units").

    Raises:
        InputError: it is none, or pyarrow is not installed.
    """
    extras.require("logs", "pyarrow", where=str(path))
    import pyarrow  # noqa: PLC0415
    from pyarrow import parquet  # noqa: PLC0415

    try:
        table = parquet.read_table(path)
    except (pyarrow.ArrowException, OSError) as error:
        text = str(error).splitlines()[0]
        raise InputError(f"can't be read as Parquet ({text})", where=str(path), right="give a Parquet file") from None
    cells: dict[str, Cells] = {}
    units = {}
    for field in table.schema:
        kind, column = field.type, table.column(field.name).combine_chunks()
        if pyarrow.types.is_timestamp(kind):
            cells[field.name] = _seconds(np.asarray(column.cast(pyarrow.timestamp("ns"))).astype("datetime64[ns]"))
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


def _seconds(dates: Any) -> Array:
    """Seconds since the first of some dates, NaN where there is none."""
    known = dates[~np.isnat(dates)]
    if not known.size:
        return np.full(dates.size, np.nan)
    seconds: Array = (dates - known[0]) / np.timedelta64(1, "s")
    return seconds


def read_netcdf(path: Path) -> tuple[dict[str, Cells], dict[str, str]]:
    """Columns of a NetCDF file by name: variables over time; those over time and joint as "angle.elbow".

    Raises:
        InputError: it is none, or has no variable over time.
    """
    import xarray  # noqa: PLC0415  # takes long to import

    try:
        with xarray.open_dataset(path, engine="h5netcdf", decode_times=False) as opened:
            data = opened.load()
    except (OSError, ValueError) as error:
        raise InputError(f"can't be read as NetCDF ({error})", where=str(path), right="give a NetCDF file") from None
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
