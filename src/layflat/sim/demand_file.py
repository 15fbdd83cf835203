"""Demands over time in a CSV file: a column "time [s]", and one for every joint such as "demand.large [deg]"."""

import csv
from pathlib import Path

import numpy as np

from layflat.arrays import Array
from layflat.description.text import check_regular
from layflat.errors import InputError
from layflat.files import whole_file
from layflat.machine import Machine


def write_demand(machine: Machine, time: Array, demand: Array, path: Path) -> Path:
    """Write demands (rad, (instants, joints)) of a machine's joints at times (s).

    Raises:
        OutputError: it can't be written there.
    """
    with whole_file(path) as temporary, temporary.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(_header(machine))
        writer.writerows(
            [f"{t:.6g}", *(f"{q:.6g}" for q in row)] for t, row in zip(time, np.degrees(demand), strict=True)
        )
    return path


def read_demand(machine: Machine, path: Path, cycle: float) -> Array:
    """Read demands at every control cycle, rad, (cycles, joints); each holds until the next.

    Joints that the file does not name are held at zero, the middle of their stroke.

    Raises:
        InputError: the file, its columns, or a value in it.
    """
    where = str(path)
    check_regular(path, where, "give a CSV file")
    try:
        with path.open(newline="", encoding="utf-8-sig") as file:
            rows = list(csv.reader(file))
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(f"can't be read ({error})", where=where, right="give a CSV file") from None
    known, header = _header(machine), [name.strip() for name in rows[0]] if rows else []
    if len(header) < 2 or header[0] != known[0] or len(set(header)) < len(header):
        raise InputError("has other columns", where=where, right=f"give {', '.join(map(repr, known))}")
    unknown = next((name for name in header if name not in known), None)
    if unknown is not None:
        right = f"give some of {', '.join(map(repr, known[1:]))}; `layflat excite` writes them for a machine"
        raise InputError(f"has a column {unknown!r} of no joint of {machine.name}", where=where, right=right)
    if len(rows) < 3:
        raise InputError(f"holds {len(rows) - 1} rows of numbers", where=where, right="give two or more")
    values = np.array([_numbers(row, len(header), f"{where}: line {line}") for line, row in enumerate(rows[1:], 2)])
    time = values[:, 0]
    if np.any(np.diff(time) <= 0.0) or time[0] != 0.0:
        raise InputError("does not grow from zero", where=f"{where}: {header[0]}", right="give times 0, 0.005, ...")
    at = cycle * np.arange(round(time[-1] / cycle) + 1)
    named = values[np.searchsorted(time, at + 1e-9, side="right") - 1]
    demand = np.zeros((len(at), len(machine.joints)))
    for column, name in enumerate(header[1:], 1):
        demand[:, known.index(name) - 1] = np.radians(named[:, column])
    return demand


def _numbers(row: list[str], count: int, where: str) -> list[float]:
    try:
        numbers = [float(text) for text in row]
    except ValueError:
        numbers = []
    if len(numbers) != count or not np.isfinite(numbers).all():
        raise InputError("is not a row of numbers", where=where, right=f"give {count} of them")
    return numbers


def _header(machine: Machine) -> list[str]:
    return ["time [s]", *(f"demand.{name} [deg]" for name in machine.joints)]
