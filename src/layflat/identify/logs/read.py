"""Data set of a log's file: SI, over an even clock, with the standard names of signals."""

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from layflat.arrays import Array, Dataset
from layflat.description import units as u
from layflat.description.wrong import did_you_mean
from layflat.errors import InputError
from layflat.identify.logs.clocks import unwrap_counter
from layflat.identify.logs.formats import read_table
from layflat.identify.logs.grid import (
    SampleClock,
    SignalSeries,
    TimeGrid,
    build_clock,
    build_grid,
    build_recorded_grid,
    find_gaps,
    resample,
)
from layflat.identify.logs.mapping import LogMapping, MappedColumn, map_own_names, read_mapping
from layflat.identify.logs.table import LogColumn, LogTable
from layflat.identify.logs.vocabulary import SIGNALS, channel_name, unit_conversion

MAX_LISTED_COLUMNS = 8  # columns named in a note
MAX_LISTED_REASONS = 3  # items without column that are named with the reason


def read_log(
    path: str | Path | LogTable,
    mapping: LogMapping | str | Path | None = None,
    *,
    joints: Sequence[str] | None = None,
    cycle: float | str | None = None,
    as_recorded: bool = False,
) -> Dataset:
    """Read a bench log as a data set.

    Args:
        path: CSV, Parquet, NetCDF or MCAP file; or the table of `read_table`.
        mapping: mapping of the columns, or its file; not needed where they have layflat's own names.
        joints: joints of the machine, in its order. A log without joints is assigned to the only one.
        cycle: period of the grid, s or text with unit; default: the log's own.
        as_recorded: every sample at its own stamp in place of a grid, NaN where other signals have theirs.

    Returns:
        Dims `time` (s, from 0) and `joint` where there are joints; SI, absolute pressures. The attributes describe
        the file (`log_name`, `log_sha256`), the grid (`log_period`, `log_start`) and, as JSON, each column and clock.

    Raises:
        InputError: the file, the mapping or an argument is wrong.

    Example:
        >>> import layflat as lf
        >>> run = lf.rollout("paper-small-joint", "10 deg", duration="0.5 s")
        >>> log = lf.read_log(lf.save(run, "log.nc"))
        >>> log["measured_pressure"].units
        'Pa'
    """
    table = path if isinstance(path, LogTable) else read_table(path)
    file = str(table.path)
    where = str(mapping) if isinstance(mapping, (str, Path)) else file
    plan = read_mapping(mapping) if isinstance(mapping, (str, Path)) else mapping or map_own_names(table)
    if plan is None:
        names = list(table.columns)
        listed = ", ".join(names[:6]) + (", ..." if len(names) > 6 else "")
        right = "give a mapping file; `layflat log map` writes one to start from"
        raise InputError(f"its columns ({listed}) are not layflat's own signals", where=file, right=right)
    period = None if cycle is None else u.quantity(cycle, u.TIME, "cycle")
    if period is not None and period <= 0.0:
        raise InputError(f"{period:g} s is out of range", where="cycle", right='give a time such as "5 ms"')
    series = _build_series(table, plan, list(joints) if joints is not None else None, where)
    clocks = [signal.clock for signal in series]
    grid = build_recorded_grid(clocks, file) if as_recorded else build_grid(clocks, period, file)
    log = _build_dataset(table, series, grid)
    log.attrs["log_notes"] = json.dumps(_reading_notes(table, plan, mapping is None))
    return log


