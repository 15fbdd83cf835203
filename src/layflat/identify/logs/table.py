"""A log as its file has it: columns of raw numbers, each with its stamps where the file says so."""

import hashlib
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from layflat.arrays import Array
from layflat.description.text import check_regular
from layflat.errors import InputError
from layflat.identify.logs.headers import Header, header_of
from layflat.identify.logs.text.cells import read_cells

Cells = Array | list[str]

LONG = (("signal", "channel", "name"), ("time", "t"), ("value",))  # columns of a table with a sample a row
CODES = (999.0, 9999.0, 99999.0, 999999.0, 999.9, 9999.9, 99999.9, 999.99, 9999.99)  # in place of a missing sample
OVERFLOW = 9e36  # from which numbers are such codes too
LEAST_REST = 10  # other samples that tell how far out a code stands
FAR_OUT = 2.5  # times the greatest magnitude of the rest that a code has at least


@dataclass(frozen=True)
class Column:
    """A column of raw numbers, NaN where there is none, with its header."""

    values: Array
    header: Header
    stamps: Array | None = None  # times of its own, (samples,); None where a column of the table is the clock
    notes: tuple[str, ...] = ()  # what had to be decided to read it, and cells that hold no number
    topic: str = ""  # of the messages that it is from
    messages: NDArray[np.intp] | None = None  # number of each sample's message among those of its topic


class Content(NamedTuple):
    """Content of a file, as its reader hands it over."""

    columns: dict[str, Column]
    clock: Header | None = None  # of the stamps where columns have their own; None where a column is the clock
    words: Mapping[str, str] = {}  # what the file holds besides, by name, and why it makes no column
    notes: tuple[str, ...] = ()  # on the file


@dataclass(frozen=True)
class Table:
    """What a file holds: columns by name."""

    path: Path
    sha256: str
    columns: dict[str, Column]
    clock: Header | None = None  # of the stamps where columns have their own; None where a column is the clock
    notes: tuple[str, ...] = ()  # on the file
    words: dict[str, str] = field(default_factory=dict)  # what makes no column of numbers, and why

    def stamps_of(self, column: Column, clock: str) -> Array | None:
        """Return the times of a column by a clock that its messages carry, such as "header.stamp"; None without one.

        Args:
            column: one of a bag.
            clock: a field of its messages, or of those of one topic, with the topic's name before it.
        """
        name = clock if clock.startswith(f"{column.topic}.") else f"{column.topic}.{clock}"
        carried = self.columns.get(name)
        if carried is None or carried.messages is None or column.messages is None:
            return None
        by_message = np.full(max(carried.messages.max(), column.messages.max()) + 1, np.nan)
        by_message[carried.messages] = carried.values
        return by_message[column.messages]


def read_table(path: str | Path, progress: Callable[[float], None] | None = None) -> Table:
    """Read a log's file, of the kind that it begins as, or is named.

    Args:
        path: of the file.
        progress: takes the fraction of a text file that is read.

    Raises:
        InputError: it can't be read, or holds no numbers.
    """
    from layflat.identify.logs.clocks import join_stamps  # noqa: PLC0415  # it joins columns of tables
    from layflat.identify.logs.formats import read_content  # noqa: PLC0415  # readers make tables of what they read

    path, right = Path(path), "give a CSV, Parquet, NetCDF or MCAP file"
    if path.is_dir():
        inside = sorted(file for file in path.iterdir() if file.suffix in {".mcap", ".db3"})
        right = f"give the recording inside: {inside[0]}" if inside else right
    check_regular(path, str(path), right)
    try:
        with path.open("rb") as file:
            sha256 = hashlib.file_digest(file, "sha256").hexdigest()
            file.seek(0)
            start = file.read(16)
    except OSError as error:
        raise InputError(f"can't be read ({error.strerror})", where=str(path), right=right) from None
    columns, clock, words, notes = read_content(path, start, progress)
    if not any(np.isfinite(column.values).any() for column in columns.values()):
        first = next((f": column {name!r} {why}" for name, why in words.items()), "")
        raise InputError(f"holds no numbers{first}", where=str(path), right="give a table of samples")
    columns = join_stamps(columns) if clock is None else columns
    return Table(path, sha256, columns, clock, notes, dict(words))


