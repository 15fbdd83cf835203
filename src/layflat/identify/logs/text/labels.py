"""Headings of recorders: rows that say in their first cell what they hold, and LabVIEW's measurement files (.lvm).

Rows hold names, units, and steps of time; LabVIEW's say decimal sign, separator, units, and a clock of even steps. Its
files may have several segments, each with a heading of its own.
"""

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np

from layflat.arrays import Array
from layflat.description.units import TIME
from layflat.identify.logs.text.numbers import Decimal, is_number, number, plain
from layflat.identify.logs.text.stamps import is_stamp
from layflat.identify.logs.units import kind_of_unit, unit_written

_NAMES = (
    "tracename", "signalname", "channelname", "kanalname", "name", "label", "displayname", "bezeichnung",
    "symbolname", "path",
)  # fmt: skip
_UNITS = ("vunit", "unit", "units", "yunit", "yunitlabel", "einheit", "verticalunits")
_STEPS = ("hresolution", "sampletime", "sampleinterval", "samplinginterval", "deltax", "deltat")
_STEP_UNITS = ("hunit", "xunit", "horizontalunits")
_EXPLAINED = re.compile(r"(?P<unit>\S+) \([^()]*\)|\([^()]*\)")  # "V (Voltage)", "(None)"
_UNIT_OF_LABEL = re.compile(r"[\[(](?P<unit>[^\[\]()]+)[\])]$")  # of "SampleTime[ms]"


class Block(NamedTuple):
    """Names and units of a table's columns by such a heading."""

    names: list[str]
    units: list[str]
    step: float  # s between samples, where no column has the times; 0 where one has


@dataclass(frozen=True)
class _Row:
    label: str  # in small letters, without its unit
    unit: str  # in brackets behind the label
    cells: list[str]


def read_block(rows: Sequence[list[str]], filled: Sequence[bool]) -> Block | None:
    """Return what the rows above the samples say of the columns; None where they have no labels.

    A label stands in the first cell of its row. Where it stands there again, as in "Name, angle, Name, pressure", the
    column below is the clock of the next ones.

    Args:
        rows: cells of the rows above the samples.
        filled: whether a column has values, for each.
    """
    labelled = [_Row(_label(row[0]), _unit_of(row[0]), row) for row in rows if row and row[0]]
    known = {row.label: row for row in labelled if len(filled) - 1 <= len(row.cells) <= len(filled)}
    names, units, step, step_unit = (
        next((known[label] for label in labels if label in known), None)
        for labels in (_NAMES, _UNITS, _STEPS, _STEP_UNITS)
    )
    if names is None or (units is None and step is None) or _is_header(labelled[-1], len(filled)):
        return None
    labels = [i for i, cell in enumerate(names.cells) if cell == names.cells[0]]
    titles = ["" if i in labels else cell for i, cell in enumerate(names.cells)]
    if not all(title for i, title in enumerate(titles) if filled[i] and i not in labels):
        return None
    clock = f"time [{step.unit}]" if step is not None and step.unit else "time"
    titles = [clock if i in labels and filled[i] else title for i, title in enumerate(titles)]
    stated = ["" if i in labels else _unit(cell) for i, cell in enumerate(units.cells)] if units is not None else []
    seconds = 0.0 if filled[0] or step is None else _seconds(step, step_unit)
    return Block(_padded(titles, len(filled)), _padded(stated, len(filled)), seconds)


def read_stated_units(rows: Sequence[list[str]], width: int) -> list[str]:
    """Return the units that a labelled row above the samples states; none where there is no such row.

    Args:
        rows: cells of the rows above the samples.
        width: number of columns.
    """
    stated = next((row for row in rows if len(row) == width and _label(row[0]) in _UNITS), None)
    return ["", *(_unit(cell) for cell in stated[1:])] if stated is not None else []


def _is_header(row: _Row, width: int) -> bool:
    """Return whether the last row above the samples is one of names, as any other table has."""
    words = [cell for cell in row.cells if cell and not is_number(plain(cell)) and not is_stamp(plain(cell))]
    return row.label not in {*_NAMES, *_UNITS} and len(words) == len(row.cells) == width


def _seconds(step: _Row, unit: _Row | None) -> float:
    """Return the step of all columns, s; 0 where it differs, or its unit is not known."""
    steps = {number(plain(cell), ".") for cell in step.cells[1:] if cell}
    units = {plain(cell) for cell in unit.cells[1:] if cell} if unit is not None else {step.unit}
    value, name = steps.pop() if len(steps) == 1 else None, units.pop() if len(units) == 1 else ""
    found = unit_written(name)
    if not value or found is None or kind_of_unit(found[0]) != TIME:
        return 0.0
    return value * TIME.convert(f"1 {found[0]}")


def _padded(cells: list[str], width: int) -> list[str]:
    return cells + [""] * (width - len(cells)) if cells else []


