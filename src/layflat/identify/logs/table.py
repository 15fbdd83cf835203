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
from layflat.identify.logs.headers import Header

RIGHT = "give a table of samples, with commas, semicolons, tabs, bars or blanks between columns"
Cells = Array | list[str]  # numbers of a column, or its words


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
    """Content of a file: columns by name."""

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
        raise InputError(f"holds no numbers{first}", where=str(path), right=RIGHT)
    columns = join_stamps(columns) if clock is None else columns
    return Table(path, sha256, columns, clock, notes, dict(words))
