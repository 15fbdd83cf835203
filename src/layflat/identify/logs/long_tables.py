"""Tables in long format, as databases export them: each row is a sample, with its signal, time and value."""

import re
from collections import Counter
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from layflat.arrays import Array
from layflat.description.units import TIME
from layflat.identify.logs.table import Cells, FileContent, Header, LogColumn, parse_header, split_words
from layflat.identify.logs.text.cells import read_cells
from layflat.identify.logs.vocabulary import kind_of_unit, word_roles

_COLUMN_WORDS = {
    "signal": (
        "signal channel field variable series metric varname tag tagname signalname channelname variablename parameter "
        "sensor item nodeid node displayname kanal signalbezeichnung messstelle key point name measurement topic"
    ),
    "value": "value val varvalue wert messwert reading valeur valor realvalue",
    "unit": "unit units einheit uom engunit",
    "quality": "validity quality status statuscode qualitycode good valid",
    "time": (
        "time t timestamp sourcetimestamp ts datetime timems timestring zeit zeitstempel date datum temps hora "
        "servertimestamp"
    ),
}
COLUMN_NAMES = {role: names.split() for role, names in _COLUMN_WORDS.items()}
"""Names of the columns of such tables by content, in small letters, the likeliest first."""
MAX_SIGNALS = 500
MAX_CHANNEL_NUMBERS = 64  # different numbers in a column of channel numbers
MIN_SIGNAL_SAMPLES = 2  # samples that a signal must have
MAX_REPEATED_FRACTION = 0.1  # of samples with name and stamp of another, above which the name is not the whole key
MILLIONTHS_OF_A_DAY = 0.0864  # s, the unit of WinCC's Time_ms, in spite of its name
DAY_NUMBER_RANGE = (2e10, 8e10)  # dates from 1954 on, in this unit
TIME_UNIT_SIZES = (1.0, 1e-3, 1e-6, 1e-9, 86400.0, MILLIONTHS_OF_A_DAY)  # s
_NAME_SEPARATORS = re.compile(r"[\W_]+")


class LongTableRoles(NamedTuple):
    """Names of the columns of a table in long format, by content."""

    signal: str
    value: str
    times: tuple[str, ...]
    unit: str  # "" where there is none, as for quality
    quality: str
    keys: tuple[str, ...]  # other columns of words, which may distinguish signals of one name


def find_long_table(headers: Mapping[str, Header], cells: Mapping[str, Cells]) -> LongTableRoles | None:
    """Return the roles of the columns of a table in long format; None for any other table."""
    column_by_name = {_NAME_SEPARATORS.sub("", header.stem.lower()): name for name, header in headers.items()}
    signal, value, unit, quality = (
        next((column_by_name[name] for name in COLUMN_NAMES[role] if name in column_by_name), "")
        for role in ("signal", "value", "unit", "quality")
    )
    times = tuple(dict.fromkeys(column_by_name[name] for name in COLUMN_NAMES["time"] if name in column_by_name))
    if not (signal and value and times) or signal == value:
        return None
    names = _signal_names(cells[signal])
    distinct = len(set(names))
    numbered = isinstance(cells[signal], np.ndarray)
    if distinct > (MAX_CHANNEL_NUMBERS if numbered else MAX_SIGNALS) or 2 * distinct > len(names):
        return None
    used = {signal, value, unit, quality, *times}
    if any(
        _is_signal(headers[name])
        for name, column in cells.items()
        if isinstance(column, np.ndarray) and name not in used
    ):
        return None  # a table with a column for each signal
    keys = tuple(name for name in cells if name not in used and not isinstance(cells[name], np.ndarray))
    return LongTableRoles(signal, value, times, unit, quality, keys)


def _is_signal(header: Header) -> bool:
    """Return whether the name or the unit of a column is that of a signal."""
    return bool(header.unit and kind_of_unit(header.unit) != TIME) or bool(
        word_roles(split_words(header.stem)) - {"clock"}
    )


