"""Demands over time in a CSV file.

| column | one for |
|---|---|
| `time [s]` | the file; it begins with zero |
| `demand.NAME [deg]` | a joint; without it, the joint is held in the middle of its stroke |
| `demand_velocity.NAME [deg/s]` | a joint with angles, or none |
| `demand_acceleration.NAME [deg/s2]` | a joint with velocities, or none |
| `load.NAME [N m]`, `payload [kg]` ... | a disturbance that `layflat simulate` has an option for, in its units |

A disturbance holds until the next row, and so does an angle. With velocities, angles between rows are cubic polynomials
in time, with accelerations those of fifth degree: they pass through the rows with what these give.
"""

import csv
import re
from collections.abc import Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import BPoly

from layflat.arrays import Array
from layflat.description.text import check_regular
from layflat.errors import InputError
from layflat.files import whole_file
from layflat.machine import Machine
from layflat.motion.limits import abilities
from layflat.motion.path import CLOSE, half_strokes
from layflat.motion.rates import derived_rates, lasting_rate
from layflat.motion.scenario import SIGNALS

TIME = "time [s]"
ROUNDING = 1e-5  # relative, by which a velocity that was written with six digits may be over its limit
MAX_ROWS = 2_000_000  # of demands, one a control cycle: 2.8 h with one of 5 ms, which take half a minute to write
COLUMN = re.compile(r"([^.\[]*?)(?:\.([^\[]+?))?(?: \[(.*)\])?")  # name, joint and unit of a signal
SHARES = {"1": 1.0, "%": 0.01}
KINDS = ("demand.{} [deg]", "demand_velocity.{} [deg/s]", "demand_acceleration.{} [deg/s2]")


class Demand(NamedTuple):
    """Demands at every control cycle, (cycles, joints) each; rates are None where a file gives none."""

    angles: Array  # rad
    velocities: Array | None  # rad/s
    accelerations: Array | None  # rad/s2


class Disturbance(NamedTuple):
    """A column of a disturbance."""

    name: str  # of the signal
    joint: str | None  # None: all joints share it
    factor: float  # from its unit to SI


def write_demand(
    machine: Machine, time: Array, demand: Array, path: Path, *,
    velocity: Array | None = None, acceleration: Array | None = None,
) -> Path:  # fmt: skip
    """Write demands (rad, rad/s and rad/s2, (instants, joints) each) of a machine's joints at times (s).

    Raises:
        OutputError: it can't be written there.
    """
    given = [of for of in (demand, velocity, acceleration) if of is not None]
    header = [TIME, *(kind.format(name) for kind, _ in zip(KINDS, given, strict=False) for name in machine.joints)]
    with whole_file(path) as temporary, temporary.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(header)
        writer.writerows(
            [f"{t:.9g}", *(f"{value:.6g}" for value in row)]
            for t, row in zip(time, np.degrees(np.hstack(given)), strict=True)
        )
    return path


def check_row_count(count: int, cycle: float, where: str) -> None:
    """Refuse demands of more control cycles (s) than a file may have; InputError names `where` they are asked for."""
    if count > MAX_ROWS:
        what = f"{count * cycle:.4g} s are {count:.4g} control cycles of {1e3 * cycle:g} ms"
        raise InputError(what, where=where, right=f"give {MAX_ROWS * cycle:g} s or less")


def read_demand(machine: Machine, path: Path, cycle: float) -> Demand:
    """Read demands at every control cycle (s) from a file that tells of nothing else; see `read_acting`."""
    return read_acting(machine, path, cycle, disturbed=False)[0]


