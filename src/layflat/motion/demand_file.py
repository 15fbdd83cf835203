"""Demands over time in a CSV file.

| column | one for |
|---|---|
| `time [s]` | the file; it begins with zero |
| `demand.NAME [deg]` | a joint; without it, the joint is held in the middle of its stroke |
| `demand_velocity.NAME [deg/s]` | a joint with angles, or none |
| `demand_acceleration.NAME [deg/s2]` | a joint with velocities, or none |
| `load.NAME [N m]`, `payload [kg]` ... | a disturbance that `layflat simulate` has an option for, in its units |

A disturbance is held until the next row, and so is an angle. With velocities, angles between rows are cubic polynomials
in time, with accelerations polynomials of fifth degree: they match the angles and rates of both rows.
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
from layflat.motion.limits import joint_capabilities
from layflat.motion.path import SAME_POINT_DISTANCE, half_strokes
from layflat.motion.scenario import SIGNALS
from layflat.motion.trajectory import derived_rates, lasting_rate

TIME = "time [s]"
VELOCITY_ROUNDING = 1e-5  # relative excess over the limit of a velocity that was written with six digits
MAX_ROWS = 2_000_000  # of demands, one a control cycle: 2.8 h with one of 5 ms, which take half a minute to write
COLUMN_PATTERN = re.compile(r"([^.\[]*?)(?:\.([^\[]+?))?(?: \[(.*)\])?")  # name, joint and unit of a signal
FRACTION_UNITS = {"1": 1.0, "%": 0.01}
DEMAND_COLUMNS = ("demand.{} [deg]", "demand_velocity.{} [deg/s]", "demand_acceleration.{} [deg/s2]")


class DemandSeries(NamedTuple):
    """Demands at every control cycle, (cycles, joints) each; rates are None if the file has none."""

    angles: Array  # rad
    velocities: Array | None  # rad/s
    accelerations: Array | None  # rad/s2


class DisturbanceColumn(NamedTuple):
    """Column of a demand file that holds a disturbance."""

    name: str  # of the signal
    joint: str | None  # None: all joints share it
    factor: float  # from the column's unit to SI


def write_demand(
    machine: Machine, time: Array, demand: Array, path: Path, *,
    velocity: Array | None = None, acceleration: Array | None = None,
) -> Path:  # fmt: skip
    """Write a file of demands in one step, and return its path.

    Args:
        machine: machine whose joints the demands are for.
        time: instants, (instants,), s.
        demand: angles, (instants, joints), rad.
        path: path of the file.
        velocity: likewise, rad/s; default: no such columns.
        acceleration: likewise, rad/s2, with velocities only; default: no such columns.

    Raises:
        InputError: there are accelerations without velocities.
        OutputError: the file can't be written, or an existing one may not be replaced.
    """
    if acceleration is not None and velocity is None:
        raise InputError("is given without `velocity`", where="acceleration", right="give both")
    signals = [rows for rows in (demand, velocity, acceleration) if rows is not None]
    columns = DEMAND_COLUMNS[: len(signals)]
    header = [TIME, *(column.format(name) for column in columns for name in machine.joints)]
    with whole_file(path) as temporary, temporary.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(header)
        writer.writerows(
            [f"{t:.9g}", *(f"{value:.6g}" for value in row)]
            for t, row in zip(time, np.degrees(np.hstack(signals)), strict=True)
        )
    return path


def check_row_count(count: int, cycle: float, where: str) -> None:
    """Refuse demands of more control cycles than a file may have.

    Args:
        count: number of control cycles.
        cycle: control cycle, s.
        where: source of the demands, for messages.

    Raises:
        InputError: naming `where`: there are more than `MAX_ROWS`.
    """
    if count > MAX_ROWS:
        what = f"{count * cycle:.4g} s are {count:.4g} control cycles of {1e3 * cycle:g} ms"
        raise InputError(what, where=where, right=f"give {MAX_ROWS * cycle:g} s or less")


def read_demand(machine: Machine, path: Path, cycle: float) -> DemandSeries:
    """Read demands at every control cycle from a file without disturbances.

    Args:
        machine: machine whose joints the demands are for.
        path: path of the file.
        cycle: control cycle, s.

    Raises:
        InputError: as `read_acting`, or the file has a disturbance.
    """
    return read_acting(machine, path, cycle, disturbed=False)[0]


def read_acting(
    machine: Machine, path: Path, cycle: float, *, disturbed: bool = True
) -> tuple[DemandSeries, dict[str, Array]]:
    """Read demands and disturbances at every control cycle.

    Rates of joints for which the file has none are derived from their angles if it has some for others.

    Args:
        machine: machine whose joints the demands are for.
        path: path of the file.
        cycle: control cycle, s.
        disturbed: whether the file may have disturbances, which a rig can't produce.

    Returns:
        Demands, and disturbances by the names of signals, (cycles, joints or 1) each, in SI units.

    Raises:
        InputError: the file, its columns, or a value in it: beyond a stroke, faster than the joint can be, or not
            plausible.
    """
    where = str(path)
    columns, line_numbers = _read_columns(machine, path, disturbed=disturbed)
    time = columns.pop(TIME)
    if np.any(np.diff(time) <= 0.0) or time[0] != 0.0:
        raise InputError("does not grow from zero", where=f"{where}: {TIME}", right="give times 0, 0.005, ...")
    count = round(time[-1] / cycle) + 1
    check_row_count(count, cycle, f"{where}: {TIME}")
    instants = cycle * np.arange(count)
    samples = []
    for name in machine.joints:
        degrees = [columns.get(column.format(name)) for column in DEMAND_COLUMNS]
        joint = [None if values is None else np.radians(values) for values in degrees]
        _check_strokes_and_speeds(machine, name, time, joint, [f"{where}: line {line}" for line in line_numbers])
        samples.append(_sample_joint(time, joint, instants, cycle))
        if joint[1] is not None:  # polynomials may exceed the rows that they pass through
            between = [f"{where}: between its rows"] * count
            _check_strokes_and_speeds(machine, name, instants, samples[-1], between)
    angles, *rates = (np.stack(signal, axis=1) for signal in zip(*samples, strict=True))
    present = [any(column.format(name) in columns for name in machine.joints) for column in DEMAND_COLUMNS[1:]]
    velocities, accelerations = (rate if is_present else None for rate, is_present in zip(rates, present, strict=True))
    disturbances = _sample_disturbances(machine, columns, _rows_at(time, instants), where)
    return DemandSeries(angles, velocities, accelerations), disturbances


def _rows_at(time: Array, instants: Array) -> NDArray[np.int64]:
    """Return the index of the row that holds at each instant (s)."""
    rows: NDArray[np.int64] = np.searchsorted(time, instants + 1e-9, side="right") - 1
    return rows


def _sample_disturbances(
    machine: Machine, columns: Mapping[str, Array], rows: NDArray[np.int64], where: str
) -> dict[str, Array]:
    """Return the disturbances at the rows of a file with these indices, by signal, (rows, joints or 1), in SI units.

    A joint without a column has the signal's usual value.
    """
    disturbances: dict[str, Array] = {}
    for header, values in columns.items():
        if (column := _parse_disturbance(machine, header, where)) is None:
            continue
        row, joints = SIGNALS[column.name], list(machine.joints)
        usual = np.full((len(rows), len(joints) if row.by_joint else 1), row.usual_of(machine))
        checked = row.check(machine, column.factor * values, f"{where}: {header}")
        position = joints.index(column.joint) if column.joint else 0
        disturbances.setdefault(column.name, usual)[:, position] = checked[rows]
    return disturbances


def _parse_disturbance(machine: Machine, header: str, where: str) -> DisturbanceColumn | None:
    """Return the disturbance of a column header; None if it is another column; raise InputError for a wrong unit."""
    if (match := COLUMN_PATTERN.fullmatch(header)) is None:
        return None
    name, joint, unit = match.groups()
    row = SIGNALS.get(name)
    if row is None or not row.option or (joint not in machine.joints if row.by_joint else joint is not None):
        return None
    factor = None
    with suppress(ValueError, KeyError):
        factor = FRACTION_UNITS[unit or "1"] if row.quantity is None else row.quantity.convert(f"1 {unit}")
    if factor is None or factor <= 0.0:
        example = row.recorded[0]
        right = f"give '{header.partition(' [')[0]} [{example}]'"
        raise InputError(f"{unit!r} is no unit of it", where=f"{where}: {header}", right=right)
    return DisturbanceColumn(name, joint, factor)


def _read_columns(machine: Machine, path: Path, *, disturbed: bool) -> tuple[dict[str, Array], list[int]]:
    """Return the columns of a file by header, in its units, and the line number of each row; skip empty lines.

    Raises:
        InputError: the file or its header is wrong, or a row is not one of numbers.
    """
    where = str(path)
    check_regular(path, where, "give a CSV file")
    try:
        with path.open(newline="", encoding="utf-8-sig") as file:
            reader = csv.reader(file)
            rows = [(reader.line_num, row) for row in reader if any(cell.strip() for cell in row)]
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(f"can't be read ({error})", where=where, right="give a CSV file") from None
    header = [name.strip() for name in rows[0][1]] if rows else []
    disturbances = [name for name in header if disturbed and _parse_disturbance(machine, name, where) is not None]
    _check_header(machine, [name for name in header if name not in disturbances], where)
    if len(rows) < 3:
        count = "one row" if len(rows) > 1 else "no rows"
        raise InputError(f"holds {count} of numbers", where=where, right="give two or more")
    lines = [line for line, _ in rows[1:]]
    values = np.array([_parse_numbers(row, len(header), f"{where}: line {line}") for line, row in rows[1:]])
    return dict(zip(header, values.T, strict=True)), lines


def _check_header(machine: Machine, header: Sequence[str], where: str) -> None:
    """Raise InputError unless the columns are time and demands of the machine's joints, rates only beside angles."""
    angles, velocities, _ = demands = [[column.format(name) for name in machine.joints] for column in DEMAND_COLUMNS]
    if len(header) < 2 or header[0] != TIME or len(set(header)) < len(header):
        right = f"give {', '.join(map(repr, [TIME, *angles]))}"
        raise InputError("does not have the time first, then each demand once", where=where, right=right)
    unknown = next((name for name in header[1:] if not any(name in names for names in demands)), None)
    if unknown is not None:
        right = f"give some of {', '.join(map(repr, angles))}; `layflat excite` writes them for a machine"
        raise InputError(f"has a column {unknown!r} of no joint of {machine.name}", where=where, right=right)
    for names, needed in ((demands[1], angles), (demands[2], velocities)):
        for name, base in zip(names, needed, strict=True):
            if name in header and base not in header:
                raise InputError(f"has a column {name!r} without {base!r}", where=where, right="give both")