def pivot_signals(roles: LongTableRoles, headers: Mapping[str, Header], cells: Mapping[str, Cells]) -> FileContent:
    """Return a column for each signal of a table in long format, with its own stamps.

    Args:
        roles: roles of the columns.
        headers: headers of the columns, by name.
        cells: cells of the columns, by name.
    """
    clock, times, time_note = _read_times(roles, headers, cells, np.array(_signal_names(cells[roles.signal])))
    names, name_columns = _distinguish_signals(roles, cells, times)
    values, units_in_cells, notes = _read_values(cells[roles.value], names)
    values, invalid = _mask_invalid(roles, cells, values)
    stated = cells[roles.unit] if roles.unit else None
    columns: dict[str, LogColumn] = {}
    used = {roles.signal, roles.value, roles.unit, roles.quality, *roles.times, *roles.keys}
    words = dict.fromkeys((name for name in cells if name not in used), "stands beside the signals of a sample a row")
    for name in dict.fromkeys(names.tolist()):
        rows = np.flatnonzero((names == name) & np.isfinite(times))
        if rows.size < MIN_SIGNAL_SAMPLES:
            words[name] = f"has {rows.size} sample{'s' if rows.size != 1 else ''}"
            continue
        header = parse_header(name, units_in_cells.get(name, "") if stated is None else _stated_unit(stated, rows))
        count = int(invalid[rows].sum())
        quality_note = (
            f"{count} sample{'s are' if count > 1 else ' is'} missing, whose {roles.quality} is not that of most"
        )
        column_notes = (*notes.get(name, ()), *((quality_note,) if count else ()))
        columns[header.name] = LogColumn(values[rows], header, times[rows], column_notes)
    note = f"a sample a row: signals by {name_columns}, values of {roles.value}, times of {time_note}"
    return FileContent(columns, clock, words, (note,))


def _stated_unit(stated: Cells, rows: NDArray[np.intp]) -> str:
    """Return the unit of a signal: that of its first sample, at `rows[0]`."""
    return "" if isinstance(stated, np.ndarray) else str(stated[int(rows[0])])


def _signal_names(cells: Cells) -> list[str]:
    """Return the signal's name of each row; channel numbers become "channel 3"."""
    if isinstance(cells, np.ndarray):
        return [f"channel {number:g}" if np.isfinite(number) else "" for number in cells]
    return [cell.strip() for cell in cells]


def _distinguish_signals(
    roles: LongTableRoles, cells: Mapping[str, Cells], times: Array
) -> tuple[NDArray[np.str_], str]:
    """Return the signal's name of each row, and the columns it comes from.

    Where many samples of one name have the same stamp, the words of another column become part of the name.
    """
    names, name_columns = np.array(_signal_names(cells[roles.signal])), roles.signal
    for key in roles.keys:
        if _repeated_fraction(names, times) <= MAX_REPEATED_FRACTION:
            break
        with_key = np.array([f"{word} {name}".strip() for word, name in zip(cells[key], names, strict=True)])
        if _repeated_fraction(with_key, times) < 0.5 * _repeated_fraction(names, times):
            names, name_columns = with_key, f"{key} and {name_columns}"
    return names, name_columns


def _repeated_fraction(names: NDArray[np.str_], times: Array) -> float:
    """Return the fraction of samples that have name and stamp of another."""
    counted = Counter(zip(names.tolist(), times.tolist(), strict=True))
    return 1.0 - len(counted) / max(len(names), 1)


