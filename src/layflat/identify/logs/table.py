"""A log as its file has it: columns of raw numbers, each with its stamps where the file says so."""

import hashlib
from collections.abc import Callable
from dataclasses import dataclass, replace
from datetime import datetime
from pathlib import Path
from typing import TypeVar

import numpy as np

from layflat.arrays import Array
from layflat.description.text import check_regular
from layflat.errors import InputError
from layflat.identify.logs.headers import Header, header_of

Cells = Array | list[str]
T = TypeVar("T")

LONG = (("signal", "channel", "name"), ("time", "t"), ("value",))  # columns of a table with a sample a row


@dataclass(frozen=True)
class Column:
    """A column of raw numbers, NaN where there is none, with its header."""

    values: Array
    header: Header
    stamps: Array | None = None  # times of its own, (samples,); None where a column of the table is the clock


@dataclass(frozen=True)
class Table:
    """What a file holds: columns by name."""

    path: Path
    sha256: str
    columns: dict[str, Column]
    clock: Header | None = None  # of the stamps where columns have their own; None where a column is the clock


def read_table(path: str | Path) -> Table:
    """Read a log's file: .parquet, .nc, .mcap, and text for all else; raise InputError if it holds no numbers."""
    from layflat.identify.logs import arrays, bag, text  # noqa: PLC0415  # they make tables of what they read

    path, right = Path(path), "give a CSV, Parquet, NetCDF or MCAP file"
    check_regular(path, str(path), right)
    try:
        with path.open("rb") as file:
            sha256 = hashlib.file_digest(file, "sha256").hexdigest()
    except OSError as error:
        raise InputError(f"can't be read ({error.strerror})", where=str(path), right=right) from None
    suffix = path.suffix.lower()
    if suffix == ".mcap" or path.name.endswith(".mcap.part"):
        columns, clock = bag.read_bag(path)
    elif suffix in {".parquet", ".pq"}:
        columns, clock = arranged(*arrays.read_parquet(path))
    else:
        columns, clock = arranged(*(arrays.read_netcdf if suffix in {".nc", ".nc4", ".h5"} else text.read_text)(path))
    if not any(np.isfinite(column.values).any() for column in columns.values()):
        raise InputError("holds no numbers", where=str(path), right="give a table of samples")
    return Table(path, sha256, columns, clock)


def arranged(cells: dict[str, Cells], units: dict[str, str]) -> tuple[dict[str, Column], Header | None]:
    """Columns from cells: a column for each header, or for each signal of a table in long format."""
    headers = {name: header_of(name, units.get(name, "")) for name in cells}
    stems = {header.stem.lower(): name for name, header in headers.items()}
    signal, time, value = (next((stems[word] for word in words if word in stems), "") for words in LONG)
    if signal and time and value and not isinstance(cells[signal], np.ndarray):
        stated = cells.get(next((stems[word] for word in ("unit", "units") if word in stems), ""))
        return _pivoted(cells[signal], cells[time], cells[value], stated, headers[time])
    columns = {}
    for name, values in cells.items():
        numbers, dated = _numbers(values)
        if isinstance(values, np.ndarray) or np.isfinite(numbers).any():
            header = replace(headers[name], unit="s") if dated else headers[name]
            columns[header.name] = Column(numbers, header)
    return columns, None


def _pivoted(
    signals: Cells, time: Cells, value: Cells, units: Cells | None, clock: Header
) -> tuple[dict[str, Column], Header]:
    """Columns of a table with a sample a row."""
    (times, dated), (values, _) = _numbers(time), _numbers(value)
    names = np.array([str(name).strip() for name in signals])
    columns = {}
    for name in dict.fromkeys(names.tolist()):
        mine = np.flatnonzero(names == name)
        header = header_of(name, "" if units is None else str(units[int(mine[0])]))
        columns[header.name] = Column(values[mine], header, times[mine])
    return columns, replace(clock, unit="s") if dated else clock


def _numbers(cells: Cells) -> tuple[Array, bool]:
    """Numbers of cells, NaN where there is none; dates with times become seconds since the first (True)."""
    if isinstance(cells, np.ndarray):
        return cells, False
    numbers = np.array([_tried(float, cell) for cell in cells], dtype=np.float64)
    dates = [] if np.isfinite(numbers).any() else [_tried(datetime.fromisoformat, cell.strip()) for cell in cells]
    first = next((date for date in dates if date is not None), None)
    if first is None:
        return numbers, False
    try:
        return np.array([np.nan if date is None else (date - first).total_seconds() for date in dates]), True
    except TypeError:  # some say their time zone and some don't
        return numbers, False


def _tried(read: Callable[[str], T], cell: str) -> T | None:
    try:
        return read(cell)
    except ValueError:
        return None
