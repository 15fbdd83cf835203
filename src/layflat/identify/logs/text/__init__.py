"""Text tables of any delimiter, decimal sign and encoding, with titles, comments and a row of units."""

import csv
from collections import Counter
from dataclasses import dataclass, field, replace
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np

from layflat.arrays import Array
from layflat.errors import InputError
from layflat.identify.logs.table import STAMP_UNIT
from layflat.identify.logs.text.cells import ColumnReading, read_cells
from layflat.identify.logs.text.labels import read_heading, read_segments
from layflat.identify.logs.text.layout import COMMENT_SIGNS, TextLayout, find_layout, join_lines, split_row
from layflat.identify.logs.text.lines import Progress, SampleLines, detect_encoding
from layflat.identify.logs.text.numbers import Decimal, find_decimal_sign

HEAD_LINES = 400  # at the start of a file from which the layout is detected
CHUNK_ROWS = 200_000  # rows that pandas reads at once
ROWS_ADVICE = "give a table with a row a sample"
CLOCK_NAME = "time"  # of the clock of a table whose heading states the step between samples


@dataclass
class TextTable:
    """Columns of a text table in their order, with units and notes."""

    columns: dict[str, Array | list[str]] = field(default_factory=dict)  # lists of words
    units: dict[str, str] = field(default_factory=dict)  # as stated in a row of units or in the cells
    notes: dict[str, list[str]] = field(default_factory=dict)  # of columns; "" of the table
    starts: dict[str, float] = field(default_factory=dict)  # first stamps of columns of dates and clock times, s


def read_text(path: Path, progress: Progress | None = None) -> TextTable:
    """Read a text table.

    Columns without header, or with an empty one, have their number as name: "1", "2" and so on. Columns of one name get
    their number as suffix: "p (column 3)".

    Args:
        path: path of the file.
        progress: called with the fraction that is read.

    Raises:
        InputError: it is not a table, or its rows have different lengths.
    """
    encoding, note = detect_encoding(path)
    with path.open(encoding=encoding, errors="replace") as file:
        lines = [line.rstrip("\n") for line in islice(file, HEAD_LINES)]
    delimiter, skipped = _declared_delimiter(lines)
    labview = read_heading(lines)
    if labview.lines:
        with path.open(encoding=encoding, errors="replace") as file:
            labview = read_segments(labview, file)
        lines = [line for i, line in enumerate(lines, 1) if i not in labview.inner]
    skipped = max(skipped, labview.lines)
    lines = join_lines(lines)
    layout = find_layout([""] * skipped + lines[skipped:], delimiter or labview.delimiter)
    if not any(line.strip() and not line.startswith(COMMENT_SIGNS) for line in lines[layout.start :]):
        raise InputError("holds no samples", where=str(path), right=ROWS_ADVICE)
    table = TextTable(notes={"": [note] if note else []})
    names = _column_names(layout, path, table)
    layout = replace(layout, names=names, inner=labview.inner)
    decimal = labview.decimal or find_decimal_sign(
        cell for line in lines[layout.start :] for cell in split_row(line, layout.delimiter)
    )
    for usual in dict.fromkeys((decimal or ".", ",")):
        cells, words, table_notes = _read_columns(path, encoding, layout, usual, decimal or labview.decimal, progress)
        again = usual == "." and any(c.proven == "," for c in cells.values()) and _has_fractions(cells, words)
        decimal = "," if again else decimal
        if not again:
            break
    table.notes[""] += table_notes
    _fill_table(table, layout, cells, words)
    labview.complete(table.columns, table.units)
    if layout.step > 0.0 and CLOCK_NAME not in table.columns:
        size = max(len(column) for column in table.columns.values())
        table.columns[CLOCK_NAME], table.units[CLOCK_NAME] = layout.step * np.arange(size, dtype=np.float64), "s"
        table.notes[CLOCK_NAME] = [f"by the step of {layout.step:g} s in the heading"]
    return table


def _declared_delimiter(lines: list[str]) -> tuple[str, int]:
    """Return the delimiter of a first line such as "sep=;", and the number of such lines; "" and 0 without one."""
    if lines and lines[0].strip().strip('"').lower().startswith("sep="):
        sign = lines[0].strip().strip('"')[4:5]
        return sign or "\t", 1
    return "", 0


def _column_names(layout: TextLayout, path: Path, table: TextTable) -> list[str]:
    """Return a name for each column, and add notes to the table; raise InputError if the header has another number."""
    names, width = list(layout.names), layout.width
    if names and len(names) == width + 1 and not names[-1]:
        names.pop()
    if len(names) > width:
        table.notes[""].append(f"the header names {', '.join(names[width:])}, of which no row has a value")
        names = names[:width] if _only_comments(names[width:]) else names
    if names and len(names) != width:
        problem = f"its header has {len(names)} names and its rows {width} values"
        right = "give each column a name" if layout.delimiter != "," else (
            "give each column a name; numbers with a decimal comma need another delimiter, such as ;"
        )  # fmt: skip
        raise InputError(problem, where=str(path), right=right)
    names = [name.strip().strip("\"'").strip() or str(1 + i) for i, name in enumerate(names or [""] * width)]
    counts = Counter(names)
    for name, count in counts.items():
        if count > 1:
            table.notes[""].append(f"{count} columns are called {name!r}: they are told apart by their number")
    return [f"{name} (column {1 + i})" if counts[name] > 1 else name for i, name in enumerate(names)]


