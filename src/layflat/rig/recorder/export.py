"""Runs for other programs: NetCDF, and Parquet."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING

from layflat import extras
from layflat.errors import InputError
from layflat.files import whole_file

if TYPE_CHECKING:
    import xarray


def check_format(path: Path) -> None:
    """Make sure that a name says how to write.

    Raises:
        InputError: it does not, or the package for it is missing.
    """
    if path.suffix not in _WRITERS:
        raise InputError(f"{path.suffix or path.name!r} is no format", where=str(path), right="use .nc or .parquet")
    if path.suffix == ".parquet":
        extras.require("rig", "pyarrow", where=str(path))


def export(run: xarray.Dataset, path: Path) -> Path:
    """Write a recorded run, by what the name ends in: NetCDF (.nc), or Parquet (.parquet), a column a signal.

    Raises:
        InputError: it ends in something else, or pyarrow is missing.
        OutputError: it can't be written there.
    """
    check_format(path)
    with whole_file(path) as temporary:
        _WRITERS[path.suffix](run, temporary)
    return path


def _write_netcdf(run: xarray.Dataset, path: Path) -> None:
    path.write_bytes(run.to_netcdf(None, engine="h5netcdf"))  # in memory: HDF5 brings the process down on a full disk


def _write_parquet(run: xarray.Dataset, path: Path) -> None:
    """Columns "time", "supply", "angle.large"; units stand with the fields, the rest in the file's metadata."""
    import pyarrow  # noqa: PLC0415
    from pyarrow import parquet  # noqa: PLC0415

    joints = run["joint"].to_numpy()
    columns, fields = [], []
    for name, variable in run.variables.items():
        if variable.dims[:1] != ("time",):
            continue
        names = [f"{name}.{joint}" for joint in joints] if variable.ndim == 2 else [str(name)]
        for column, values in zip(names, variable.to_numpy().reshape(run.sizes["time"], -1).T, strict=True):
            columns.append(pyarrow.array(values))
            fields.append(pyarrow.field(column, pyarrow.float64(), metadata={"unit": variable.attrs["units"]}))
    told = (run[name].to_numpy().tolist() for name in ("event_time", "event_level", "event_text"))
    about = {key: str(value) for key, value in run.attrs.items()}
    about["events"] = json.dumps(list(zip(*told, strict=True)))
    parquet.write_table(pyarrow.table(columns, schema=pyarrow.schema(fields, metadata=about)), path)


_WRITERS = {".nc": _write_netcdf, ".parquet": _write_parquet}
"""By suffix."""
