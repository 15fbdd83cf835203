"""A measured torque-displacement table: from CSV to a `Characteristic`.

The first row that is not a comment (#) names the columns; the table runs from the collapsed hose on, in one direction:

    angle_deg,torque_Nm          or    travel_mm,force_N
    0,109.7                            0,4221
    13.3,104.1                         6.04,4004

A column `pressure_bar` gives the gauge pressure of each row; without it, one pressure holds for the whole table.
"""

import csv
from io import StringIO
from math import isfinite, radians
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.polynomial import Chebyshev
from numpy.typing import NDArray

from layflat.arrays import Array
from layflat.description.text import read_text
from layflat.design.characteristic import CURVE_POINTS, Characteristic
from layflat.errors import InputError

TRAVEL_SCALES = {"angle_deg": radians(1.0), "angle_rad": 1.0, "travel_mm": 1e-3, "travel_m": 1.0}
FORCES = {"torque_Nm": 1.0, "force_N": 1.0}
PRESSURES = {"pressure_bar": 1e5, "pressure_Pa": 1.0}  # columns, and the factor of each to its SI unit
PRESSURE_RANGE = 1e3, 1e7  # plausible gauge pressures of a test, Pa
LEAST_ROWS = 5
POLYNOMIAL_DEGREE = 4  # of the fit through the points: low, since a cam's curvature has second derivatives of it


class _Table(NamedTuple):
    """Columns by name, and the line of each row."""

    where: str
    columns: dict[str, Array]
    lines: list[int]

    def one_of(self, factors: dict[str, float]) -> tuple[str, Array]:
        """Return name and values (SI) of the one column in `factors` (to SI); raise InputError for none or several."""
        names = [name for name in factors if name in self.columns]
        if len(names) != 1:
            what = (
                f"columns {', '.join(names)} give the same quantity" if names else f"no column {' or '.join(factors)}"
            )
            right = f"columns here are {', '.join(self.columns)}; name one of them so"
            raise InputError(what, where=self.where, right=right)
        return names[0], self.columns[names[0]] * factors[names[0]]

    def refuse(self, wrong: NDArray[np.bool_], name: str, what: str, right: str) -> None:
        """Raise an error for the first wrong row of a column, if there is one.

        Args:
            wrong: whether each row is wrong, (rows,).
            name: name of the column.
            what: the problem, in which {} stands for the value.
            right: advice.

        Raises:
            InputError: naming file, line and column.
        """
        if wrong.any():
            row = int(np.argmax(wrong))
            where = f"{self.where}, line {self.lines[row]}: {name}"
            raise InputError(what.format(f"{self.columns[name][row]:.6g}"), where=where, right=right)


def read_characteristic(
    path: Path, *, pressure: float | None = None, roller_radius: float | None = None, degree: int = POLYNOMIAL_DEGREE
) -> Characteristic:
    """Return the characteristic of a measured table.

    Args:
        path: CSV file, as this module's docstring shows.
        pressure: gauge pressure of the measurement, Pa; needed without a column of pressures.
        roller_radius: radius of the round roller of the measurement, m; needed for a table of angle and torque.
        degree: degree of the polynomial that is fitted to the points (least squares).

    Raises:
        InputError: naming file, line and column: the table or an argument is not valid.
    """
    if degree < 1:
        where = "degree of the polynomial"
        raise InputError(f"{degree} is below 1", where=where, right=f"give 1 or more, such as {POLYNOMIAL_DEGREE}")
    table = _read_table(path)
    travel_name, s = table.one_of(TRAVEL_SCALES)
    force_name, F = table.one_of(FORCES)
    turning = travel_name.startswith("angle")
    if turning != (force_name == "torque_Nm"):
        right = "pair angle with torque_Nm, or travel with force_N"
        raise InputError(f"{travel_name} beside {force_name}", where=table.where, right=right)
    if turning:
        if roller_radius is None or not (isfinite(roller_radius) and roller_radius > 0):
            what = "is missing" if roller_radius is None else f"{roller_radius:.6g} is not positive"
            right = "give that of the roller which was measured, in metres"
            raise InputError(what, where=f"{table.where}: roller radius", right=right)
        s, F = s * roller_radius, F / roller_radius
    f = F / _read_pressures(table, pressure)
    right = "order the rows by travel; of a hysteresis curve, give the mean of both directions"
    table.refuse(np.diff(s, prepend=-np.inf) <= 0, travel_name, "{} does not rise above the line before", right)
    right = "give what the hose pulls, as a positive number, and end the table before it pulls no more"
    table.refuse(~(f > 0), force_name, "{} is not positive", right)
    fitted = Chebyshev.fit(s - s[0], f, min(degree, s.size - 1))
    nodes = np.linspace(0.0, s[-1] - s[0], CURVE_POINTS)
    error = float(np.abs(fitted(s - s[0]) - f).max() / f.max())
    return Characteristic(nodes, np.asarray(fitted(nodes), dtype=float), path.name, error)


