"""A measured torque-displacement table: from CSV to a `Characteristic`.

The first row that is not a comment (#) names the columns; the table runs from the collapsed hose on, in one direction:

    angle_deg,torque_Nm          or    travel_mm,force_N
    0,109.7                            0,4221
    13.3,104.1                         6.04,4004

A column `pressure_bar` gives the gauge pressure of each row; without it, one pressure holds for the whole table.
"""

from __future__ import annotations

import csv
from dataclasses import dataclass
from math import isfinite, radians
from pathlib import Path

import numpy as np
from numpy.polynomial import Chebyshev
from numpy.typing import NDArray

from layflat.description.text import check_regular
from layflat.design.characteristic import POINTS, Characteristic
from layflat.errors import InputError

Array = NDArray[np.float64]

TRAVELS = {"angle_deg": radians(1.0), "angle_rad": 1.0, "travel_mm": 1e-3, "travel_m": 1.0}
FORCES = {"torque_Nm": 1.0, "force_N": 1.0}
PRESSURES = {"pressure_bar": 1e5, "pressure_Pa": 1.0}
"""Known columns, and what turns each into its SI unit."""

PRESSURE_RANGE = 1e3, 1e7
"""Gauge pressures that a test may have had, Pa."""

LEAST_ROWS = 5
DEGREE = 4
"""Of the polynomial through the points. A cam's curvature hangs on second derivatives, so noise must not pass."""


@dataclass(frozen=True)
class _Table:
    columns: dict[str, Array]
    lines: list[int]


def read_characteristic(
    path: Path, *, pressure: float | None = None, roller_radius: float | None = None, degree: int = DEGREE
) -> Characteristic:
    """Return force over travel from a measured table.

    Args:
        path: CSV file, as this module's docstring shows.
        pressure: gauge pressure at which it was measured, Pa; needed where no column gives it.
        roller_radius: radius of the round roller that turned, m; needed for a table of angle and torque.
        degree: of the polynomial that is laid through the points (least squares).

    Raises:
        InputError: in one line, which file, line and column is wrong and what would be right.
    """
    where = str(path)
    if degree < 1:
        raise InputError(
            f"{degree} is below 1", where="degree of the polynomial", right=f"give 1 or more, such as {DEGREE}"
        )
    table = _read(path)
    travel_name, travel_unit = _one_of(table, TRAVELS, where)
    force_name, force_unit = _one_of(table, FORCES, where)
    s = table.columns[travel_name] * travel_unit
    F = table.columns[force_name] * force_unit
    turning = travel_name.startswith("angle")
    if turning != (force_name == "torque_Nm"):
        raise InputError(
            f"{travel_name} beside {force_name}", where=where, right="pair angle with torque_Nm, or travel with force_N"
        )
    if turning:
        r = _radius(roller_radius, where)
        s, F = s * r, F / r
    f = F / _pressures(table, pressure, where)
    _check_rows(s, f, table, (travel_name, force_name), where)
    return _smooth(s - s[0], f, min(degree, s.size - 1), path.name)


def _read(path: Path) -> _Table:
    where = str(path)
    check_regular(path, where, "give a CSV file with columns such as angle_deg,torque_Nm")
    try:
        with path.open(newline="", encoding="utf-8-sig") as file:
            rows = [(number, row) for number, row in enumerate(csv.reader(file, strict=True), 1) if _holds_data(row)]
    except OSError as error:
        right = "give a CSV file with columns such as angle_deg,torque_Nm"
        raise InputError(f"can't be read ({error.strerror})", where=where, right=right) from None
    except UnicodeDecodeError:
        raise InputError("is not a text file in UTF-8", where=where, right="save the table as CSV") from None
    except csv.Error as error:
        raise InputError(f"is not CSV ({error})", where=where, right="separate columns by commas") from None
    if len(rows) <= LEAST_ROWS:
        raise InputError(
            f"{max(len(rows) - 1, 0)} rows of data", where=where, right=f"give a header and at least {LEAST_ROWS} rows"
        )
    names = [name.strip() for name in rows[0][1]]
    doubled = next((name for name in names if names.count(name) > 1), None)
    if doubled is not None:
        raise InputError(f"column {doubled!r} appears twice", where=f"{where}, line {rows[0][0]}", right="keep one")
    values = [_numbers(row, names, f"{where}, line {number}") for number, row in rows[1:]]
    return _Table(dict(zip(names, np.array(values).T, strict=True)), [number for number, _ in rows[1:]])


