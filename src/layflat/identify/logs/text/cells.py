"""Cells of a text table: their kinds, and columns of numbers, of stamps, or of numbers with label or unit."""

import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from layflat.arrays import Array
from layflat.identify.logs.table import STAMP_UNIT
from layflat.identify.logs.text.numbers import (
    Decimal,
    NumberReading,
    is_missing,
    is_number,
    is_usual_number,
    normalize_cell,
    read_numbers,
)
from layflat.identify.logs.text.stamps import is_stamp, read_stamps

CellKind = Literal["missing", "number", "stamp", "dressed", "text"]

_LABELLED_NUMBER = re.compile(
    r"(?:(?P<label>[^\W\d]\w*(?:\[\d+\])?) ?[:=] ?)?"
    r"(?P<number>[-+]?[\d.,](?:[\d.,' ]*[\d.,])?(?:[eE][-+]?\d+)?)"
    r"(?P<unit>(?: ?[^\W\d_]| ?[°%])[^\d\s]{0,11})?"
)
MAX_LISTED_LABELS = 4  # labels or units named in a message
MAX_CLASSIFIED_CELLS = 200  # cells that decide the kind of a column
MIN_READABLE_FRACTION = 0.5  # of the cells that must be numbers or stamps; with fewer a column is one of words


@dataclass(frozen=True)
class ColumnReading:
    """Values of a column of a text table, with unit, label and notes."""

    values: Array | None  # NaN where a cell is empty or can't be read; None for a column of words
    unit: str = ""  # in the cells; `STAMP_UNIT` for dates and clock times
    label: str = ""  # before each number: "A" of "A:12.3"
    proven: Decimal | None = None  # decimal sign that its numbers prove
    doubtful: bool = False  # its numbers depend on a decimal sign that they do not prove
    notes: list[str] = field(default_factory=list)
    start: float = 0.0  # the first stamp of dates and clock times, s


def classify_cell(cell: str) -> CellKind:
    """Return the kind of a cell; "dressed" is a number with label or unit."""
    if is_usual_number(cell):
        return "number"
    if is_missing(cell):
        return "missing"
    text = normalize_cell(cell)
    if is_number(text):
        return "number"
    if is_stamp(text):
        return "stamp"
    return "dressed" if _match_labelled(text) else "text"


def _match_labelled(text: str) -> re.Match[str] | None:
    """Return the match of a number with label or unit, such as "A:12.3" or "5 bar"; None for others."""
    match = _LABELLED_NUMBER.fullmatch(text)
    return match if match and (match["label"] or match["unit"]) and is_number(match["number"]) else None


def read_cells(cells: Sequence[str], usual: Decimal | None, where: str) -> ColumnReading:
    """Read a column as the kind of most of its cells: numbers, stamps, or numbers with a label or a unit.

    Args:
        cells: texts of the column.
        usual: decimal sign of the rest of the file; None where none is proven.
        where: file and column, for messages.

    Raises:
        InputError: some numbers have decimal points and others decimal commas.
    """
    filled = np.array([not is_missing(cell) for cell in cells], dtype=bool)
    count = int(filled.sum())
    if not count:
        return ColumnReading(np.full(len(cells), np.nan))
    kinds = [classify_cell(cells[int(i)]) for i in np.flatnonzero(filled)[:MAX_CLASSIFIED_CELLS]]
    if kinds.count("stamp") > max(kinds.count("number"), kinds.count("dressed")):
        return _read_stamp_column(cells, filled)
    label = unit = ""
    if kinds.count("dressed") > kinds.count("number"):
        undressed = _strip_labels(cells)
        if isinstance(undressed, str):
            return ColumnReading(None, notes=[undressed])
        cells, label, unit = undressed
    reading = read_numbers(cells, usual, where)
    unreadable = filled & ~reading.read
    if count - unreadable.sum() < MIN_READABLE_FRACTION * count:
        return ColumnReading(None, notes=[_describe_words(cells, filled, count - int(unreadable.sum()))])
    notes = _number_notes(cells, reading, unreadable)
    return ColumnReading(reading.values, unit, label, reading.proven, bool(reading.doubtful), notes)


def _read_stamp_column(cells: Sequence[str], filled: NDArray[np.bool_]) -> ColumnReading:
    """Return a column of dates or clock times as seconds."""
    stamps = read_stamps(cells)
    if stamps is None:
        first = cells[int(np.flatnonzero(filled)[0])]
        return ColumnReading(None, notes=[f"holds dates or times that can't be read as one kind, such as {first!r}"])
    unread = filled & ~np.isfinite(stamps.seconds)
    notes = [stamps.note, *_unread_notes(cells, unread, "date or time")]
    return ColumnReading(stamps.seconds, STAMP_UNIT, notes=notes, start=stamps.start)


def _strip_labels(cells: Sequence[str]) -> tuple[list[str], str, str] | str:
    """Return bare numbers, their label and their unit; a reason where labels or units differ."""
    matches = [_match_labelled(normalize_cell(cell)) for cell in cells]
    labels = {match["label"] or "" for match in matches if match}
    units = {(match["unit"] or "").strip() for match in matches if match}
    for kind, several in (("labels", labels), ("units", units)):
        if len(several) > 1:
            named = ", ".join(repr(name) for name in sorted(several)[:MAX_LISTED_LABELS])
            return f"has numbers with different {kind}, {named}: write all with one"
    bare = [match["number"] if match else cell for match, cell in zip(matches, cells, strict=True)]
    return bare, labels.pop(), units.pop()


def _describe_words(cells: Sequence[str], filled: NDArray[np.bool_], numbers: int) -> str:
    """Return a note on a column of words, with an example."""
    first = next((c for c in (cells[int(i)] for i in np.flatnonzero(filled)) if classify_cell(c) == "text"), "")
    example = first or cells[int(np.flatnonzero(filled)[0])]
    some = f"; {numbers} of {int(filled.sum())} are numbers" if numbers else ""
    return f"holds words, such as {shorten(example)!r}{some}"


def _number_notes(cells: Sequence[str], reading: NumberReading, unread: NDArray[np.bool_]) -> list[str]:
    """Return notes on cells without number, and on an unproven decimal sign."""
    notes = _unread_notes(cells, unread, "number")
    if reading.doubtful:
        sign = "comma" if "," in reading.doubtful else "point"
        notes.append(
            f"the {sign} in {reading.doubtful!r} is taken for the decimal sign, which nothing proves: check it"
        )
    return notes


def _unread_notes(cells: Sequence[str], unread: NDArray[np.bool_], kind: str) -> list[str]:
    """Return a note on cells that hold no value of a kind; none if all do."""
    rows = np.flatnonzero(unread)
    if not rows.size:
        return []
    first = f"the first {shorten(cells[int(rows[0])])!r} in sample {rows[0] + 1}"
    if rows.size == 1:
        return [f"1 cell holds no {kind} and is missing, {first}"]
    return [f"{rows.size} cells hold no {kind} and are missing, {first}"]


def shorten(text: str, length: int = 40) -> str:
    """Return a text cut to a number of characters."""
    return text if len(text) <= length else text[: length - 3] + "..."