def _label(cell: str) -> str:
    return re.sub(r"[^a-z]", "", _UNIT_OF_LABEL.sub("", cell.strip()).lower())


def _unit_of(cell: str) -> str:
    match = _UNIT_OF_LABEL.search(cell.strip())
    return match["unit"] if match else ""


def _unit(cell: str) -> str:
    """Return a unit without the words behind it: "V" of "V (Voltage)", nothing of "(None)"."""
    text = plain(cell)
    match = _EXPLAINED.fullmatch(text)
    return text if match is None or unit_written(text) is not None else match["unit"] or ""


_SEPARATORS = {"tab": "\t", "comma": ",", "semicolon": ";", "space": " "}
CLOCK = "X_Value"
END = "***End_of_Header***"


@dataclass
class LabView:
    """Heading of a LabVIEW file; the defaults are those of any other file."""

    delimiter: str = ""
    decimal: Decimal | None = None
    units: list[str] = field(default_factory=list)
    start: float = 0.0
    step: float = 0.0  # s between samples; 0 where each sample says its time
    timed: bool = False  # the first column is a time
    lines: int = 0  # of the heading, that of the first segment among them
    inner: frozenset[int] = frozenset()  # numbers of the lines of the headings of all other segments, from 1
    segments: tuple[tuple[float, int], ...] = ()  # first time in s of each segment, and its samples

    def complete(self, columns: dict[str, Array | list[str]], units: dict[str, str]) -> None:
        """Add units, and the clock of a file whose rows do not have it."""
        if self.timed:
            units.update(dict.fromkeys([name for name in columns if name.startswith(CLOCK)], "s"))
            held = columns.get(CLOCK)
            size = max((len(column) for column in columns.values()), default=0)
            if self.step > 0.0 and (held is None or not np.isfinite(np.asarray(held, dtype=np.float64)).any()):
                clock = self._even_clock(size)
                if clock is None:
                    columns.pop(CLOCK, None)  # rows are left out: which time the others have is not known
                else:
                    columns[CLOCK] = clock
        names = list(columns)[1:] if next(iter(columns), "").startswith(CLOCK) else list(columns)
        for name, unit in zip(names, self.units, strict=False):  # where each signal has its times, empty above these
            if not name.startswith(CLOCK) and not isinstance(columns[name], list):
                units[name] = units.get(name) or unit

    def _even_clock(self, size: int) -> Array | None:
        """Return the times of all rows; None where there are fewer rows than the segments have."""
        segments = self.segments or ((self.start, size),)
        if sum(count for _, count in segments) != size:
            return None
        return np.concatenate([start + self.step * np.arange(count, dtype=np.float64) for start, count in segments])


def read_heading(lines: Sequence[str]) -> LabView:
    """Return what the heading of a LabVIEW measurement file says, from its first lines."""
    if not lines or not lines[0].lower().startswith("labview measurement"):
        return LabView()
    said: dict[str, list[str]] = {}
    separator = "\t" if any("\t" in line for line in lines) else ","
    for line in lines:
        key, *values = line.replace("\t", separator).split(separator)
        said.setdefault(key.strip().lower(), [value.strip() for value in values])
        if key.strip() == CLOCK:
            break
    decimal: Decimal = "," if said.get("decimal_separator", ["."])[0] == "," else "."
    steps = [number(value, decimal) or 0.0 for value in said.get("delta_x", [])]
    starts = [number(value, decimal) or 0.0 for value in said.get("x0", [])]
    timed = said.get("x_dimension", ["Time"])[0].lower() == "time"
    has_clock = said.get("x_columns", ["One"])[0].lower() != "no"
    return LabView(
        delimiter=_SEPARATORS.get(said.get("separator", [""])[0].lower(), separator),
        decimal=decimal,
        units=[{"volts": "V"}.get(unit.lower(), unit) for unit in said.get("y_unit_label", [])],
        start=starts[0] if starts else 0.0,
        step=0.0 if has_clock else (steps[0] if steps else 0.0),
        timed=timed,
        lines=1 + max([i for i, line in enumerate(lines) if line.startswith(END)][:2], default=-1),
    )


def with_segments(heading: LabView, lines: Iterable[str]) -> LabView:
    """Return what the headings of a file say, with those of its other segments, from all its lines."""
    inner, segments = set[int](), list[tuple[float, int]]()
    start, count, heads = heading.start, 0, False
    for i, line in enumerate(lines, 1):
        first, *rest = [cell.strip() for cell in line.split(heading.delimiter)]
        heads = (heads or first == "Channels") and i > heading.lines
        if heads:
            inner.add(i)
            if first == "Channels" and count:
                segments.append((start, count))
                count = 0
            if first == "X0" and rest:
                start = number(rest[0], heading.decimal or ".") or 0.0
            heads = first != CLOCK
        elif i > heading.lines and first != CLOCK and line.strip():
            count += 1
    return replace(heading, inner=frozenset(inner), segments=(*segments, (start, count)))