def _parse_numbers(row: list[str], count: int, where: str) -> list[float]:
    """Return the `count` finite numbers of a row; raise InputError if it has others."""
    try:
        numbers = [float(text) for text in row]
    except ValueError:
        numbers = []
    if len(numbers) != count or not np.isfinite(numbers).all():
        raise InputError("is not a row of numbers", where=where, right=f"give {count} of them")
    return numbers


def _check_strokes_and_speeds(
    machine: Machine, name: str, time: Array, joint: Sequence[Array | None], where: Sequence[str]
) -> None:
    """Raise InputError for the first angle (rad) beyond the stroke or velocity (rad/s) that a joint can't reach.

    `where` names the source of each sample.
    """
    angle, velocity, _ = joint
    number = list(machine.joints).index(name)
    checks = [(angle, half_strokes(machine)[number], 0.0, "deg", "stay within +-{:.6g} deg, its working stroke")]
    if velocity is not None:
        checks.append(
            (velocity, joint_capabilities(machine).speed[number], VELOCITY_ROUNDING, "deg/s", "it can do {:.6g} deg/s")
        )
    for values, limit, rounding, unit, right in checks:
        if values is None:
            continue
        wrong = np.flatnonzero(np.abs(values) > limit * (1.0 + rounding) + SAME_POINT_DISTANCE)
        if len(wrong):
            k = wrong[0]
            what = f"asks joint {name!r} for {np.degrees(values[k]):.6g} {unit} at {time[k]:.6g} s"
            raise InputError(what, where=where[k], right=right.format(np.degrees(limit)))


def _sample_joint(
    time: Array, joint: Sequence[Array | None], instants: Array, cycle: float
) -> tuple[Array, Array, Array]:
    """Return angle, velocity and acceleration of a joint at instants (s), from the rows at `time`.

    Angles without velocities are held until the next row; a joint without angles is at zero.
    """
    angle, velocity, acceleration = joint
    if angle is None or velocity is None:
        held = np.zeros(len(time)) if angle is None else angle
        q = held[_rows_at(time, instants)]
        v, a = derived_rates(q[:, None], cycle)
        return q, v[:, 0], a[:, 0]
    derivatives = [angle, velocity] if acceleration is None else [angle, velocity, acceleration]
    curve, inside = BPoly.from_derivatives(time, np.stack(derivatives, axis=1)), np.minimum(instants, time[-1])
    v = curve(inside, 1)
    return curve(inside), v, lasting_rate(v[:, None], cycle)[:, 0] if acceleration is None else curve(inside, 2)