def _reading_notes(table: LogTable, mapping: LogMapping, by_name: bool) -> list[str]:
    """Return notes on how a file was read, and on columns left out; `by_name`: whether no mapping was passed."""
    notes = list(table.notes)
    clock = mapping.time.column if mapping.time is not None else None
    if clock is not None and clock in table.columns:
        notes += [f"{clock}: {note}" for note in table.columns[clock].notes]
        wrapped = unwrap_counter(table.columns[clock].values)[1]
        notes += [f"{clock}: a counter that starts anew at sample {wrapped[0]} is read as going on"] if wrapped else []
    if table.clock is not None and table.words:
        first = ", ".join(f"{name} ({why})" for name, why in list(table.words.items())[:MAX_LISTED_REASONS])
        more = f" and {len(table.words) - MAX_LISTED_REASONS} more" if len(table.words) > MAX_LISTED_REASONS else ""
        notes.append(f"left out, as they make no column: {first}{more}")
    simulated = any(name.startswith("measured_angle") for name in table.columns)  # true values stay out of a fit
    if by_name and not simulated and table.clock is None:
        used = {column for entry in mapping.column for column in entry.columns} | {clock}
        unread = [name for name in (*table.columns, *table.words) if name not in used]
        listed = ", ".join(unread[:MAX_LISTED_COLUMNS])
        more = f" and {len(unread) - MAX_LISTED_COLUMNS} more" if len(unread) > MAX_LISTED_COLUMNS else ""
        notes += [f"without a mapping these columns are not read: {listed}{more}"] if unread else []
    return notes


def _build_series(table: LogTable, mapping: LogMapping, joints: list[str] | None, where: str) -> list[SignalSeries]:
    """Return all mapped columns in SI over their clocks; columns with the same stamps share a clock.

    Args:
        table: columns of the file.
        mapping: mapping of the columns; optional ones may be missing.
        joints: names of the machine's joints; None where no machine is known: then any name is accepted.
        where: name of the mapping in messages.

    Raises:
        InputError: the file lacks a column that is not optional, or all columns; or two entries are one channel.
    """
    seconds, shared_stamps, message_clock = _select_clock(table, mapping, where)
    clocks: dict[bytes, SampleClock] = {}
    series: list[SignalSeries] = []
    entry_by_channel: dict[str, MappedColumn] = {}
    for entry in mapping.column:
        missing = [name for name in entry.columns if name not in table.columns]
        if missing and entry.optional:
            continue
        if missing:
            raise _missing_column_error(missing[0], table, where)
        first_entry = entry_by_channel.setdefault(entry.channel, entry)
        if first_entry is not entry:
            problem = f"{', '.join(first_entry.columns)} and {', '.join(entry.columns)} are both {entry.channel}"
            raise InputError(problem, where=where, right="both are in this log: keep one")
        joint = _joint_of_entry(entry, mapping, joints, where)
        for column in (table.columns[name] for name in entry.columns):
            stamps = shared_stamps if column.stamps is None else column.stamps
            if message_clock is not None:
                stamps = _message_stamps(table, column, message_clock, where)
            if column.stamps is not None and mapping.time is not None and mapping.time.period is not None:
                stamps = _even_stamps(column.stamps, mapping.time.period, table)
            key = stamps.tobytes()
            if key not in clocks:
                clocks[key] = build_clock(stamps * seconds, str(table.path))
            series.append(_convert_column(column, entry, joint, mapping.ambient, clocks[key]))
    if not series:
        right = did_you_mean(mapping.column[0].columns[0], table.columns)
        raise InputError(f"none of its columns is in {table.path.name}", where=where, right=right)
    return series


def _missing_column_error(name: str, table: LogTable, where: str) -> InputError:
    """Return the error for a mapped column that the file lacks."""
    if name in table.words:
        right = "write numbers, or dates and times of one kind"
        return InputError(f"column {name!r} of {table.path.name} {table.words[name]}", where=where, right=right)
    return InputError(f"no column {name!r} in {table.path.name}", where=where, right=did_you_mean(name, table.columns))


def _select_clock(table: LogTable, mapping: LogMapping, where: str) -> tuple[float, Array, str | None]:
    """Return the unit of the stamps, s, the stamps shared by all columns, and the name of a clock in the messages.

    Stamps are empty where each column has its own; the name is None unless the mapping selects such a clock.

    Raises:
        InputError: the mapping names no clock, one that the file lacks, or one in messages with another unit than s.
    """
    time = mapping.time
    if table.clock is not None:
        seconds = time.seconds if time is not None else u.TIME.convert(f"1 {table.clock.unit or 's'}")
        if time is not None and time.period is not None:
            return 1.0, np.empty(0), None
        if time is None or time.column in {None, table.clock.name}:
            return seconds, np.empty(0), None
        units = {u.TIME.convert(f"1 {c.header.unit}") for c in _clocks_in(table, str(time.column)) if c.header.unit}
        if not _clocks_in(table, str(time.column)):
            problem = f"no clock {time.column!r} in {table.path.name}"
            right = f"use {table.clock.name!r}, which all samples have"
            raise InputError(problem, where=f"{where}: time.column", right=right)
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
        raise _missing_column_error(time.column, table, f"{where}: time.column")
    return time.seconds, unwrap_counter(table.columns[time.column].values)[0], None