def read_acting(
    machine: Machine, path: Path, cycle: float, *, disturbed: bool = True
) -> tuple[Demand, dict[str, Array]]:
    """Read demands and disturbances at every control cycle.

    Rates of joints for which the file has none are derived from their angles if it has some for others.

    Args:
        machine: whose joints they are.
        path: the file.
        cycle: control cycle, s.
        disturbed: whether the file may have disturbances, which nobody can ask a rig for.

    Returns:
        Demands, and disturbances by the names of signals, (cycles, joints or 1) each, in SI units.

    Raises:
        InputError: the file, its columns, or a value in it: beyond a stroke, faster than the joint can be, or not
            plausible.
    """
    where = str(path)
    columns, lines = _columns(machine, path, disturbed=disturbed)
    time = columns.pop(TIME)
    if np.any(np.diff(time) <= 0.0) or time[0] != 0.0:
        raise InputError("does not grow from zero", where=f"{where}: {TIME}", right="give times 0, 0.005, ...")
    count = round(time[-1] / cycle) + 1
    check_row_count(count, cycle, f"{where}: {TIME}")
    at = cycle * np.arange(count)
    sampled = []
    for name in machine.joints:
        given = [columns.get(kind.format(name)) for kind in KINDS]
        joint = [None if of is None else np.radians(of) for of in given]
        _check(machine, name, time, joint, [f"{where}: line {line}" for line in lines])
        sampled.append(_sampled(time, joint, at, cycle))
        if joint[1] is not None:  # polynomials may go beyond what they pass through
            _check(machine, name, at, sampled[-1], [f"{where}: between its rows"] * len(at))
    angles, *rates = (np.stack(of, axis=1) for of in zip(*sampled, strict=True))
    there = [any(kind.format(name) in columns for name in machine.joints) for kind in KINDS[1:]]
    velocities, accelerations = (of if given else None for of, given in zip(rates, there, strict=True))
    return Demand(angles, velocities, accelerations), _disturbances(machine, columns, _held(time, at), where)


def _held(time: Array, at: Array) -> NDArray[np.int64]:
    """Return which row holds at each instant."""
    rows: NDArray[np.int64] = np.searchsorted(time, at + 1e-9, side="right") - 1
    return rows


def _disturbances(
    machine: Machine, columns: Mapping[str, Array], rows: NDArray[np.int64], where: str
) -> dict[str, Array]:
    """Return the disturbances of a file at the instants at which its `rows` hold."""
    found: dict[str, Array] = {}
    for header, values in columns.items():
        if (column := _disturbance(machine, header, where)) is None:
            continue
        row, joints = SIGNALS[column.name], list(machine.joints)
        usual = np.full((len(rows), len(joints) if row.by_joint else 1), row.usual_of(machine))
        checked = row.check(machine, column.factor * values, f"{where}: {header}")
        found.setdefault(column.name, usual)[:, joints.index(column.joint) if column.joint else 0] = checked[rows]
    return found


def _disturbance(machine: Machine, header: str, where: str) -> Disturbance | None:
    """Return what a column tells of a disturbance; None where it is another; raise InputError if its unit is wrong."""
    if (match := COLUMN.fullmatch(header)) is None:
        return None
    name, joint, unit = match.groups()
    row = SIGNALS.get(name)
    if row is None or not row.option or (joint not in machine.joints if row.by_joint else joint is not None):
        return None
    factor = None
    with suppress(ValueError, KeyError):
        factor = SHARES[unit or "1"] if row.quantity is None else row.quantity.convert(f"1 {unit}")
    if factor is None or factor <= 0.0:
        example = row.recorded[0]
        right = f"give '{header.partition(' [')[0]} [{example}]'"
        raise InputError(f"{unit!r} is no unit of it", where=f"{where}: {header}", right=right)
    return Disturbance(name, joint, factor)


