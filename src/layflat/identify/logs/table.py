"""A log as its file has it: columns of raw numbers, each with its stamps where the file says so."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass, replace
from datetime import datetime
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from layflat.description.text import check_regular
from layflat.errors import InputError
from layflat.identify.logs.headers import Header, header_of

Array = NDArray[np.float64]
Cells = Array | list[str]

LONG = (("signal", "channel", "name"), ("time", "t"), ("value",))
"""A table with these columns has a sample a row: of which signal, when, and its value."""


@dataclass(frozen=True)
class Column:
    """A column of raw numbers.

    Attributes:
        values: (samples,), NaN where there is none.
        header: its name, and the unit that the file states, if any.
        stamps: (samples,) where the column has times of its own; None where a column of the table is the clock.
    """

    values: Array
    header: Header
    stamps: Array | None = None


@dataclass(frozen=True)
class Table:
    """What a file holds.

    Attributes:
        path: of the file.
        sha256: its checksum.
        columns: by name.
        clock: name of the stamps where columns have their own, with its unit; None where a column is the clock.
    """

    path: Path
    sha256: str
    columns: dict[str, Column]
    clock: Header | None = None


def read_table(path: str | Path) -> Table:
    """Read a log's file, by what its name ends in: .parquet, .nc, .mcap, and text for all else.

    Raises:
        InputError: it can't be read, or holds no columns of numbers.
    """
    path = Path(path)
    check_regular(path, str(path), "give a CSV, Parquet, NetCDF or MCAP file")
    try:
        with path.open("rb") as file:
            sha256 = hashlib.file_digest(file, "sha256").hexdigest()
    except OSError as error:
        raise InputError(
            f"can't be read ({error.strerror})", where=str(path), right="give a CSV, Parquet, NetCDF or MCAP file"
        ) from None
    columns, clock = _read(path)
    if not any(np.isfinite(column.values).any() for column in columns.values()):
        raise InputError("holds no numbers", where=str(path), right="give a table of samples")
    return Table(path, sha256, columns, clock)


def _read(path: Path) -> tuple[dict[str, Column], Header | None]:
    suffix = path.suffix.lower()
    if suffix == ".mcap" or path.name.endswith(".mcap.part"):
        from layflat.identify.logs.bag import read_bag  # noqa: PLC0415  # not needed for other files

        return read_bag(path)
    if suffix in {".parquet", ".pq"}:
        from layflat.identify.logs.arrays import read_parquet  # noqa: PLC0415

        return arranged(*read_parquet(path))
    if suffix in {".nc", ".nc4", ".h5"}:
        from layflat.identify.logs.arrays import read_netcdf  # noqa: PLC0415

        return arranged(*read_netcdf(path))
    from layflat.identify.logs.text import read_text  # noqa: PLC0415

    return arranged(*read_text(path))


def arranged(cells: dict[str, Cells], units: dict[str, str]) -> tuple[dict[str, Column], Header | None]:
    """Columns from cells: a column for each header, or for each signal of a table in long format."""
    headers = {name: header_of(name, units.get(name, "")) for name in cells}
    long = _long_format(headers, cells)
    if long is not None:
        return _pivoted(cells, headers, *long)
    columns = {}
    for name, values in cells.items():
        header = headers[name]
        if not isinstance(values, np.ndarray):
            numbers, dated = _numbers(values)
            if not np.isfinite(numbers).any():
                continue
            values, header = numbers, (replace(header, unit="s") if dated else header)  # noqa: PLW2901
        columns[header.name] = Column(values, header)
    return columns, None


def _long_format(headers: dict[str, Header], cells: dict[str, Cells]) -> tuple[str, str, str] | None:
    """Names of the columns with signal, time and value; None for a table with a column a signal."""
    stems = {header.stem.lower(): name for name, header in headers.items()}
    found = [next((stems[word] for word in words if word in stems), None) for words in LONG]
    signal, time, value = found
    if signal is None or time is None or value is None or isinstance(cells[signal], np.ndarray):
        return None
    return signal, time, value


def _pivoted(
    cells: dict[str, Cells], headers: dict[str, Header], signal: str, time: str, value: str
) -> tuple[dict[str, Column], Header]:
    times, dated = _as_numbers(cells[time])
    values, _ = _as_numbers(cells[value])
    names = np.array([str(name).strip() for name in cells[signal]])
    stated = next((cells[name] for name, header in headers.items() if header.stem.lower() in {"unit", "units"}), None)
    columns = {}
    for name in dict.fromkeys(names.tolist()):
        mine = np.flatnonzero(names == name)
        header = header_of(name, "" if stated is None else str(stated[int(mine[0])]))
        columns[header.name] = Column(values[mine], header, times[mine])
    clock = headers[time]
    return columns, replace(clock, unit="s") if dated else clock


def _as_numbers(cells: Cells) -> tuple[Array, bool]:
    return (cells, False) if isinstance(cells, np.ndarray) else _numbers(cells)


def _numbers(cells: Sequence[str]) -> tuple[Array, bool]:
    """Numbers of cells, NaN where there is none; dates with times become seconds since the first (True)."""
    try:
        return np.array(cells, dtype=np.float64), False
    except ValueError:
        pass
    numbers = np.array([_number(cell) for cell in cells])
    if np.isfinite(numbers).any():
        return numbers, False
    dates = [_date(cell) for cell in cells]
    first = next((date for date in dates if date is not None), None)
    if first is None:
        return numbers, False
    try:
        return np.array([np.nan if date is None else (date - first).total_seconds() for date in dates]), True
    except TypeError:  # some say their time zone and some don't
        return numbers, False


def _number(cell: str) -> float:
    try:
        return float(cell)
    except ValueError:
        return float("nan")


def _date(cell: str) -> datetime | None:
    try:
        return datetime.fromisoformat(cell.strip())
    except ValueError:
        return None
