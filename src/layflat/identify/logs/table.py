"""A log as its file has it: columns of raw numbers, each with its stamps where the file says so."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from layflat.arrays import Array
from layflat.identify.logs.headers import Header

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
