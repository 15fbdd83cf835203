"""Tables with other clocks than one stamp a row: a column of times for each signal, and stamps that rows share.

Scopes of controllers export a clock with each signal; other recorders write stamps that are coarser than their rows,
whole seconds above samples of 100 Hz, say.
"""

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from layflat.arrays import Array
from layflat.description.units import TIME
from layflat.identify.logs.table import FileContent, Header, LogColumn, parse_header, split_words
from layflat.identify.logs.vocabulary import kind_of_unit, word_roles

MIN_STAMP_CHANGES = 4  # changes of the stamp that the estimate of a period needs
MAX_STAMP_DEVIATION = 0.2  # from evenly spaced rows, in steps of the stamps
MIN_REPEATED_FRACTION = 0.95  # of rows that share a stamp: they repeat the row before, or fill its gaps
MAX_OTHER_REPEATED_FRACTION = 0.9  # of all other rows: a log of slow signals repeats most of them


@dataclass(frozen=True)
class SharedStamps:
    """Statistics of the rows that have the stamp of the row before."""

    rows: int
    total: int  # rows in total
    step: float  # of the stamps
    period: float | None  # between rows, in the unit of the stamps; None where they are not evenly spaced
    deviation: float = 0.0  # greatest distance of a stamp from evenly spaced rows
    repeated: bool = False  # these rows repeat the row before, or hold what it leaves empty

    @property
    def fraction(self) -> float:
        """Fraction of the rows that share a stamp."""
        return self.rows / max(self.total, 1)


def find_shared_stamps(stamps: Array, columns: Iterable[Array] = ()) -> SharedStamps | None:
    """Return the statistics of rows that share a stamp; None where none do, or the clock goes back.

    Args:
        stamps: stamps of all rows, NaN where one has none.
        columns: values of the other columns, which tell rows that are written twice.
    """
    finite = stamps[np.isfinite(stamps)]
    steps = np.diff(finite)
    if not np.any(steps == 0.0) or np.any(steps < 0.0) or not np.any(steps > 0.0):
        return None
    period, deviation = _even_period(stamps)
    step = float(steps[steps > 0.0].min())
    others = list(columns)
    repeated = bool(others) and _are_repeated(stamps, others)
    return SharedStamps(int(np.sum(steps == 0.0)), finite.size, step, period, deviation, repeated)


def _are_repeated(stamps: Array, columns: Iterable[Array]) -> bool:
    """Return whether nearly all rows with the stamp of the row before repeat it, or fill its gaps."""
    same = np.diff(stamps) == 0.0
    agree, apart = np.ones(same.size, dtype=bool), np.ones(same.size, dtype=bool)
    for values in columns:
        both = np.isfinite(values[:-1]) & np.isfinite(values[1:])
        agree &= ~both | (values[:-1] == values[1:])
        apart &= ~both
    twice = agree[same].mean() >= MIN_REPEATED_FRACTION and (
        same.all() or agree[~same].mean() <= MAX_OTHER_REPEATED_FRACTION
    )
    return bool(twice or apart[same].mean() >= MIN_REPEATED_FRACTION)


def _even_period(stamps: Array) -> tuple[float | None, float]:
    """Return the period of evenly spaced rows, None where they are not, and the greatest deviation of their stamps.

    The first row with a new stamp comes within a period after it, so these rows lie on a line.
    """
    rows = 1 + np.flatnonzero(np.diff(stamps) > 0.0)
    if rows.size < MIN_STAMP_CHANGES or not np.isfinite(stamps).all():
        return None, 0.0
    line = np.polynomial.Polynomial.fit(rows, stamps[rows], 1)
    deviation = float(np.abs(line(rows) - stamps[rows]).max())
    slope = float(line.convert().coef[1])
    if deviation > MAX_STAMP_DEVIATION * float(np.diff(stamps[rows]).min()) + slope:
        return None, deviation
    span = float(stamps[rows[-1]] - stamps[rows[0]])
    return _round_period(slope, 2.0 * (slope + deviation / np.sqrt(rows.size)) / span), deviation


def _round_period(period: float, tolerance: float) -> float:
    """Return the period within a relative tolerance whose value, or whose reciprocal, has the fewest digits."""
    for digits in range(12):
        for value in (float(f"{period:.{digits}e}"), 1.0 / float(f"{1.0 / period:.{digits}e}")):
            if abs(value / period - 1.0) <= tolerance:
                return value
    return period


_CLOCK_STEMS = {"x", "xvalue", "xaxis"}  # names of clocks without a word for time
_SUFFIXES = (("x", "y"), ("time", "value"), ("zeit", "wert"), ("t", "value"), ("timestamp", "value"))
_SUFFIX = re.compile(r"^(?P<stem>.+?)[\s_.:/-]+(?P<end>[^\W\d_]+)$")

ClockPairs = dict[str, list[str]]  # columns by the name of their clock