def _only_comments(names: list[str]) -> bool:
    return all(not name or name.lower() in {"comment", "comments", "kommentar", "notes"} for name in names)


def _read_frames(
    path: Path, encoding: str, layout: TextLayout, progress: Progress | None, **options: Any
) -> tuple[list[Any], list[str]]:
    """Return the rows of a file as tables of pandas, and notes on rows left out; raise InputError for no table."""
    import pandas as pd  # noqa: PLC0415  # takes long to import

    old = tuple(map(int, pd.__version__.split(".")[:2])) < (3, 1)  # later versions read every digit by default
    exact: dict[str, Any] = {"float_precision": "round_trip"} if old else {}
    source = SampleLines(path, encoding, layout, progress)
    try:
        with source, pd.read_csv(
            source, sep=source.delimiter, header=None, names=list(range(layout.width)), chunksize=CHUNK_ROWS,
            skipinitialspace=True, keep_default_na=False, low_memory=False, index_col=False, **exact, **options,
        ) as chunks:  # fmt: skip
            frames = list(chunks)
    except (pd.errors.ParserError, csv.Error) as error:
        problem = " ".join(str(error).split())
        raise InputError(f"is not a table ({problem})", where=str(path), right="separate columns by commas") from None
    except pd.errors.EmptyDataError:
        frames = []
    notes = source.check()
    if not frames or not sum(map(len, frames)):
        raise InputError("holds no samples", where=str(path), right=ROWS_ADVICE)
    return frames, notes


def _read_columns(
    path: Path, encoding: str, layout: TextLayout, usual: Decimal, proven: Decimal | None, progress: Progress | None
) -> tuple[dict[int, ColumnReading], dict[int, list[str]], list[str]]:
    """Return columns by their position: numbers, and the cells of those that hold words.

    Columns that pandas reads as numbers with the usual decimal sign are kept; all others are read cell by cell.
    """
    frames, notes = _read_frames(path, encoding, layout, progress, decimal=usual, na_values=["", "nan", "NaN", "NAN"])
    cells: dict[int, ColumnReading] = {}
    by_cell = [i for i in range(layout.width) if any(_needs_cells(frame[i], proven) for frame in frames)]
    for i in set(range(layout.width)) - set(by_cell):
        cells[i] = ColumnReading(np.concatenate([frame[i].to_numpy(dtype=np.float64) for frame in frames]), proven=None)
    integers = {i for i in cells if all(frame[i].dtype.kind in "iub" for frame in frames)}
    words: dict[int, list[str]] = {}
    if by_cell:
        del frames
        texts, _ = _read_frames(path, encoding, layout, None, dtype=str, na_filter=False, usecols=by_cell)
        fractions = usual if proven or len(integers) < len(cells) else None
        read = {i: [cell for frame in texts for cell in frame[i].tolist()] for i in by_cell}
        cells |= _read_by_cell(read, fractions, path, layout)
        words = {i: column for i, column in read.items() if cells[i].values is None}
    return cells, words, notes


def _needs_cells(column: Any, proven: Decimal | None) -> bool:
    """Return whether a column must be read by cells: it has words, or fractions with an unproven decimal sign."""
    if column.dtype.kind not in "iufb":
        return True
    return column.dtype.kind == "f" and proven is None


def _read_by_cell(
    columns: dict[int, list[str]], usual: Decimal | None, path: Path, layout: TextLayout
) -> dict[int, ColumnReading]:
    """Return columns read cell by cell; those that prove no decimal sign use that of the others."""
    cells = {i: read_cells(column, usual, f"{path}, column {layout.names[i]}") for i, column in columns.items()}
    proven = {reading.proven for reading in cells.values() if reading.proven is not None}
    if len(proven) == 1:
        for i in [i for i, reading in cells.items() if reading.doubtful]:
            cells[i] = read_cells(columns[i], next(iter(proven)), f"{path}, column {layout.names[i]}")
    return cells


def _has_fractions(cells: dict[int, ColumnReading], words: dict[int, list[str]]) -> bool:
    """Return whether any column that pandas alone has read holds numbers with fractions."""
    read_by_pandas = [
        c.values
        for i, c in cells.items()
        if c.values is not None and c.proven is None and not c.notes and i not in words
    ]
    return any((values[np.isfinite(values)] % 1.0 != 0.0).any() for values in read_by_pandas)


def _fill_table(
    table: TextTable, layout: TextLayout, cells: dict[int, ColumnReading], words: dict[int, list[str]]
) -> None:
    """Add columns, units and notes to the table, by the names of the layout; leave out empty columns without name."""
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
        if column.unit == STAMP_UNIT:
            table.starts[name] = column.start
        stated = layout.units[i] if i < len(layout.units) else ""
        differ = stated and column.unit and column.unit not in {stated, STAMP_UNIT}
        table.units[name] = f"{stated} and {column.unit}" if differ else column.unit or stated
