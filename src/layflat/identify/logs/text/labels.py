"""Headings of recorders in which each row says in its first cell what it holds: names, units, steps of time."""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

from layflat.description.units import TIME
from layflat.identify.logs.text.numbers import is_number, number, plain
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