def _columns(machine: Machine, path: Path, *, disturbed: bool) -> tuple[dict[str, Array], list[int]]:
    """Return the columns of a file by their names, and the line of each row; empty lines are none."""
    where = str(path)
    check_regular(path, where, "give a CSV file")
    try:
        with path.open(newline="", encoding="utf-8-sig") as file:
            reader = csv.reader(file)
            rows = [(reader.line_num, row) for row in reader if any(cell.strip() for cell in row)]
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(f"can't be read ({error})", where=where, right="give a CSV file") from None
    header = [name.strip() for name in rows[0][1]] if rows else []
    acting = [name for name in header if disturbed and _disturbance(machine, name, where) is not None]
    _check_header(machine, [name for name in header if name not in acting], where)
    if len(rows) < 3:
        count = "one row" if len(rows) > 1 else "no rows"
        raise InputError(f"holds {count} of numbers", where=where, right="give two or more")
    lines = [line for line, _ in rows[1:]]
    values = np.array([_numbers(row, len(header), f"{where}: line {line}") for line, row in rows[1:]])
    return dict(zip(header, values.T, strict=True)), lines


def _check_header(machine: Machine, header: Sequence[str], where: str) -> None:
    angles, velocities, _ = known = [[kind.format(name) for name in machine.joints] for kind in KINDS]
    if len(header) < 2 or header[0] != TIME or len(set(header)) < len(header):
        raise InputError("has other columns", where=where, right=f"give {', '.join(map(repr, [TIME, *angles]))}")
    unknown = next((name for name in header[1:] if not any(name in names for names in known)), None)
    if unknown is not None:
        right = f"give some of {', '.join(map(repr, angles))}; `layflat excite` writes them for a machine"
        raise InputError(f"has a column {unknown!r} of no joint of {machine.name}", where=where, right=right)
    for names, needed in ((known[1], angles), (known[2], velocities)):
        for name, base in zip(names, needed, strict=True):
            if name in header and base not in header:
                raise InputError(f"has a column {name!r} without {base!r}", where=where, right="give both")


def _numbers(row: list[str], count: int, where: str) -> list[float]:
    try:
        numbers = [float(text) for text in row]
    except ValueError:
        numbers = []
    if len(numbers) != count or not np.isfinite(numbers).all():
        raise InputError("is not a row of numbers", where=where, right=f"give {count} of them")
    return numbers


def _check(machine: Machine, name: str, time: Array, joint: Sequence[Array | None], where: Sequence[str]) -> None:
    """Refuse angles and velocities that a joint can't do, at times (s), naming where they stand."""
    angle, velocity, _ = joint
    number = list(machine.joints).index(name)
    checks = [(angle, half_strokes(machine)[number], 0.0, "deg", "stay within +-{:.6g} deg, its working stroke")]
    if velocity is not None:
        checks.append((velocity, abilities(machine).speed[number], ROUNDING, "deg/s", "it can do {:.6g} deg/s"))
    for values, most, rounding, unit, right in checks:
        if values is None:
            continue
        wrong = np.flatnonzero(np.abs(values) > most * (1.0 + rounding) + CLOSE)
        if len(wrong):
            k = wrong[0]
            what = f"asks joint {name!r} for {np.degrees(values[k]):.6g} {unit} at {time[k]:.6g} s"
            raise InputError(what, where=where[k], right=right.format(np.degrees(most)))


def _sampled(time: Array, joint: Sequence[Array | None], at: Array, cycle: float) -> tuple[Array, Array, Array]:
    """Return angle, velocity and acceleration of a joint at times from what the rows of a file give."""
    angle, velocity, acceleration = joint
    if angle is None or velocity is None:
        held = np.zeros(len(time)) if angle is None else angle
        q = held[_held(time, at)]
        v, a = derived_rates(q[:, None], cycle)
        return q, v[:, 0], a[:, 0]
    known = [angle, velocity] if acceleration is None else [angle, velocity, acceleration]
    curve, inside = BPoly.from_derivatives(time, np.stack(known, axis=1)), np.minimum(at, time[-1])
    v = curve(inside, 1)
    return curve(inside), v, lasting_rate(v[:, None], cycle)[:, 0] if acceleration is None else curve(inside, 2)