def _holds_data(row: list[str]) -> bool:
    return any(cell.strip() for cell in row) and not row[0].lstrip().startswith("#")


def _numbers(row: list[str], names: list[str], where: str) -> list[float]:
    if len(row) != len(names):
        raise InputError(f"{len(row)} values", where=where, right=f"give {len(names)}: {', '.join(names)}")
    numbers = []
    for name, cell in zip(names, row, strict=True):
        try:
            number = float(cell)
        except ValueError:
            raise InputError(f"{cell.strip()!r} is not a number", where=f"{where}: {name}", right="use 12.5") from None
        if not isfinite(number):
            raise InputError(
                f"{cell.strip()!r} is not finite", where=f"{where}: {name}", right="drop rows without data"
            )
        numbers.append(number)
    return numbers


def _one_of(table: _Table, known: dict[str, float], where: str) -> tuple[str, float]:
    found = [name for name in known if name in table.columns]
    if len(found) != 1:
        what = f"columns {', '.join(found)} say the same" if found else f"no column {' or '.join(known)}"
        raise InputError(what, where=where, right=f"columns here are {', '.join(table.columns)}; name one of them so")
    return found[0], known[found[0]]


def _radius(value: float | None, where: str) -> float:
    if value is None or not (isfinite(value) and value > 0):
        what = "is missing" if value is None else f"{value:.6g} is not positive"
        right = "give that of the roller which was measured, in metres"
        raise InputError(what, where=f"{where}: roller radius", right=right)
    return value


def _pressures(table: _Table, pressure: float | None, where: str) -> Array | float:
    least, greatest = PRESSURE_RANGE
    right = f"give the gauge pressure of the test, {least / 1e5:g} bar to {greatest / 1e5:g} bar"
    if not any(name in table.columns for name in PRESSURES):
        if pressure is None:
            raise InputError("is missing", where=f"{where}: pressure", right=f"{right}, or a column pressure_bar")
        if not least <= pressure <= greatest:
            raise InputError(f"{pressure / 1e5:.6g} bar", where=f"{where}: pressure", right=right)
        return pressure
    name, unit = _one_of(table, PRESSURES, where)
    values = table.columns[name] * unit
    wrong = np.flatnonzero((values < least) | (values > greatest))
    if wrong.size:
        line = f"{where}, line {table.lines[wrong[0]]}: {name}"
        raise InputError(f"{values[wrong[0]] / 1e5:.6g} bar", where=line, right=right)
    return values


def _check_rows(s: Array, f: Array, table: _Table, names: tuple[str, str], where: str) -> None:
    falling = np.flatnonzero(np.diff(s) <= 0)
    if falling.size:
        row = int(falling[0]) + 1
        raise InputError(
            f"{table.columns[names[0]][row]:.6g} does not rise above the line before",
            where=f"{where}, line {table.lines[row]}: {names[0]}",
            right="order the rows by travel; of a hysteresis curve, give the mean of both directions",
        )
    if not (f > 0).all():
        row = int(np.argmax(f <= 0))
        raise InputError(
            f"{table.columns[names[1]][row]:.6g} is not positive",
            where=f"{where}, line {table.lines[row]}: {names[1]}",
            right="give what the hose pulls, as a positive number, and end the table before it pulls no more",
        )


def _smooth(s: Array, f: Array, degree: int, source: str) -> Characteristic:
    fitted = Chebyshev.fit(s, f, degree)
    nodes = np.linspace(0.0, s[-1], POINTS)
    error = float(np.abs(fitted(s) - f).max() / f.max())
    return Characteristic(nodes, np.asarray(fitted(nodes), dtype=float), source, error)
