"""Tables in long format, as archives and databases export them: a sample a row, with its signal, time and value."""

import re
from collections import Counter
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from layflat.arrays import Array
from layflat.description.units import TIME
from layflat.identify.logs.headers import Header, header_of, words_of
from layflat.identify.logs.table import Cells, Column, Content
from layflat.identify.logs.text.cells import read_cells
from layflat.identify.logs.units import kind_of_unit
from layflat.identify.logs.vocabulary import meanings

_NAMES = {
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
COLUMN_NAMES = {role: names.split() for role, names in _NAMES.items()}
"""Names of the columns of such tables by what they hold, in small letters, the likeliest first."""
MAX_SIGNALS = 500
MAX_CODES = 64  # numbers of channels
LEAST_SAMPLES = 2  # of a signal
SAME_STAMPS = 0.1  # fraction of samples with the stamp of another above which the signal's name is not all of it
MILLIONTHS_OF_A_DAY = 0.0864  # s: WinCC's Time_ms, whatever its name says
DAY_NUMBERS = (2e10, 8e10)  # of dates from 1954 on, in this unit
RATIOS = (1.0, 1e-3, 1e-6, 1e-9, 86400.0, MILLIONTHS_OF_A_DAY)  # s, units that a second column of times may have
_LETTERS = re.compile(r"[\W_]+")


class Roles(NamedTuple):
    """Columns of a table in long format, by their names."""

    signal: str
    value: str
    times: tuple[str, ...]
    unit: str  # empty where there is none, as the next
    quality: str
    keys: tuple[str, ...]  # other columns of words, which may tell two signals of one name apart


def find_long(headers: Mapping[str, Header], cells: Mapping[str, Cells]) -> Roles | None:
    """Return which column is what in a table in long format; None for any other table."""
    plain = {_LETTERS.sub("", header.stem.lower()): name for name, header in headers.items()}
    signal, value, unit, quality = (
        next((plain[name] for name in COLUMN_NAMES[role] if name in plain), "")
        for role in ("signal", "value", "unit", "quality")
    )
    times = tuple(dict.fromkeys(plain[name] for name in COLUMN_NAMES["time"] if name in plain))
    if not (signal and value and times) or signal == value:
        return None
    names = _names(cells[signal])
    distinct = len(set(names))
    numbered = isinstance(cells[signal], np.ndarray)
    if distinct > (MAX_CODES if numbered else MAX_SIGNALS) or 2 * distinct > len(names):
        return None
    used = {signal, value, unit, quality, *times}
    if any(
        _is_signal(headers[name])
        for name, column in cells.items()
        if isinstance(column, np.ndarray) and name not in used
    ):
        return None  # a column a signal, and words beside them
    keys = tuple(name for name in cells if name not in used and not isinstance(cells[name], np.ndarray))
    return Roles(signal, value, times, unit, quality, keys)


def _is_signal(header: Header) -> bool:
    """Return whether the name or the unit of a column says that it is measured."""
    return bool(header.unit and kind_of_unit(header.unit) != TIME) or bool(meanings(words_of(header.stem)) - {"clock"})


def pivot(roles: Roles, headers: Mapping[str, Header], cells: Mapping[str, Cells]) -> Content:
    """Return a column for each signal, with times of its own.

    Args:
        roles: of the columns.
        headers: of the columns, by name.
        cells: of the columns, by name.
    """
    clock, times, told = _times(roles, headers, cells, np.array(_names(cells[roles.signal])))
    names, by = _told_apart(roles, cells, times)
    values, spelled, notes = _values(cells[roles.value], names)
    values, doubted = _valid(roles, cells, values)
    stated = cells[roles.unit] if roles.unit else None
    columns: dict[str, Column] = {}
    used = {roles.signal, roles.value, roles.unit, roles.quality, *roles.times, *roles.keys}
    words = dict.fromkeys((name for name in cells if name not in used), "stands beside the signals of a sample a row")
    for name in dict.fromkeys(names.tolist()):
        mine = np.flatnonzero((names == name) & np.isfinite(times))
        if mine.size < LEAST_SAMPLES:
            words[name] = f"has {mine.size} sample{'s' if mine.size != 1 else ''}"
            continue
        header = header_of(name, spelled.get(name, "") if stated is None else _unit_of(stated, mine))
        bad = int(doubted[mine].sum())
        flagged = f"{bad} sample{'s are' if bad > 1 else ' is'} missing, whose {roles.quality} is not that of most"
        said = (*notes.get(name, ()), *((flagged,) if bad else ()))
        columns[header.name] = Column(values[mine], header, times[mine], said)
    what = f"a sample a row: signals by {by}, values of {roles.value}, times of {told}"
    return Content(columns, clock, words, (what,))


def _unit_of(stated: Cells, rows: NDArray[np.intp]) -> str:
    """Return the unit of a signal: that of its first sample."""
    return "" if isinstance(stated, np.ndarray) else str(stated[int(rows[0])])


def _names(cells: Cells) -> list[str]:
    if isinstance(cells, np.ndarray):
        return [f"channel {number:g}" if np.isfinite(number) else "" for number in cells]
    return [cell.strip() for cell in cells]


def _told_apart(roles: Roles, cells: Mapping[str, Cells], times: Array) -> tuple[NDArray[np.str_], str]:
    """Return the signal of each row, and the columns that say it.

    Where many samples of one name have the same stamp, another column of words tells whose they are.
    """
    names, by = np.array(_names(cells[roles.signal])), roles.signal
    for key in roles.keys:
        if _repeated(names, times) <= SAME_STAMPS:
            break
        with_key = np.array([f"{word} {name}".strip() for word, name in zip(cells[key], names, strict=True)])
        if _repeated(with_key, times) < 0.5 * _repeated(names, times):
            names, by = with_key, f"{key} and {by}"
    return names, by


def _repeated(names: NDArray[np.str_], times: Array) -> float:
    """Return the fraction of samples with the name and the stamp of another."""
    counted = Counter(zip(names.tolist(), times.tolist(), strict=True))
    return 1.0 - len(counted) / max(len(names), 1)


def _times(
    roles: Roles, headers: Mapping[str, Header], cells: Mapping[str, Cells], names: NDArray[np.str_]
) -> tuple[Header, Array, str]:
    """Return the clock's header, the times of all rows, and the name of their column: the one with most steps."""
    read = {name: _column_of_times(name, headers[name], cells[name]) for name in roles.times}
    usable = {name: times for name, times in read.items() if np.isfinite(times[0]).any()}
    finest = min(usable or read, key=lambda name: round(_repeated(names, read[name][0]), 2))
    times, header = read[finest]
    stated = TIME.convert(f"1 {header.unit}") if kind_of_unit(header.unit) == TIME else 0.0
    for other, (stamps, stamped) in read.items():
        beside = other != finest and stamped.unit == "s" and header.unit != "s"
        seconds = _seconds_in(times, stamps) if beside else 0.0
        if seconds and seconds != stated:
            since = seconds * (times - times[np.isfinite(times)][0])
            return Header(finest, "s", stem=finest), since, f"{finest} in units of {seconds:g} s, as {other} shows"
    known = times[np.isfinite(times)]
    if known.size and finest.lower() == "time_ms" and DAY_NUMBERS[0] < known.min() <= known.max() < DAY_NUMBERS[1]:
        since = MILLIONTHS_OF_A_DAY * (times - known[0])
        return Header(finest, "s", stem=finest), since, f"{finest} in millionths of a day, as WinCC writes them"
    return header, times, finest


def _seconds_in(times: Array, stamps: Array) -> float:
    """Return the unit of times, s, that makes them run as some stamps in s do; 0 where none does."""
    both = np.isfinite(times) & np.isfinite(stamps)
    span, run = (np.ptp(values[both]) if both.any() else 0.0 for values in (stamps, times))
    if span < 2.0 or run <= 0.0:
        return 0.0
    ratio = span / run
    near = min(RATIOS, key=lambda unit: abs(np.log(ratio / unit)))
    return near if abs(ratio / near - 1.0) < 1.5 / span + 0.01 else 0.0


def _column_of_times(name: str, header: Header, cells: Cells) -> tuple[Array, Header]:
    """Return a column of times, with the unit that its cells say."""
    if isinstance(cells, np.ndarray):
        return cells, header
    read = read_cells(cells, None, "log")
    times = np.full(len(cells), np.nan) if read.values is None else read.values
    return times, header_of(name, read.unit) if read.unit else header


def _valid(roles: Roles, cells: Mapping[str, Cells], values: Array) -> tuple[Array, NDArray[np.bool_]]:
    """Return values, NaN where their quality is not that of most, and which these are."""
    none = np.zeros(values.size, dtype=bool)
    if not roles.quality:
        return values, none
    qualities = cells[roles.quality]
    texts = [f"{cell:g}" for cell in qualities] if isinstance(qualities, np.ndarray) else [c.strip() for c in qualities]
    counted = Counter(text for text in texts if text and text != "nan")
    if not counted or len(counted) == 1:
        return values, none
    usual, count = counted.most_common(1)[0]
    if 2 * count < len(texts):
        return values, none
    doubted = np.array([text != usual for text in texts])
    return np.where(doubted, np.nan, values), doubted


def _values(cells: Cells, names: NDArray[np.str_]) -> tuple[Array, dict[str, str], dict[str, list[str]]]:
    """Return the numbers of all rows, and by signal the unit that its cells say, and notes."""
    if isinstance(cells, np.ndarray):
        return cells, {}, {}
    values, units, notes = np.full(len(cells), np.nan), dict[str, str](), dict[str, list[str]]()
    for name in dict.fromkeys(names.tolist()):
        mine = np.flatnonzero(names == name)
        read = read_cells([cells[int(i)] for i in mine], None, name)
        notes[name] = read.notes
        if read.values is not None:
            values[mine], units[name] = read.values, read.unit
    return values, units, notes
