"""Arrangement of a table: a column a signal over one clock, a clock for each column, or a sample a row."""

from collections.abc import Mapping

import numpy as np

from layflat.arrays import Array
from layflat.identify.logs.long_tables import find_long_table, pivot_signals
from layflat.identify.logs.paired_clocks import assign_clocks, find_clock_pairs
from layflat.identify.logs.table import Cells, FileContent, Header, LogColumn, parse_header
from layflat.identify.logs.text.cells import read_cells

MISSING_CODES = (
    999.0,
    9999.0,
    99999.0,
    999999.0,
    999.9,
    9999.9,
    99999.9,
    999.99,
    9999.99,
)  # written for a missing sample
MIN_OVERFLOW_CODE = 9e36  # magnitude from which a number is such a code too
MIN_OTHER_SAMPLES = 10  # other samples that are needed to see that a code stands far out
MIN_CODE_RATIO = 2.5  # magnitude of a code over the greatest of the other samples


def arrange_columns(
    cells: Mapping[str, Cells],
    units: Mapping[str, str],
    notes: Mapping[str, list[str]] | None = None,
    starts: Mapping[str, float] | None = None,
) -> FileContent:
    """Arrange cells as columns: one for each header, or for each signal of a table in long format.

    Args:
        cells: numbers, or words, of each column.
        units: stated in the file beside the names, by column.
        notes: on single columns; default: those of reading their words as numbers.
        starts: first stamps of columns of dates or clock times, s, by which two clocks can be compared.

    Returns:
        The columns of numbers, their clock, and the columns of words with the reason why they are left out.
    """
    headers = {name: parse_header(name, units.get(name, "")) for name in cells}
    for name in [name for name, header in headers.items() if header.unit == "Pa" and not units.get(name)]:
        if "Pa" in name and name.replace("Pa", "Pb") in cells:  # the pressures of two hoses
            headers[name] = Header(name, stem=name)
    long_table = find_long_table(headers, cells)
    if long_table is not None:
        content = pivot_signals(long_table, headers, cells)
        return content._replace(columns={name: _mask_column_codes(column) for name, column in content.columns.items()})
    columns, words = _arrange_side_by_side(cells, headers, units, notes)
    pairs = find_clock_pairs(columns)
    if not pairs:
        return FileContent(columns, None, words)
    content = assign_clocks(columns, pairs, starts or {})
    return content._replace(words=words | dict(content.words))


def _arrange_side_by_side(
    cells: Mapping[str, Cells],
    headers: Mapping[str, Header],
    units: Mapping[str, str],
    notes: Mapping[str, list[str]] | None,
) -> tuple[dict[str, LogColumn], dict[str, str]]:
    """Return a column for each header, and the reasons by name why the others hold no numbers."""
    notes = notes or {}
    columns: dict[str, LogColumn] = {}
    words: dict[str, str] = {}
    for name, values in cells.items():
        if isinstance(values, np.ndarray):
            columns[name] = _mask_column_codes(LogColumn(values, headers[name], notes=tuple(notes.get(name, ()))))
            continue
        read = read_cells(values, None, name) if name not in notes else None
        if read is None or read.values is None:
            words[name] = "; ".join(notes.get(name, read.notes if read else []))
        else:
            header = parse_header(name, units.get(name, "") or read.unit)
            columns[name] = LogColumn(read.values, header, notes=tuple(read.notes))
    return columns, words


def _mask_column_codes(column: LogColumn) -> LogColumn:
    """Return a column with NaN for codes of missing samples, and a note on them."""
    values, notes = mask_missing_codes(column.values)
    return LogColumn(values, column.header, column.stamps, (*column.notes, *notes)) if notes else column


def mask_missing_codes(values: Array) -> tuple[Array, list[str]]:
    """Return values with NaN for codes of missing samples, such as -9999, and a note.

    Values stay as they are, with no note, unless the codes exceed `MIN_CODE_RATIO` times all other magnitudes.
    """
    sizes = np.abs(values)
    coded = np.isfinite(values) & (np.isin(sizes, MISSING_CODES) | (sizes >= MIN_OVERFLOW_CODE))
    rest = sizes[np.isfinite(values) & ~coded]
    if not coded.any() or rest.size < MIN_OTHER_SAMPLES or sizes[coded].min() < MIN_CODE_RATIO * rest.max():
        return values, []
    codes = ", ".join(f"{code:g}" for code in np.unique(values[coded]))
    count = int(coded.sum())
    note = f"{count} sample{'s' if count > 1 else ''} of {codes} {'are' if count > 1 else 'is'} taken for missing"
    return np.where(coded, np.nan, values), [note]
