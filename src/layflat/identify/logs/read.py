"""From a log's file to a data set over an even clock, in SI, with the standard names."""

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from layflat.arrays import Array, Dataset
from layflat.description import units as u
from layflat.description.hints import did_you_mean
from layflat.errors import InputError
from layflat.identify.logs.clocks import unwrap_counter
from layflat.identify.logs.formats import read_table
from layflat.identify.logs.grid import Clock, Grid, Series, clock_of, gaps, grid_as_recorded, grid_over, resampled
from layflat.identify.logs.mapping import MappedColumn, Mapping, own_mapping, read_mapping
from layflat.identify.logs.table import Column, Table
from layflat.identify.logs.vocabulary import SIGNALS, channel_name, conversion

LISTED = 8  # names in a message
NAMED = 3  # things without columns that are named with their reason


def read_log(
    path: str | Path | Table,
    mapping: Mapping | str | Path | None = None,
    *,
    joints: Sequence[str] | None = None,
    cycle: float | str | None = None,
    as_recorded: bool = False,
) -> Dataset:
    """Read a bench log.

    Args:
        path: CSV, Parquet, NetCDF or MCAP; or what `read_table` made of it.
        mapping: what the columns are, or its file; not needed where their names are our own.
        joints: those of the machine, in its order. A log without joints is taken for that of the only one.
        cycle: period of the grid; default: the log's own.
        as_recorded: every sample at its own stamp in place of a grid, NaN where other signals have theirs.

    Returns:
        Dims `time` (s, from 0) and `joint` where there are joints; SI, absolute pressures. The attributes tell of the
        file (`log_name`, `log_sha256`), the grid (`log_period`, `log_start`), and, as JSON, of each column and clock.

    Raises:
        InputError: in one line, what is wrong with the file, the mapping or an option.
    """
    table = path if isinstance(path, Table) else read_table(path)
    file = str(table.path)
    where = str(mapping) if isinstance(mapping, (str, Path)) else file
    plan = read_mapping(mapping) if isinstance(mapping, (str, Path)) else mapping or own_mapping(table)
    if plan is None:
        names = list(table.columns)
        shown = ", ".join(names[:6]) + (", ..." if len(names) > 6 else "")
        right = "give a mapping file; `layflat log map` writes one to start from"
        raise InputError(f"its columns ({shown}) are not layflat's own signals", where=file, right=right)
    period = None if cycle is None else u.quantity(cycle, u.TIME, "cycle")
    if period is not None and period <= 0.0:
        raise InputError(f"{period:g} s is out of range", where="cycle", right='give a time such as "5 ms"')
    series = _series(table, plan, list(joints) if joints is not None else None, where)
    clocks = [one.clock for one in series]
    grid = grid_as_recorded(clocks, file) if as_recorded else grid_over(clocks, period, file)
    log = _dataset(table, series, grid)
    log.attrs["log_notes"] = json.dumps(_notes(table, plan, mapping is None))
    return log


def _notes(table: Table, plan: Mapping, by_name: bool) -> list[str]:
    """Return what there is to say of how a file was read, and of columns that are not."""
    notes = list(table.notes)
    clock = plan.time.column if plan.time is not None else None
    if clock is not None and clock in table.columns:
        notes += [f"{clock}: {note}" for note in table.columns[clock].notes]
        anew = unwrap_counter(table.columns[clock].values)[1]
        notes += [f"{clock}: a counter that starts anew at sample {anew[0]} is read as going on"] if anew else []
    if table.clock is not None and table.words:
        first = ", ".join(f"{name} ({why})" for name, why in list(table.words.items())[:NAMED])
        more = f" and {len(table.words) - NAMED} more" if len(table.words) > NAMED else ""
        notes.append(f"what makes no column is left out: {first}{more}")
    simulated = any(name.startswith("measured_angle") for name in table.columns)  # true values stay out of a fit
    if by_name and not simulated and table.clock is None:
        used = {column for entry in plan.column for column in entry.columns} | {clock}
        left = [name for name in (*table.columns, *table.words) if name not in used]
        told = ", ".join(left[:LISTED]) + (f" and {len(left) - LISTED} more" if len(left) > LISTED else "")
        notes += [f"without a mapping these columns are not read: {told}"] if left else []
    return notes


