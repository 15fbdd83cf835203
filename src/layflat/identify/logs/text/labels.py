"""Headings of recorders: rows that begin with a label, and LabVIEW's measurement files (.lvm).

Labelled rows hold names, units, and steps of time. LabVIEW's headings state decimal sign, separator, units, and an even
clock; a file may have several segments, each with a heading.
"""

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np

from layflat.arrays import Array
from layflat.description.units import TIME
from layflat.identify.logs.text.numbers import Decimal, is_number, normalize_cell, parse_number
from layflat.identify.logs.text.stamps import is_stamp
from layflat.identify.logs.vocabulary import kind_of_unit, parse_unit

_NAME_LABELS = (
    "tracename", "signalname", "channelname", "kanalname", "name", "label", "displayname", "bezeichnung",
    "symbolname", "path",
)  # fmt: skip
_UNIT_LABELS = ("vunit", "unit", "units", "yunit", "yunitlabel", "einheit", "verticalunits")
_STEP_LABELS = ("hresolution", "sampletime", "sampleinterval", "samplinginterval", "deltax", "deltat")
_STEP_UNIT_LABELS = ("hunit", "xunit", "horizontalunits")
_EXPLAINED_UNIT = re.compile(r"(?P<unit>\S+) \([^()]*\)|\([^()]*\)")  # "V (Voltage)", "(None)"
_UNIT_OF_LABEL = re.compile(r"[\[(](?P<unit>[^\[\]()]+)[\])]$")  # of "SampleTime[ms]"


class HeadingBlock(NamedTuple):
    """Names and units of a table's columns from its labelled rows."""

    names: list[str]
    units: list[str]
    step: float  # s between samples; 0 where a column is the clock


@dataclass(frozen=True)
class _LabelledRow:
    """Row whose first cell is a label."""

    label: str  # in small letters, without its unit
    unit: str  # in brackets behind the label
    cells: list[str]


def read_block(rows: Sequence[list[str]], filled: Sequence[bool]) -> HeadingBlock | None:
    """Return names, units and step from labelled rows above the samples; None where there are none.

    A label is the first cell of its row. Where it is repeated, as in "Name, angle, Name, pressure", the column below is
    the clock of the next ones.

    Args:
        rows: cells of the rows above the samples.
        filled: whether a column has values, for each.
    """
    labelled = [_LabelledRow(_plain_label(row[0]), _unit_of_label(row[0]), row) for row in rows if row and row[0]]
    row_by_label = {row.label: row for row in labelled if len(filled) - 1 <= len(row.cells) <= len(filled)}
    names, units, step, step_unit = (
        next((row_by_label[label] for label in labels if label in row_by_label), None)
        for labels in (_NAME_LABELS, _UNIT_LABELS, _STEP_LABELS, _STEP_UNIT_LABELS)
    )
    if names is None or (units is None and step is None) or _is_header(labelled[-1], len(filled)):
        return None
    labels = [i for i, cell in enumerate(names.cells) if cell == names.cells[0]]
    titles = ["" if i in labels else cell for i, cell in enumerate(names.cells)]
    if not all(title for i, title in enumerate(titles) if filled[i] and i not in labels):
        return None
    clock = f"time [{step.unit}]" if step is not None and step.unit else "time"
    titles = [clock if i in labels and filled[i] else title for i, title in enumerate(titles)]
    stated = (
        ["" if i in labels else _bare_unit(cell) for i, cell in enumerate(units.cells)] if units is not None else []
    )
    seconds = 0.0 if filled[0] or step is None else _step_seconds(step, step_unit)
    return HeadingBlock(_pad_cells(titles, len(filled)), _pad_cells(stated, len(filled)), seconds)


def read_stated_units(rows: Sequence[list[str]], width: int) -> list[str]:
    """Return the units of a labelled row above the samples; none where there is no such row.

    Args:
        rows: cells of the rows above the samples.
        width: number of columns.
    """
    stated = next((row for row in rows if len(row) == width and _plain_label(row[0]) in _UNIT_LABELS), None)
    return ["", *(_bare_unit(cell) for cell in stated[1:])] if stated is not None else []


def _is_header(row: _LabelledRow, width: int) -> bool:
    """Return whether a row above the samples is an ordinary header: words in all columns."""
    words = [
        cell
        for cell in row.cells
        if cell and not is_number(normalize_cell(cell)) and not is_stamp(normalize_cell(cell))
    ]
    return row.label not in {*_NAME_LABELS, *_UNIT_LABELS} and len(words) == len(row.cells) == width


def _step_seconds(step: _LabelledRow, unit: _LabelledRow | None) -> float:
    """Return the step of all columns, s; 0 where steps differ, or the unit is not known."""
    steps = {parse_number(normalize_cell(cell), ".") for cell in step.cells[1:] if cell}
    units = {normalize_cell(cell) for cell in unit.cells[1:] if cell} if unit is not None else {step.unit}
    value, name = steps.pop() if len(steps) == 1 else None, units.pop() if len(units) == 1 else ""
    parsed = parse_unit(name)
    if not value or parsed is None or kind_of_unit(parsed[0]) != TIME:
        return 0.0
    return value * TIME.convert(f"1 {parsed[0]}")


def _pad_cells(cells: list[str], width: int) -> list[str]:
    """Return cells filled up with empty ones to a width; none for none."""
    return cells + [""] * (width - len(cells)) if cells else []