def _read_times(
    roles: LongTableRoles, headers: Mapping[str, Header], cells: Mapping[str, Cells], names: NDArray[np.str_]
) -> tuple[Header, Array, str]:
    """Return the clock's header, the times of all rows, and a note on their column: that with the fewest repeats."""
    read = {name: _read_time_column(name, headers[name], cells[name]) for name in roles.times}
    usable = {name: times for name, times in read.items() if np.isfinite(times[0]).any()}
    finest = min(usable or read, key=lambda name: round(_repeated_fraction(names, read[name][0]), 2))
    times, header = read[finest]
    stated = TIME.convert(f"1 {header.unit}") if kind_of_unit(header.unit) == TIME else 0.0
    for other, (stamps, stamped) in read.items():
        comparable = other != finest and stamped.unit == "s" and header.unit != "s"
        seconds = _time_unit_size(times, stamps) if comparable else 0.0
        if seconds and seconds != stated:
            since = seconds * (times - times[np.isfinite(times)][0])
            return Header(finest, "s", stem=finest), since, f"{finest} in units of {seconds:g} s, as {other} shows"
    finite = times[np.isfinite(times)]
    if (
        finite.size
        and finest.lower() == "time_ms"
        and DAY_NUMBER_RANGE[0] < finite.min() <= finite.max() < DAY_NUMBER_RANGE[1]
    ):
        since = MILLIONTHS_OF_A_DAY * (times - finite[0])
        return Header(finest, "s", stem=finest), since, f"{finest} in millionths of a day, as WinCC writes them"
    return header, times, finest


def _time_unit_size(times: Array, stamps: Array) -> float:
    """Return the unit, s, in which times advance as stamps in s do; 0 where none does."""
    both = np.isfinite(times) & np.isfinite(stamps)
    span, elapsed = (np.ptp(values[both]) if both.any() else 0.0 for values in (stamps, times))
    if span < 2.0 or elapsed <= 0.0:
        return 0.0
    ratio = span / elapsed
    unit = min(TIME_UNIT_SIZES, key=lambda unit: abs(np.log(ratio / unit)))
    return unit if abs(ratio / unit - 1.0) < 1.5 / span + 0.01 else 0.0


def _read_time_column(name: str, header: Header, cells: Cells) -> tuple[Array, Header]:
    """Return the numbers of a column of times, and its header with the unit of its cells."""
    if isinstance(cells, np.ndarray):
        return cells, header
    read = read_cells(cells, None, "log")
    times = np.full(len(cells), np.nan) if read.values is None else read.values
    return times, parse_header(name, read.unit) if read.unit else header


def _mask_invalid(roles: LongTableRoles, cells: Mapping[str, Cells], values: Array) -> tuple[Array, NDArray[np.bool_]]:
    """Return values with NaN for samples whose quality is not the most frequent one, and their mask.

    Values stay as they are without a column of quality, or where no quality is that of half of the samples.
    """
    all_valid = np.zeros(values.size, dtype=bool)
    if not roles.quality:
        return values, all_valid
    qualities = cells[roles.quality]
    texts = [f"{cell:g}" for cell in qualities] if isinstance(qualities, np.ndarray) else [c.strip() for c in qualities]
    counted = Counter(text for text in texts if text and text != "nan")
    if not counted or len(counted) == 1:
        return values, all_valid
    most_frequent, count = counted.most_common(1)[0]
    if 2 * count < len(texts):
        return values, all_valid
    invalid = np.array([text != most_frequent for text in texts])
    return np.where(invalid, np.nan, values), invalid


def _read_values(cells: Cells, names: NDArray[np.str_]) -> tuple[Array, dict[str, str], dict[str, list[str]]]:
    """Return the numbers of all rows, and by signal the unit in its cells and notes."""
    if isinstance(cells, np.ndarray):
        return cells, {}, {}
    values, units, notes = np.full(len(cells), np.nan), dict[str, str](), dict[str, list[str]]()
    for name in dict.fromkeys(names.tolist()):
        rows = np.flatnonzero(names == name)
        read = read_cells([cells[int(i)] for i in rows], None, name)
        notes[name] = read.notes
        if read.values is not None:
            values[rows], units[name] = read.values, read.unit
    return values, units, notes