def _series(table: Table, plan: Mapping, joints: list[str] | None, where: str) -> list[Series]:
    """All mapped columns in SI over their clocks; columns with the same stamps share theirs."""
    seconds, common, carried = _clock(table, plan, where)
    clocks: dict[bytes, Clock] = {}
    series: list[Series] = []
    taken: dict[str, MappedColumn] = {}
    for entry in plan.column:
        missing = [name for name in entry.columns if name not in table.columns]
        if missing and entry.optional:
            continue
        if missing:
            raise _no_column(missing[0], table, where)
        other = taken.setdefault(entry.channel, entry)
        if other is not entry:
            what = f"{', '.join(other.columns)} and {', '.join(entry.columns)} are both {entry.channel}"
            raise InputError(what, where=where, right="both are in this log: keep one")
        joint = _joint(entry, plan, joints, where)
        for column in (table.columns[name] for name in entry.columns):
            stamps = common if column.stamps is None else column.stamps
            if carried is not None:
                stamps = _carried(table, column, carried, where)
            if column.stamps is not None and plan.time is not None and plan.time.period is not None:
                stamps = _evenly(column.stamps, plan.time.period, table)
            key = stamps.tobytes()
            if key not in clocks:
                clocks[key] = clock_of(stamps * seconds, str(table.path))
            series.append(_one(column, entry, joint, plan.ambient, clocks[key]))
    if not series:
        right = did_you_mean(plan.column[0].columns[0], table.columns)
        raise InputError(f"none of its columns is in {table.path.name}", where=where, right=right)
    return series


def _no_column(name: str, table: Table, where: str) -> InputError:
    if name in table.words:
        right = "write numbers, or dates and times of one kind"
        return InputError(f"column {name!r} of {table.path.name} {table.words[name]}", where=where, right=right)
    return InputError(f"no column {name!r} in {table.path.name}", where=where, right=did_you_mean(name, table.columns))


def _clock(table: Table, plan: Mapping, where: str) -> tuple[float, Array, str | None]:
    """Return the unit of the stamps, s, those of columns that have none of their own, and a clock in the messages."""
    time = plan.time
    if table.clock is not None:
        seconds = time.seconds if time is not None else u.TIME.convert(f"1 {table.clock.unit or 's'}")
        if time is not None and time.period is not None:
            return 1.0, np.empty(0), None
        if time is None or time.column in {None, table.clock.name}:
            return seconds, np.empty(0), None
        units = {u.TIME.convert(f"1 {c.header.unit}") for c in _clocks_in(table, str(time.column)) if c.header.unit}
        if not _clocks_in(table, str(time.column)):
            what, right = f"no clock {time.column!r} in {table.path.name}", f"its samples have {table.clock.name!r}"
            raise InputError(what, where=f"{where}: time.column", right=right)
        if units - {seconds}:
            raise InputError(f"{time.column!r} is in s", where=f"{where}: time.unit", right='give unit = "s"')
        return seconds, np.empty(0), time.column
    if time is not None and time.period is not None:
        samples = max((column.values.size for column in table.columns.values()), default=0)
        return 1.0, time.period * np.arange(samples, dtype=np.float64), None
    if time is None or time.column is None:
        right = 'give [time] with column = "t", unit = "s"; or period = "5 ms" for a log without a clock'
        raise InputError("does not say which column is the clock", where=where, right=right)
    if time.column not in table.columns:
        raise _no_column(time.column, table, f"{where}: time.column")
    return time.seconds, unwrap_counter(table.columns[time.column].values)[0], None


def _evenly(stamps: Array, period: float, table: Table) -> Array:
    """Return stamps, s, that are evenly spaced from the first one on, for a column with times of its own."""
    stated = table.clock.unit if table.clock is not None else ""
    first = stamps[np.isfinite(stamps)][:1].sum() * (u.TIME.convert(f"1 {stated}") if stated else 0.0)
    even: Array = first + period * np.arange(stamps.size, dtype=np.float64)
    return even


def _clocks_in(table: Table, name: str) -> list[Column]:
    """Return the columns that are a clock of this name: one of a topic, or that of each."""
    return [c for c in table.columns.values() if c.topic and c.header.name in {name, f"{c.topic}.{name}"}]


def _carried(table: Table, column: Column, clock: str, where: str) -> Array:
    """Return the stamps of a column by a clock in its messages."""
    stamps = table.stamps_of(column, clock)
    if stamps is None:
        what = f"the messages of {column.header.name!r} carry no {clock!r}"
        right = f"leave that column out, or go by {table.clock.name!r}, which all have" if table.clock else ""
        if any(clock.startswith(f"{other.topic}.") for other in table.columns.values()):
            right = 'name the field alone, as "header.stamp", where each topic goes by its own; else ' + right
        raise InputError(what, where=f"{where}: time.column", right=right)
    return stamps


