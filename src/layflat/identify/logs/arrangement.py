"""Arrangement of a table: a column a signal over one clock, a clock for each column, or a sample a row."""

from collections.abc import Mapping

import numpy as np

from layflat.arrays import Array
from layflat.identify.logs.headers import Header, header_of
from layflat.identify.logs.long_tables import find_long, pivot
from layflat.identify.logs.paired_clocks import find_pairs, with_own_clocks
from layflat.identify.logs.table import Cells, Column, Content
from layflat.identify.logs.text.cells import read_cells

CODES = (999.0, 9999.0, 99999.0, 999999.0, 999.9, 9999.9, 99999.9, 999.99, 9999.99)  # in place of a missing sample
OVERFLOW = 9e36  # from which numbers are such codes too
LEAST_REST = 10  # other samples that tell how far out a code stands
FAR_OUT = 2.5  # times the greatest magnitude of the rest that a code has at least


def arranged(
    cells: Mapping[str, Cells],
    units: Mapping[str, str],
    notes: Mapping[str, list[str]] | None = None,
    starts: Mapping[str, float] | None = None,
) -> Content:
    """Return columns from cells: one for each header, or for each signal of a table in long format.

    Args:
        cells: numbers, or words, of each column.
        units: that are stated beside the names.
        notes: on single columns; default: those that come of reading words.
        starts: first stamps of columns of dates or clock times, s, by which two clocks can be compared.
    """
    headers = {name: header_of(name, units.get(name, "")) for name in cells}
    for name in [name for name, header in headers.items() if header.unit == "Pa" and not units.get(name)]:
        if "Pa" in name and name.replace("Pa", "Pb") in cells:  # the pressures of two hoses
            headers[name] = Header(name, stem=name)
    roles = find_long(headers, cells)
    if roles is not None:
        content = pivot(roles, headers, cells)
        return content._replace(columns={name: _without_codes(column) for name, column in content.columns.items()})
    columns, words = _side_by_side(cells, headers, units, notes)
    pairs = find_pairs(columns)
    if not pairs:
        return Content(columns, None, words)
    content = with_own_clocks(columns, pairs, starts or {})
    return content._replace(words=words | dict(content.words))


def _side_by_side(
    cells: Mapping[str, Cells],
    headers: Mapping[str, Header],
    units: Mapping[str, str],
    notes: Mapping[str, list[str]] | None,
) -> tuple[dict[str, Column], dict[str, str]]:
    """Return a column for each header, and names of those that hold words, with the reason."""
    notes = notes or {}
    columns: dict[str, Column] = {}
    words: dict[str, str] = {}
    for name, values in cells.items():
        if isinstance(values, np.ndarray):
            columns[name] = _without_codes(Column(values, headers[name], notes=tuple(notes.get(name, ()))))
            continue
        read = read_cells(values, None, name) if name not in notes else None
        if read is None or read.values is None:
            words[name] = "; ".join(notes.get(name, read.notes if read else []))
        else:
            header = header_of(name, units.get(name, "") or read.unit)
            columns[name] = Column(read.values, header, notes=tuple(read.notes))
    return columns, words


def _without_codes(column: Column) -> Column:
    known, told = without_codes(column.values)
    return Column(known, column.header, column.stamps, (*column.notes, *told)) if told else column


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