def arranged(
    cells: Mapping[str, Cells], units: Mapping[str, str], notes: Mapping[str, list[str]] | None = None
) -> tuple[dict[str, Column], Header | None, dict[str, str]]:
    """Return columns from cells: one for each header, or for each signal of a table in long format.

    Args:
        cells: numbers, or words, of each column.
        units: that are stated beside the names.
        notes: on single columns; default: those that come of reading words.

    Returns:
        Columns by name; the clock's header where columns have times of their own; names of columns of words, and why.
    """
    notes = notes or {}
    headers = {name: header_of(name, units.get(name, "")) for name in cells}
    for name in [name for name, header in headers.items() if header.unit == "Pa" and not units.get(name)]:
        if "Pa" in name and name.replace("Pa", "Pb") in cells:  # the pressures of two hoses
            headers[name] = Header(name, stem=name)
    stems = {header.stem.lower(): name for name, header in headers.items()}
    signal, time, value = (next((stems[word] for word in words if word in stems), "") for words in LONG)
    if signal and time and value and not isinstance(cells[signal], np.ndarray):
        stated = cells.get(next((stems[word] for word in ("unit", "units") if word in stems), ""))
        columns, clock = _pivoted(list(cells[signal]), cells[time], cells[value], stated, headers[time])
        return columns, clock, {}
    columns, words = {}, {}
    for name, values in cells.items():
        if isinstance(values, np.ndarray):
            known, told = without_codes(values)
            columns[name] = Column(known, headers[name], notes=(*notes.get(name, ()), *told))
            continue
        read = read_cells(values, None, name) if name not in notes else None
        if read is None or read.values is None:
            words[name] = "; ".join(notes.get(name, read.notes if read else []))
        else:
            header = header_of(name, units.get(name, "") or read.unit)
            columns[name] = Column(read.values, header, notes=tuple(read.notes))
    return columns, None, words


def without_codes(values: Array) -> tuple[Array, list[str]]:
    """Return values without such as -9999, which loggers write for what is missing, and a note; they stand far out."""
    sizes = np.abs(values)
    coded = np.isfinite(values) & (np.isin(sizes, CODES) | (sizes >= OVERFLOW))
    rest = sizes[np.isfinite(values) & ~coded]
    if not coded.any() or rest.size < LEAST_REST or sizes[coded].min() < FAR_OUT * rest.max():
        return values, []
    codes = ", ".join(f"{code:g}" for code in np.unique(values[coded]))
    count = int(coded.sum())
    told = f"{count} sample{'s' if count > 1 else ''} of {codes} {'are' if count > 1 else 'is'} taken for missing"
    return np.where(coded, np.nan, values), [told]


def _pivoted(
    signals: list[str], time: Cells, value: Cells, units: Cells | None, clock: Header
) -> tuple[dict[str, Column], Header]:
    """Return columns of a table with a sample a row."""
    times, unit, notes = _numbers(time)
    values, _, _ = _numbers(value)
    names = np.array([str(name).strip() for name in signals])
    columns = {}
    for name in dict.fromkeys(names.tolist()):
        mine = np.flatnonzero(names == name)
        header = header_of(name, "" if units is None else str(units[int(mine[0])]))
        columns[header.name] = Column(values[mine], header, times[mine], notes)
    return columns, header_of(clock.name, unit) if unit else clock


def _numbers(cells: Cells) -> tuple[Array, str, tuple[str, ...]]:
    """Return numbers of a column, their unit where the cells say it, and notes."""
    if isinstance(cells, np.ndarray):
        return cells, "", ()
    read = read_cells(cells, None, "log")
    values = np.full(len(cells), np.nan) if read.values is None else read.values
    return values, read.unit, tuple(read.notes)
