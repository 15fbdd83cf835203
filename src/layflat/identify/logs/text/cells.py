"""Cells of a table: their kinds, and columns whose cells carry a label or a unit beside the number."""

import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from layflat.arrays import Array
from layflat.identify.logs.headers import STAMPED
from layflat.identify.logs.text.numbers import Decimal, Reading, is_missing, is_number, plain, read_numbers
from layflat.identify.logs.text.stamps import is_stamp, read_stamps

Kind = Literal["missing", "number", "stamp", "dressed", "text"]

_DRESSED = re.compile(
    r"(?:(?P<label>[^\W\d]\w*(?:\[\d+\])?) ?[:=] ?)?"
    r"(?P<number>[-+]?[\d.,](?:[\d.,' ]*[\d.,])?(?:[eE][-+]?\d+)?)"
    r"(?P<unit>(?: ?[^\W\d_]| ?[°%])[^\d\s]{0,11})?"
)
SHOWN = 4  # labels or units in a message
TRIED = 200  # cells from which the kind of a column is told
READABLE = 0.5  # fraction of the cells that must be numbers or stamps; with fewer a column is one of words


@dataclass(frozen=True)
class Cells:
    """A column of a text table, read."""

    values: Array | None  # NaN where a cell is empty or can't be read; None where it holds words
    unit: str = ""  # that stands in the cells; `STAMPED` for dates and clock times
    label: str = ""  # that stands before each number: "A" of "A:12.3"
    proven: Decimal | None = None  # decimal sign that its numbers prove
    doubtful: bool = False  # its numbers would be others with the other decimal sign, and prove none
    notes: list[str] = field(default_factory=list)
    start: float = 0.0  # the first stamp of dates and clock times, s


def kind_of(cell: str) -> Kind:
    """Return the kind of a cell: missing, a number, a stamp, a number with label or unit, or words."""
    if is_missing(cell):
        return "missing"
    text = plain(cell)
    if is_number(text):
        return "number"
    if is_stamp(text):
        return "stamp"
    return "dressed" if _dressed(text) else "text"


def _dressed(text: str) -> re.Match[str] | None:
    match = _DRESSED.fullmatch(text)
    return match if match and (match["label"] or match["unit"]) and is_number(match["number"]) else None


def read_cells(cells: Sequence[str], usual: Decimal | None, where: str) -> Cells:
    """Read a column as whatever most of its cells are: numbers, stamps, or numbers with a label or a unit.

    Args:
        cells: texts of the column.
        usual: decimal sign of the rest of the file, None where nothing proves one.
        where: file and column, for messages.

    Raises:
        InputError: its numbers have decimal points and decimal commas.
    """
    filled = np.array([not is_missing(cell) for cell in cells], dtype=bool)
    count = int(filled.sum())
    if not count:
        return Cells(np.full(len(cells), np.nan))
    kinds = [kind_of(cells[int(i)]) for i in np.flatnonzero(filled)[:TRIED]]
    if kinds.count("stamp") > max(kinds.count("number"), kinds.count("dressed")):
        return _stamped(cells, filled)
    label = unit = ""
    if kinds.count("dressed") > kinds.count("number"):
        undressed = _undress(cells)
        if isinstance(undressed, str):
            return Cells(None, notes=[undressed])
        cells, label, unit = undressed
    reading = read_numbers(cells, usual, where)
    unread = filled & ~reading.read
    if count - unread.sum() < READABLE * count:
        return Cells(None, notes=[_words(cells, filled, count - int(unread.sum()))])
    notes = _notes(cells, reading, unread)
    return Cells(reading.values, unit, label, reading.proven, bool(reading.doubtful), notes)


def _stamped(cells: Sequence[str], filled: NDArray[np.bool_]) -> Cells:
    stamps = read_stamps(cells)
    if stamps is None:
        first = cells[int(np.flatnonzero(filled)[0])]
        return Cells(None, notes=[f"holds dates or times that can't be read as one kind, such as {first!r}"])
    unread = filled & ~np.isfinite(stamps.seconds)
    notes = [stamps.note, *_unread(cells, unread, "date or time")]
    return Cells(stamps.seconds, STAMPED, notes=notes, start=stamps.start)


def _undress(cells: Sequence[str]) -> tuple[list[str], str, str] | str:
    """Return numbers without their label and unit, and these; a reason where labels or units differ."""
    matches = [_dressed(plain(cell)) for cell in cells]
    labels = {match["label"] or "" for match in matches if match}
    units = {(match["unit"] or "").strip() for match in matches if match}
    for kind, several in (("labels", labels), ("units", units)):
        if len(several) > 1:
            named = ", ".join(repr(one) for one in sorted(several)[:SHOWN])
            return f"has numbers with different {kind}, {named}: write all with one"
    bare = [match["number"] if match else cell for match, cell in zip(matches, cells, strict=True)]
    return bare, labels.pop(), units.pop()


def _words(cells: Sequence[str], filled: NDArray[np.bool_], numbers: int) -> str:
    first = next((c for c in (cells[int(i)] for i in np.flatnonzero(filled)) if kind_of(c) == "text"), "")
    example = first or cells[int(np.flatnonzero(filled)[0])]
    some = f"; {numbers} of {int(filled.sum())} are numbers" if numbers else ""
    return f"holds words, such as {shortened(example)!r}{some}"


def _notes(cells: Sequence[str], reading: Reading, unread: NDArray[np.bool_]) -> list[str]:
    notes = _unread(cells, unread, "number")
    if reading.doubtful:
        sign = "comma" if "," in reading.doubtful else "point"
        notes.append(
            f"the {sign} in {reading.doubtful!r} is taken for the decimal sign, which nothing proves: check it"
        )
    return notes


def _unread(cells: Sequence[str], unread: NDArray[np.bool_], what: str) -> list[str]:
    rows = np.flatnonzero(unread)
    if not rows.size:
        return []
    first = f"the first {shortened(cells[int(rows[0])])!r} in sample {rows[0] + 1}"
    if rows.size == 1:
        return [f"1 cell holds no {what} and is missing, {first}"]
    return [f"{rows.size} cells hold no {what} and are missing, {first}"]


def shortened(text: str, most: int = 40) -> str:
    """Return a text of at most some characters."""
    return text if len(text) <= most else text[: most - 3] + "..."
