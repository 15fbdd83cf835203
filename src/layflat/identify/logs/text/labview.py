"""Headings of LabVIEW measurement files (.lvm): decimal sign, separator, units, and a clock of even steps."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from layflat.arrays import Array
from layflat.identify.logs.text.numbers import Decimal, number

_SEPARATORS = {"tab": "\t", "comma": ",", "semicolon": ";", "space": " "}
CLOCK = "X_Value"
END = "***End_of_Header***"


@dataclass
class LabView:
    """What a heading says; empty for any other file."""

    delimiter: str = ""
    decimal: Decimal | None = None
    units: list[str] = field(default_factory=list)
    start: float = 0.0
    step: float = 0.0  # s between samples; 0 where each sample says its time
    timed: bool = False  # the first column is a time
    lines: int = 0  # of the heading

    def complete(self, columns: dict[str, Array | list[str]], units: dict[str, str]) -> None:
        """Add units, and the clock of a file whose rows do not have it."""
        if self.timed:
            units[CLOCK] = "s"
            held = columns.get(CLOCK)
            size = max((len(column) for column in columns.values()), default=0)
            if self.step > 0.0 and (held is None or not np.isfinite(np.asarray(held, dtype=np.float64)).any()):
                columns[CLOCK] = self.start + self.step * np.arange(size, dtype=np.float64)
        signals = [name for name in columns if name != CLOCK and not isinstance(columns[name], list)]
        for name, unit in zip(signals, self.units, strict=False):
            units[name] = units.get(name) or unit


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
        lines=1 + max((i for i, line in enumerate(lines) if line.startswith(END)), default=-1),
    )
