"""Tables of text: CSV with any delimiter, with a header, a header and a line of units, or neither."""

import csv
from contextlib import suppress
from pathlib import Path

import numpy as np

from layflat.errors import InputError
from layflat.identify.logs.headers import written_unit
from layflat.identify.logs.table import Cells

DELIMITERS = (",", "\t", ";", "|", " ")
LOOKED_AT = 50  # lines that the delimiter is told from


def read_text(path: Path) -> tuple[dict[str, Cells], dict[str, str]]:
    """Columns of a table of text by name, and the units of a line of units.

    Lines that begin with # and empty lines are left out. Columns of a table without header are called by their number,
    "1", "2" and so on, and so is one whose header is empty. In a table parted by semicolons a number may have a decimal
    comma. Raise InputError if it is not a table.
    """
    where = str(path)
    try:
        with path.open(newline="", encoding="utf-8-sig") as file:
            lines = [line for line in file if line.strip() and not line.lstrip().startswith("#")]
    except UnicodeDecodeError:
        right = "give CSV in UTF-8, or a file that ends in .parquet, .nc or .mcap"
        raise InputError("is not a text file in UTF-8", where=where, right=right) from None
    delimiter, numbers = _delimiter(lines[:LOOKED_AT]), None
    try:
        names, units = _heading(_rows(lines[:2], delimiter))
        body = lines[bool(names) + bool(units) :]
        with suppress(ValueError):  # a table of numbers alone, in a tenth of the time
            numbers = np.loadtxt(body, delimiter=delimiter, comments=None, ndmin=2) if body else None
        rows = _rows(body, delimiter) if numbers is None else numbers[:1].astype(str).tolist()
    except csv.Error as error:
        raise InputError(f"is not CSV ({error})", where=where, right="separate columns by commas") from None
    if not rows:
        raise InputError("holds no samples", where=where, right="give a table with a row a sample")
    names = [name or str(1 + i) for i, name in enumerate(names or [""] * len(rows[0]))]
    _check_shape(names, rows, where)
    columns: dict[str, Cells] = {}
    for i, name in enumerate(names):
        columns[name] = _cells([row[i] for row in rows], delimiter) if numbers is None else numbers[:, i]
    return columns, dict(zip(names, units, strict=True)) if units else {}


def _rows(lines: list[str], delimiter: str) -> list[list[str]]:
    reader = csv.reader(lines, delimiter=delimiter, skipinitialspace=True, strict=True)
    return [[cell.strip() for cell in row] for row in reader]


def _delimiter(lines: list[str]) -> str:
    """The one that parts most lines alike, into most columns; a comma for a table of one column."""

    def columns(delimiter: str) -> int:
        try:
            counts = [len(row) for row in csv.reader(lines, delimiter=delimiter, skipinitialspace=True)]
        except csv.Error:
            return 0
        usual = max(counts, key=counts.count, default=0)
        return usual if 2 * counts.count(usual) > len(counts) else 0

    if lines and ";" in lines[-1] and columns(";") > 1:
        return ";"  # commas beside are decimal
    return max(DELIMITERS, key=columns)


def _heading(head: list[list[str]]) -> tuple[list[str], list[str]]:
    """Names and units of the columns; empty where the table doesn't say."""
    if not head or all(_is_number(cell) for cell in head[0]):
        return [], []
    names = head[0]
    if len(head) == 2 and len(head[1]) == len(names):
        units = [cell.strip("[]() ") for cell in head[1]]
        if any(units) and all(not unit or written_unit(unit)[0] for unit in units) and not _is_number(head[1][0]):
            return names, units
    return names, []


def _is_number(cell: str) -> bool:
    """An empty cell counts as one: a sample that is missing."""
    try:
        float(cell.replace(",", ".") or "0")
    except ValueError:
        return False
    return True


def _check_shape(names: list[str], rows: list[list[str]], where: str) -> None:
    doubled = next((name for name in names if name and names.count(name) > 1), None)
    if doubled is not None:
        raise InputError(f"column {doubled!r} stands there twice", where=where, right="rename one of them")
    odd = next((i for i, row in enumerate(rows) if len(row) != len(names)), None)
    if odd is not None:
        right = f"give {len(names)} as in its header"
        raise InputError(f"{len(rows[odd])} values", where=f"{where}, sample {odd + 1}", right=right)


def _cells(cells: list[str], delimiter: str) -> Cells:
    """Numbers where all cells are some or empty, else text."""
    if delimiter == ";" and any("," in cell for cell in cells):
        cells = [cell.replace(",", ".") for cell in cells]
    try:
        return np.array([cell or "nan" for cell in cells], dtype=np.float64)
    except ValueError:
        return cells