def _even_stamps(stamps: Array, period: float, table: LogTable) -> Array:
    """Return as many stamps as a column has, s, `period` (s) apart.

    They begin at the column's first finite stamp, in the unit of the table's clock; at 0 if it states none.
    """
    stated = table.clock.unit if table.clock is not None else ""
    first = stamps[np.isfinite(stamps)][:1].sum() * (u.TIME.convert(f"1 {stated}") if stated else 0.0)
    even: Array = first + period * np.arange(stamps.size, dtype=np.float64)
    return even


def _clocks_in(table: LogTable, name: str) -> list[LogColumn]:
    """Return the columns of messages that are the clock of this name, of one topic or of each."""
    return [c for c in table.columns.values() if c.topic and c.header.name in {name, f"{c.topic}.{name}"}]


def _message_stamps(table: LogTable, column: LogColumn, clock: str, where: str) -> Array:
    """Return the stamps of a column from a clock in its messages; raise InputError where they have none."""
    stamps = table.stamps_of(column, clock)
    if stamps is None:
        problem = f"the messages of {column.header.name!r} carry no {clock!r}"
        right = f"leave that column out, or go by {table.clock.name!r}, which all have" if table.clock else ""
        if any(clock.startswith(f"{other.topic}.") for other in table.columns.values()):
            right = 'name the field alone, as "header.stamp", where each topic goes by its own; else ' + right
        raise InputError(problem, where=f"{where}: time.column", right=right)
    return stamps


def _joint_of_entry(entry: MappedColumn, mapping: LogMapping, joints: list[str] | None, where: str) -> str | None:
    """Return the joint of an entry, which a log of one joint need not name; None for signals without joint.

    Args:
        entry: entry of the mapping.
        mapping: mapping, whose other entries may name the joints.
        joints: names of the machine's joints; None where no machine is known: then any name is accepted.
        where: name of the mapping in messages.

    Raises:
        InputError: the entry leaves open which of several joints it is of, or names one that the machine lacks.
    """
    if not SIGNALS[entry.signal].by_joint:
        return None
    if entry.joint is None:
        candidates = joints or [other.joint for other in mapping.column if other.joint is not None]
        if candidates and (joints is None or len(joints) > 1):
            problem = f"{entry.signal} from {entry.columns[0]!r} does not say of which joint"
            raise InputError(
                problem, where=where, right=f"say joint = {' or '.join(map(repr, dict.fromkeys(candidates)))}"
            )
        return joints[0] if joints else None
    if joints is not None and entry.joint not in joints:
        right = f"its joints are {', '.join(joints)}"
        raise InputError(f"{entry.joint!r} is not a joint of the machine", where=where, right=right)
    return entry.joint


def _convert_column(
    column: LogColumn, entry: MappedColumn, joint: str | None, ambient: float, clock: SampleClock
) -> SignalSeries:
    """Return a column as a signal in SI over its clock: sign * (value - offset) * scale, read in the entry's unit.

    Of several values with one stamp the last finite one counts; NaN stands for none.

    Args:
        column: column as it is in the file.
        entry: entry of the mapping that names the column.
        joint: joint of the signal; None for a signal without joint.
        ambient: ambient pressure, which is added to a gauge pressure, Pa.
        clock: clock of the signal.
    """
    factor, shift = unit_conversion(entry.unit, SIGNALS[entry.signal])
    raw = _last_valid(np.where(np.isfinite(column.values), column.values, np.nan), clock)
    values = entry.sign * (raw - entry.offset) * entry.scale * factor + shift + (ambient if entry.gauge else 0.0)
    source: dict[str, object] = {"column": column.header.name, "unit": entry.unit, "sign": entry.sign}
    if column.notes:
        source["notes"] = list(column.notes)
    if entry.gauge is not None:
        source |= {"gauge": entry.gauge, "ambient": ambient}
    return SignalSeries(entry.signal, joint, clock, values, source)