def _read_table(path: Path) -> _Table:
    """Return the columns of a CSV file with the numbers of their lines; raise InputError for the first mistake."""
    where = str(path)
    text = read_text(path, where, "give a CSV file with columns such as angle_deg,torque_Nm")
    try:
        rows = [
            (line, row)
            for line, row in enumerate(csv.reader(StringIO(text, newline=""), strict=True), 1)
            if any(cell.strip() for cell in row) and not row[0].lstrip().startswith("#")
        ]
    except csv.Error as error:
        raise InputError(f"is not CSV ({error})", where=where, right="separate columns by commas") from None
    if len(rows) <= LEAST_ROWS:
        right = f"give a header and at least {LEAST_ROWS} rows"
        count = max(len(rows) - 1, 0)
        raise InputError(f"{count} row{'' if count == 1 else 's'} of data", where=where, right=right)
    names = [name.strip() for name in rows[0][1]]
    doubled = [name for name in names if names.count(name) > 1]
    if doubled:
        raise InputError(f"column {doubled[0]!r} appears twice", where=f"{where}, line {rows[0][0]}", right="keep one")
    values = [_parse_numbers(row, names, f"{where}, line {line}") for line, row in rows[1:]]
    return _Table(where, dict(zip(names, np.array(values).T, strict=True)), [line for line, _ in rows[1:]])


def _parse_numbers(row: list[str], names: list[str], where: str) -> list[float]:
    """Return the finite numbers in a row with these columns; raise InputError if there are others."""
    if len(row) != len(names):
        raise InputError(f"{len(row)} values", where=where, right=f"give {len(names)}: {', '.join(names)}")
    numbers = []
    for name, cell in zip(names, row, strict=True):
        try:
            numbers.append(float(cell))
        except ValueError:
            raise InputError(f"{cell.strip()!r} is not a number", where=f"{where}: {name}", right="use 12.5") from None
        if not isfinite(numbers[-1]):
            what = f"{cell.strip()!r} is not finite"
            raise InputError(what, where=f"{where}: {name}", right="drop rows without data")
    return numbers


def _read_pressures(table: _Table, pressure: float | None) -> Array | float:
    """Return gauge pressures of the rows, or the one of all, Pa; raise InputError if missing or out of range."""
    low, high = PRESSURE_RANGE
    where = f"{table.where}: pressure"
    right = f"give the gauge pressure of the test, {low / 1e5:g} bar to {high / 1e5:g} bar"
    if table.columns.keys() & PRESSURES.keys():
        name, values = table.one_of(PRESSURES)
        wrong = (values < low) | (values > high)
        at = f"{values[int(np.argmax(wrong))] / 1e5:.6g} bar"
        table.refuse(wrong, name, at, right)
        return values
    if pressure is None:
        raise InputError("is missing", where=where, right=f"{right}, or a column pressure_bar")
    if not low <= pressure <= high:
        raise InputError(f"{pressure / 1e5:.6g} bar", where=where, right=right)
    return pressure
