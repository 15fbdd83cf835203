"""Headings of LabVIEW measurement files (.lvm): decimal sign, separator, units, and a clock of even steps.

A file may have several segments, each with a heading of its own.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from layflat.arrays import Array
from layflat.identify.logs.text.numbers import Decimal, number

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
