"""Demands over time in a CSV file: a column "time [s]", and one for every joint such as "demand.large [deg]"."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from layflat.description.text import check_regular
from layflat.errors import InputError
from layflat.files import whole_file
from layflat.machine import Machine

Array = NDArray[np.float64]


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
    """Demands at every control cycle, rad, (cycles, joints); each holds until the next.

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
    header = _header(machine)
    if not rows or [name.strip() for name in rows[0]] != header:
        raise InputError("has other columns", where=where, right=f"give {', '.join(map(repr, header))}")
    if len(rows) < 3:
        raise InputError(f"holds {len(rows) - 1} rows of numbers", where=where, right="give two or more")
    values = np.array([_numbers(row, len(header), f"{where}: line {line}") for line, row in enumerate(rows[1:], 2)])
    time = values[:, 0]
    if np.any(np.diff(time) <= 0.0) or time[0] != 0.0:
        raise InputError("does not grow from zero", where=f"{where}: {header[0]}", right="give times 0, 0.005, ...")
    at = cycle * np.arange(round(time[-1] / cycle) + 1)
    return np.asarray(np.radians(values[np.searchsorted(time, at + 1e-9, side="right") - 1, 1:]), dtype=np.float64)


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