def find_clock_pairs(columns: Mapping[str, LogColumn]) -> ClockPairs:
    """Return the columns of each clock where a table has several; nothing for a table with one clock.

    Clocks have one name, or one with a number, and stand before their columns: "Time, angle, Time, pressure"; or clock
    and column have the signal's name, as "angle_X, angle_Y".
    """
    names = [name for name, column in columns.items() if np.isfinite(column.values).any()]
    stems = {name: re.sub(r"\d+", "", columns[name].header.stem).strip(" _-.").lower() for name in names}
    clocks = [name for name in names if _sounds_like_clock(columns[name], stems[name])]
    alike = [name for name in clocks if stems[name] == stems[clocks[0]]]
    if len({columns[name].header.unit for name in alike}) > 1:
        return {}  # one clock in two units
    if len(alike) < 2 or len(alike) < len(clocks) or alike[0] != names[0]:
        return _pair_by_suffix(names, columns)
    pairs: ClockPairs = {}
    for name in names:
        if name in alike:
            pairs[name] = []
        else:
            next(reversed(pairs.values())).append(name)
    return pairs if all(pairs.values()) and _never_fall(pairs, columns) else {}


def assign_clocks(columns: Mapping[str, LogColumn], pairs: ClockPairs, starts: Mapping[str, float]) -> FileContent:
    """Return columns with the stamps of their clocks; where all clocks agree, the first one is the table's.

    Args:
        columns: columns of the table.
        pairs: columns by their clocks.
        starts: first stamps of clocks that are relative to them, s, by clock.
    """
    first, *others = pairs
    headers = {name: _bare_header(column.header, name in pairs, pairs) for name, column in columns.items()}
    columns = {name: replace(column, header=headers[name]) for name, column in columns.items()}
    origin = min((starts[name] for name in pairs if name in starts), default=0.0)
    stamps = {name: columns[name].values + (starts.get(name, origin) - origin) for name in pairs}
    if all(np.array_equal(stamps[name], stamps[first], equal_nan=True) for name in others):
        kept = {name: column for name, column in columns.items() if name not in others}
        return FileContent(kept, None, dict.fromkeys(others, f"has the same times as {first}"))
    result = {name: _with_stamps(columns[name], stamps[clock]) for clock, names in pairs.items() for name in names}
    note = f"{len(pairs)} clocks: each column goes by the times before it, as {pairs[first][0]} by {first}"
    return FileContent(result, headers[first], {}, (note,))


def _with_stamps(column: LogColumn, stamps: Array) -> LogColumn:
    """Return a column with its own stamps, without rows that have none."""
    finite = np.isfinite(stamps)
    return replace(column, values=column.values[finite], stamps=stamps[finite])


def _bare_header(header: Header, clock: bool, pairs: ClockPairs) -> Header:
    """Return a header without the suffix that tells a signal's clock from its values, such as "_X" and "_Y"."""
    match = _SUFFIX.match(header.stem)
    if match is None or not all(_SUFFIX.match(name) for name in pairs):
        return header
    ends = (match["end"].lower() == end[0 if clock else 1] for end in _SUFFIXES)
    if not any(ends):
        return header
    if clock:
        timed = kind_of_unit(header.unit) == TIME
        return Header(header.name, header.unit if timed else "", stem="time")
    bare = parse_header(match["stem"], header.unit)
    return replace(bare, name=header.name, gauge=header.gauge if bare.gauge is None else bare.gauge)


def _pair_by_suffix(names: list[str], columns: Mapping[str, LogColumn]) -> ClockPairs:
    """Return pairs of clock and column whose names differ only in their last word, "X" and "Y".

    There are none unless all columns are such pairs, two or more.
    """
    if len(names) < 4 or len(names) % 2:
        return {}
    pairs: ClockPairs = {}
    for clock, value in zip(names[::2], names[1::2], strict=True):
        ends = [_SUFFIX.match(columns[name].header.stem) for name in (clock, value)]
        if ends[0] is None or ends[1] is None or ends[0]["stem"] != ends[1]["stem"]:
            return {}
        if (ends[0]["end"].lower(), ends[1]["end"].lower()) not in _SUFFIXES:
            return {}
        pairs[clock] = [value]
    return pairs if _never_fall(pairs, columns) else {}


def _sounds_like_clock(column: LogColumn, stem: str) -> bool:
    """Return whether name and unit of a column are those of a clock."""
    words = split_words(column.header.stem)
    timed = kind_of_unit(column.header.unit) == TIME if column.header.unit else True
    plain = re.sub(r"[\W_]+", "", stem)
    return timed and (plain in _CLOCK_STEMS or word_roles([w for w in words if not w.isdigit()]) == {"clock"})


def _never_fall(pairs: ClockPairs, columns: Mapping[str, LogColumn]) -> bool:
    return all(_never_falls(columns[name].values) for name in pairs)


def _never_falls(values: Array) -> bool:
    """Return whether values rise somewhere and never fall."""
    steps = np.diff(values[np.isfinite(values)])
    return bool(steps.size and np.all(steps >= 0.0) and np.any(steps > 0.0))