def _last_valid(values: Array, clock: SampleClock) -> Array:
    """Return the values at the rows that a clock keeps: of several with one stamp the last finite one, NaN for none."""
    last = np.maximum.accumulate(np.where(np.isfinite(values), np.arange(values.size), -1))[clock.rows]
    return np.where(last >= clock.firsts, values[np.maximum(last, 0)], np.nan)


def _build_dataset(table: LogTable, series: list[SignalSeries], grid: TimeGrid) -> Dataset:
    """Return the data set of all signals on the grid, with attributes."""
    import xarray  # noqa: PLC0415  # takes long to import

    channels: dict[str, list[SignalSeries]] = {}
    for item in series:
        channels.setdefault(item.channel, []).append(item)
    names = list(dict.fromkeys(item.joint for item in series if item.joint is not None))
    log = xarray.Dataset(coords={"time": ("time", grid.time, {"units": "s"})} | ({"joint": names} if names else {}))
    for signal in SIGNALS.values():
        attributes = {"units": signal.unit, "long_name": signal.meaning}
        columns_of_signal = [item for item in series if item.signal == signal.name]
        if columns_of_signal and columns_of_signal[0].joint is not None:
            values = [_mean_on_grid(channels.get(channel_name(signal.name, joint), []), grid) for joint in names]
            log[signal.name] = (("time", "joint"), np.stack(values, axis=1), attributes)
        elif columns_of_signal:
            log[signal.name] = (("time",), _mean_on_grid(columns_of_signal, grid), attributes)
    log.attrs = {
        "log_name": table.path.name,
        "log_sha256": table.sha256,
        "log_period": grid.period,
        "log_start": grid.start,
        "log_columns": json.dumps(
            {channel: _channel_attributes(columns, grid) for channel, columns in channels.items()}
        ),
        "log_clocks": json.dumps(_clock_attributes(series, grid)),
    }
    return log


def _mean_on_grid(series: list[SignalSeries], grid: TimeGrid) -> Array:
    """Return the mean of columns of one channel on the grid; NaN where one has no value, and for no columns.

    On a grid of recorded stamps, a measured signal is NaN but at its own stamps.
    """
    if not series:
        return np.full(grid.stamps.size, np.nan)
    mean: Array = np.mean([resample(column, grid) for column in series], axis=0)
    if not grid.even and not SIGNALS[series[0].signal].held:
        stamps = np.concatenate([column.clock.time[np.isfinite(column.values)] for column in series])
        mean[~np.isin(grid.stamps, stamps)] = np.nan
    return mean


def _channel_attributes(series: list[SignalSeries], grid: TimeGrid) -> dict[str, Any]:
    """Return the attributes of a channel: those of its first column's source, and its samples and gaps.

    Keys besides the source's: column (all names), samples, missing, gaps (count), longest_gap (ends, s of the grid).
    """
    first = series[0]
    open_gaps = [[since - grid.start, until - grid.start] for since, until in find_gaps(first)]
    return {
        **first.source,
        "column": ", ".join(str(column.source["column"]) for column in series),
        "samples": int(np.isfinite(first.values).sum()),
        "missing": int((~np.isfinite(first.values)).sum()),
        "gaps": len(open_gaps),
        "longest_gap": max(open_gaps, key=lambda gap: gap[1] - gap[0], default=None),
    }


def _clock_attributes(series: list[SignalSeries], grid: TimeGrid) -> list[dict[str, Any]]:
    """Return the attributes of each clock: channels, samples, and fields of `SampleClock`, stamps in s of the grid."""
    fields = ("period", "jitter", "duplicates", "undated", "first_undated", "reset_at")
    return [
        {"channels": list(dict.fromkeys(item.channel for item in series if item.clock is clock))}
        | {key: getattr(clock, key) for key in fields}
        | {"reset": clock.reset and [stamp - grid.start for stamp in clock.reset]}
        | {"cut": clock.cut, "samples": clock.time.size}
        for clock in {id(item.clock): item.clock for item in series}.values()
    ]
