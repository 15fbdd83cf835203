"""From a text file to columns of numbers with names, units, and notes on what had to be decided."""

import csv
from collections import Counter
from dataclasses import dataclass, field, replace
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np

from layflat.arrays import Array
from layflat.errors import InputError
from layflat.identify.logs.headers import STAMPED
from layflat.identify.logs.text.cells import Cells, read_cells
from layflat.identify.logs.text.labels import read_heading, with_segments
from layflat.identify.logs.text.layout import COMMENTS, Layout, find_layout, joined_lines, split_row
from layflat.identify.logs.text.lines import Progress, SampleLines, encoding_of
from layflat.identify.logs.text.numbers import Decimal, number, plain

HEAD_LINES = 400  # from which the layout is found
CHUNK = 200_000  # rows that pandas reads at once
RIGHT = "give a table with a row a sample"
CLOCK = "time"  # name of the clock of a table whose heading says the step between samples


@dataclass
class TextTable:
    """Columns of a text table in their order, and what there is to say of them."""

    columns: dict[str, Array | list[str]] = field(default_factory=dict)  # lists of words
    units: dict[str, str] = field(default_factory=dict)  # as stated in a row of units or in the cells
    notes: dict[str, list[str]] = field(default_factory=dict)  # of columns; "" of the table
    starts: dict[str, float] = field(default_factory=dict)  # first stamps of columns of dates and clock times, s


def read_text(path: Path, progress: Progress | None = None) -> TextTable:
    """Read a table of text.

    Columns of a table without header are called by their number, "1", "2" and so on, and so is one whose header is
    empty. Columns of one name are told apart by their number: "p (column 3)".

    Args:
        path: of the file.
        progress: takes the fraction that is read.

    Raises:
        InputError: it is not a table, or its rows have different lengths.
    """
    encoding, note = encoding_of(path)
    with path.open(encoding=encoding, errors="replace") as file:
        lines = [line.rstrip("\n") for line in islice(file, HEAD_LINES)]
    delimiter, skipped = _declared(lines)
    labview = read_heading(lines)
    if labview.lines:
        with path.open(encoding=encoding, errors="replace") as file:
            labview = with_segments(labview, file)
        lines = [line for i, line in enumerate(lines, 1) if i not in labview.inner]
    skipped = max(skipped, labview.lines)
    lines = joined_lines(lines)
    layout = find_layout([""] * skipped + lines[skipped:], delimiter or labview.delimiter)
    if not any(line.strip() and not line.startswith(COMMENTS) for line in lines[layout.start :]):
        raise InputError("holds no samples", where=str(path), right=RIGHT)
    table = TextTable(notes={"": [note] if note else []})
    names = _names(layout, path, table)
    layout = replace(layout, names=names, inner=labview.inner)
    decimal = labview.decimal or _decimal_of(lines[layout.start :], layout)
    for usual in dict.fromkeys((decimal or ".", ",")):
        cells, words, table_notes = _read_columns(path, encoding, layout, usual, decimal or labview.decimal, progress)
        again = usual == "." and any(c.proven == "," for c in cells.values()) and _fractions(cells, words)
        decimal = "," if again else decimal
        if not again:
            break
    table.notes[""] += table_notes
    _fill(table, layout, cells, words)
    labview.complete(table.columns, table.units)
    if layout.step > 0.0 and CLOCK not in table.columns:
        size = max(len(column) for column in table.columns.values())
        table.columns[CLOCK], table.units[CLOCK] = layout.step * np.arange(size, dtype=np.float64), "s"
        table.notes[CLOCK] = [f"by the step of {layout.step:g} s in the heading"]
    return table


def _declared(lines: list[str]) -> tuple[str, int]:
    """Return the delimiter of a first line "sep=;", and the number of lines that are none of the table."""
    if lines and lines[0].strip().strip('"').lower().startswith("sep="):
        sign = lines[0].strip().strip('"')[4:5]
        return sign or "\t", 1
    return "", 0


def _names(layout: Layout, path: Path, table: TextTable) -> list[str]:
    """Return a name for each column; raise InputError if the header has another number of them."""
    names, width = list(layout.names), layout.width
    if names and len(names) == width + 1 and not names[-1]:
        names.pop()
    if len(names) > width:
        table.notes[""].append(f"the header names {', '.join(names[width:])}, of which no row has a value")
        names = names[:width] if _only_comments(names[width:]) else names
    if names and len(names) != width:
        what = f"its header has {len(names)} names and its rows {width} values"
        right = "give each column a name" if layout.delimiter != "," else (
            "give each column a name; numbers with a decimal comma need another delimiter, such as ;"
        )  # fmt: skip
        raise InputError(what, where=str(path), right=right)
    names = [name.strip().strip("\"'").strip() or str(1 + i) for i, name in enumerate(names or [""] * width)]
    counts = Counter(names)
    for name, count in counts.items():
        if count > 1:
            table.notes[""].append(f"{count} columns are called {name!r}: they are told apart by their number")
    return [f"{name} (column {1 + i})" if counts[name] > 1 else name for i, name in enumerate(names)]


def _only_comments(names: list[str]) -> bool:
    return all(not name or name.lower() in {"comment", "comments", "kommentar", "notes"} for name in names)