def _joint(entry: MappedColumn, plan: Mapping, joints: list[str] | None, where: str) -> str | None:
    """The joint that an entry belongs to, which may go without saying."""
    if not SIGNALS[entry.signal].by_joint:
        return None
    if entry.joint is None:
        known = joints or [other.joint for other in plan.column if other.joint is not None]
        if known and (joints is None or len(joints) > 1):
            what = f"{entry.signal} from {entry.columns[0]!r} does not say of which joint"
            raise InputError(what, where=where, right=f"say joint = {' or '.join(map(repr, dict.fromkeys(known)))}")
        return joints[0] if joints else None
    if joints is not None and entry.joint not in joints:
        right = f"its joints are {', '.join(joints)}"
        raise InputError(f"{entry.joint!r} is not a joint of the machine", where=where, right=right)
    return entry.joint


def _one(column: Column, entry: MappedColumn, joint: str | None, ambient: float, clock: Clock) -> Series:
    factor, shift = conversion(entry.unit, SIGNALS[entry.signal])
    raw = _last_known(np.where(np.isfinite(column.values), column.values, np.nan), clock)
    values = entry.sign * (raw - entry.offset) * entry.scale * factor + shift + (ambient if entry.gauge else 0.0)
    source: dict[str, object] = {"column": column.header.name, "unit": entry.unit, "sign": entry.sign}
    if column.notes:
        source["notes"] = list(column.notes)
    if entry.gauge is not None:
        source |= {"gauge": entry.gauge, "ambient": ambient}
    return Series(entry.signal, joint, clock, values, source)


def _last_known(values: Array, clock: Clock) -> Array:
    """Return the values of the rows that a clock keeps: of several with one stamp the last that has any."""
    last = np.maximum.accumulate(np.where(np.isfinite(values), np.arange(values.size), -1))[clock.rows]
    return np.where(last >= clock.firsts, values[np.maximum(last, 0)], np.nan)


def _dataset(table: Table, series: list[Series], grid: Grid) -> Dataset:
    import xarray  # noqa: PLC0415  # takes long to import

    channels: dict[str, list[Series]] = {}
    for one in series:
        channels.setdefault(one.channel, []).append(one)
    names = list(dict.fromkeys(one.joint for one in series if one.joint is not None))
    log = xarray.Dataset(coords={"time": ("time", grid.time, {"units": "s"})} | ({"joint": names} if names else {}))
    for signal in SIGNALS.values():
        about = {"units": signal.unit, "long_name": signal.meaning}
        mine = [one for one in series if one.signal == signal.name]
        if mine and mine[0].joint is not None:
            columns = [_mean(channels.get(channel_name(signal.name, joint), []), grid) for joint in names]
            log[signal.name] = (("time", "joint"), np.stack(columns, axis=1), about)
        elif mine:
            log[signal.name] = (("time",), _mean(mine, grid), about)
    log.attrs = {
        "log_name": table.path.name,
        "log_sha256": table.sha256,
        "log_period": grid.period,
        "log_start": grid.start,
        "log_columns": json.dumps({channel: _told(of, grid) for channel, of in channels.items()}),
        "log_clocks": json.dumps(_clocks(series, grid)),
    }
    return log


def _mean(series: list[Series], grid: Grid) -> Array:
    """Return the mean of columns that measure the same, on the grid; NaN where one has no value or there is none."""
    if not series:
        return np.full(grid.stamps.size, np.nan)
    mean: Array = np.mean([resampled(one, grid) for one in series], axis=0)
    if not grid.even and not SIGNALS[series[0].signal].held:
        known = np.concatenate([one.clock.time[np.isfinite(one.values)] for one in series])
        mean[~np.isin(grid.stamps, known)] = np.nan
    return mean


def _told(series: list[Series], grid: Grid) -> dict[str, Any]:
    """Return the attributes of a channel's columns: source, count of samples, and gaps of the grid, s."""
    first = series[0]
    open_gaps = [[since - grid.start, until - grid.start] for since, until in gaps(first)]
    return {
        **first.source,
        "column": ", ".join(str(one.source["column"]) for one in series),
        "samples": int(np.isfinite(first.values).sum()),
        "missing": int((~np.isfinite(first.values)).sum()),
        "gaps": len(open_gaps),
        "longest_gap": max(open_gaps, key=lambda gap: gap[1] - gap[0], default=None),
    }


def _clocks(series: list[Series], grid: Grid) -> list[dict[str, Any]]:
    """Return the attributes of each clock: the channels that go by it, and its faults."""
    kept = ("period", "jitter", "duplicates", "undated", "first_undated", "reset_at")
    return [
        {"channels": list(dict.fromkeys(one.channel for one in series if one.clock is clock))}
        | {key: getattr(clock, key) for key in kept}
        | {"reset": clock.reset and [stamp - grid.start for stamp in clock.reset]}
        | {"cut": clock.cut, "samples": clock.time.size}
        for clock in {id(one.clock): one.clock for one in series}.values()
    ]