def _plain_label(cell: str) -> str:
    """Return a label in small letters alone, without its unit."""
    return re.sub(r"[^a-z]", "", _UNIT_OF_LABEL.sub("", cell.strip()).lower())


def _unit_of_label(cell: str) -> str:
    """Return the unit in brackets behind a label; "" without one."""
    match = _UNIT_OF_LABEL.search(cell.strip())
    return match["unit"] if match else ""


def _bare_unit(cell: str) -> str:
    """Return a unit without the words behind it: "V" of "V (Voltage)", "" of "(None)"."""
    text = normalize_cell(cell)
    match = _EXPLAINED_UNIT.fullmatch(text)
    return text if match is None or parse_unit(text) is not None else match["unit"] or ""


_SEPARATORS = {"tab": "\t", "comma": ",", "semicolon": ";", "space": " "}
X_COLUMN = "X_Value"
END_OF_HEADER = "***End_of_Header***"


@dataclass
class LabViewHeading:
    """Heading of a LabVIEW file; the defaults mean any other file."""

    delimiter: str = ""
    decimal: Decimal | None = None
    units: list[str] = field(default_factory=list)
    start: float = 0.0
    step: float = 0.0  # s between samples; 0 where a column is the clock
    timed: bool = False  # the first column is a time
    lines: int = 0  # of the heading, with that of the first segment
    inner: frozenset[int] = frozenset()  # numbers of the lines of the headings of all other segments, from 1
    segments: tuple[tuple[float, int], ...] = ()  # first time, s, and number of samples of each

    def complete(self, columns: dict[str, Array | list[str]], units: dict[str, str]) -> None:
        """Add units and the clock of a file without times to `columns` and `units`, in place.

        The column of times is dropped where the segments have another number of rows.
        """
        if self.timed:
            units.update(dict.fromkeys([name for name in columns if name.startswith(X_COLUMN)], "s"))
            stated_clock = columns.get(X_COLUMN)
            size = max((len(column) for column in columns.values()), default=0)
            if self.step > 0.0 and (
                stated_clock is None or not np.isfinite(np.asarray(stated_clock, dtype=np.float64)).any()
            ):
                clock = self._even_clock(size)
                if clock is None:
                    columns.pop(X_COLUMN, None)  # rows are missing: the times of the others are not known
                else:
                    columns[X_COLUMN] = clock
        names = list(columns)[1:] if next(iter(columns), "").startswith(X_COLUMN) else list(columns)
        for name, unit in zip(names, self.units, strict=False):  # where each signal has its times, empty above these
            if not name.startswith(X_COLUMN) and not isinstance(columns[name], list):
                units[name] = units.get(name) or unit

    def _even_clock(self, size: int) -> Array | None:
        """Return the times of all rows, s; None if the segments have another number of rows."""
        segments = self.segments or ((self.start, size),)
        if sum(count for _, count in segments) != size:
            return None
        return np.concatenate([start + self.step * np.arange(count, dtype=np.float64) for start, count in segments])


def read_heading(lines: Sequence[str]) -> LabViewHeading:
    """Return the heading of a LabVIEW measurement file from its first lines; the default for other files."""
    if not lines or not lines[0].lower().startswith("labview measurement"):
        return LabViewHeading()
    values_by_key: dict[str, list[str]] = {}
    separator = "\t" if any("\t" in line for line in lines) else ","
    for line in lines:
        key, *values = line.replace("\t", separator).split(separator)
        values_by_key.setdefault(key.strip().lower(), [value.strip() for value in values])
        if key.strip() == X_COLUMN:
            break
    decimal: Decimal = "," if values_by_key.get("decimal_separator", ["."])[0] == "," else "."
    steps = [parse_number(value, decimal) or 0.0 for value in values_by_key.get("delta_x", [])]
    starts = [parse_number(value, decimal) or 0.0 for value in values_by_key.get("x0", [])]
    timed = values_by_key.get("x_dimension", ["Time"])[0].lower() == "time"
    has_clock = values_by_key.get("x_columns", ["One"])[0].lower() != "no"
    return LabViewHeading(
        delimiter=_SEPARATORS.get(values_by_key.get("separator", [""])[0].lower(), separator),
        decimal=decimal,
        units=[{"volts": "V"}.get(unit.lower(), unit) for unit in values_by_key.get("y_unit_label", [])],
        start=starts[0] if starts else 0.0,
        step=0.0 if has_clock else (steps[0] if steps else 0.0),
        timed=timed,
        lines=1 + max([i for i, line in enumerate(lines) if line.startswith(END_OF_HEADER)][:2], default=-1),
    )


def read_segments(heading: LabViewHeading, lines: Iterable[str]) -> LabViewHeading:
    """Return the heading with the segments of a file, from all its lines."""
    inner, segments = set[int](), list[tuple[float, int]]()
    start, count, in_heading = heading.start, 0, False
    for i, line in enumerate(lines, 1):
        first, *rest = [cell.strip() for cell in line.split(heading.delimiter)]
        in_heading = (in_heading or first == "Channels") and i > heading.lines
        if in_heading:
            inner.add(i)
            if first == "Channels" and count:
                segments.append((start, count))
                count = 0
            if first == "X0" and rest:
                start = parse_number(rest[0], heading.decimal or ".") or 0.0
            in_heading = first != X_COLUMN
        elif i > heading.lines and first != X_COLUMN and line.strip():
            count += 1
    return replace(heading, inner=frozenset(inner), segments=(*segments, (start, count)))