def _decimal_of(lines: list[str], layout: Layout) -> Decimal | None:
    """Return the decimal sign that some cell of the first rows proves; None where none does or both are proven."""
    signs: set[Decimal] = set()
    for line in lines:
        for cell in split_row(line, layout.delimiter):
            point, comma = (number(plain(cell), sign) for sign in (".", ","))
            if (point is None) != (comma is None):
                signs.add("," if point is None else ".")
    return signs.pop() if len(signs) == 1 else None


def _frames(
    path: Path, encoding: str, layout: Layout, progress: Progress | None, **options: Any
) -> tuple[list[Any], list[str]]:
    """Return pandas' tables of all rows, and notes on rows that were left out."""
    import pandas as pd  # noqa: PLC0415  # takes long to import

    old = tuple(map(int, pd.__version__.split(".")[:2])) < (3, 1)  # later ones read every digit without being told
    exact: dict[str, Any] = {"float_precision": "round_trip"} if old else {}
    source = SampleLines(path, encoding, layout, progress)
    try:
        with source, pd.read_csv(
            source, sep=source.delimiter, header=None, names=list(range(layout.width)), chunksize=CHUNK,
            skipinitialspace=True, keep_default_na=False, low_memory=False, index_col=False, **exact, **options,
        ) as chunks:  # fmt: skip
            frames = list(chunks)
    except (pd.errors.ParserError, csv.Error) as error:
        what = " ".join(str(error).split())
        raise InputError(f"is not a table ({what})", where=str(path), right="separate columns by commas") from None
    except pd.errors.EmptyDataError:
        frames = []
    notes = source.check()
    if not frames or not sum(map(len, frames)):
        raise InputError("holds no samples", where=str(path), right=RIGHT)
    return frames, notes


def _read_columns(
    path: Path, encoding: str, layout: Layout, usual: Decimal, proven: Decimal | None, progress: Progress | None
) -> tuple[dict[int, Cells], dict[int, list[str]], list[str]]:
    """Return columns by their position: numbers, and the cells of those that hold words.

    What pandas takes for numbers with the usual decimal sign is one; all other columns are read cell by cell.
    """
    frames, notes = _frames(path, encoding, layout, progress, decimal=usual, na_values=["", "nan", "NaN", "NAN"])
    cells: dict[int, Cells] = {}
    odd = [i for i in range(layout.width) if any(_is_odd(frame[i], proven) for frame in frames)]
    for i in set(range(layout.width)) - set(odd):
        cells[i] = Cells(np.concatenate([frame[i].to_numpy(dtype=np.float64) for frame in frames]), proven=None)
    whole = {i for i in cells if all(frame[i].dtype.kind in "iub" for frame in frames)}
    words: dict[int, list[str]] = {}
    if odd:
        del frames
        texts, _ = _frames(path, encoding, layout, None, dtype=str, na_filter=False, usecols=odd)
        fractions = usual if proven or len(whole) < len(cells) else None
        read = {i: [cell for frame in texts for cell in frame[i].tolist()] for i in odd}
        cells |= _read_odd(read, fractions, path, layout)
        words = {i: column for i, column in read.items() if cells[i].values is None}
    return cells, words, notes


def _is_odd(column: Any, proven: Decimal | None) -> bool:
    """Return whether a column is to be read by cells: no numbers, or numbers with a sign that nothing proves."""
    if column.dtype.kind not in "iufb":
        return True
    return column.dtype.kind == "f" and proven is None


def _read_odd(columns: dict[int, list[str]], usual: Decimal | None, path: Path, layout: Layout) -> dict[int, Cells]:
    """Return columns read cell by cell; those that prove no decimal sign follow the others."""
    cells = {i: read_cells(column, usual, f"{path}, column {layout.names[i]}") for i, column in columns.items()}
    proven = {one.proven for one in cells.values() if one.proven is not None}
    if len(proven) == 1:
        for i in [i for i, one in cells.items() if one.doubtful]:
            cells[i] = read_cells(columns[i], next(iter(proven)), f"{path}, column {layout.names[i]}")
    return cells


def _fractions(cells: dict[int, Cells], words: dict[int, list[str]]) -> bool:
    """Return whether some column that pandas read has numbers with a fraction."""
    quick = [
        c.values
        for i, c in cells.items()
        if c.values is not None and c.proven is None and not c.notes and i not in words
    ]
    return any((values[np.isfinite(values)] % 1.0 != 0.0).any() for values in quick)


def _fill(table: TextTable, layout: Layout, cells: dict[int, Cells], words: dict[int, list[str]]) -> None:
    for i, title in enumerate(layout.names):
        name, column = title, cells[i]
        if column.values is None:
            table.columns[name], table.notes[name] = words[i], column.notes
            continue
        if name == str(1 + i) and not np.isfinite(column.values).any():
            continue
        if column.label and name == str(1 + i) and column.label not in table.columns:
            name = column.label
        table.columns[name], table.notes[name] = column.values, column.notes
        if column.unit == STAMPED:
            table.starts[name] = column.start
        stated = layout.units[i] if i < len(layout.units) else ""
        differ = stated and column.unit and column.unit not in {stated, STAMPED}
        table.units[name] = f"{stated} and {column.unit}" if differ else column.unit or stated
