"""Clocks of tables beside their rows: a column of times for each signal, and stamps that rows share.

Scopes of controllers export a clock with each signal; other recorders write stamps that are coarser than their rows,
whole seconds above samples of 100 Hz, say.
"""

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from layflat.arrays import Array
from layflat.description.units import TIME
from layflat.identify.logs.headers import Header, header_of, words_of
from layflat.identify.logs.table import Column, Content
from layflat.identify.logs.units import kind_of_unit
from layflat.identify.logs.vocabulary import meanings

LEAST_CHANGES = 4  # of the stamp, from which a period is estimated
OFF_EVEN = 0.2  # steps of the stamps that these may lie beside evenly spaced rows
ALIKE = 0.95  # fraction of rows with the stamp of the row before that repeat it, or hold what it leaves empty
UNLIKE = 0.9  # fraction of all other rows that may repeat the row before: a log of slow signals repeats most


@dataclass(frozen=True)
class SharedStamps:
    """Rows that have the stamp of the row before."""

    rows: int
    of: int  # rows in all
    step: float  # of the stamps
    period: float | None  # between two rows, where they are evenly spaced, in the unit of the stamps; else None
    off: float = 0.0  # greatest distance of a stamp from evenly spaced rows
    repeated: bool = False  # these rows repeat the row before, or hold what it leaves empty

    @property
    def fraction(self) -> float:
        """Fraction of all rows."""
        return self.rows / max(self.of, 1)


def find_shared(stamps: Array, columns: Iterable[Array] = ()) -> SharedStamps | None:
    """Return what there is to say of rows that share a stamp; None where none do, or the clock goes back.

    Args:
        stamps: of all rows, NaN where one has none.
        columns: values of the other columns, which tell rows that are written twice.
    """
    known = stamps[np.isfinite(stamps)]
    steps = np.diff(known)
    if not np.any(steps == 0.0) or np.any(steps < 0.0) or not np.any(steps > 0.0):
        return None
    period, off = _even_period(stamps)
    step = float(steps[steps > 0.0].min())
    others = list(columns)
    repeated = bool(others) and _are_repeated(stamps, others)
    return SharedStamps(int(np.sum(steps == 0.0)), known.size, step, period, off, repeated)


def _are_repeated(stamps: Array, columns: Iterable[Array]) -> bool:
    """Return whether rows with the stamp of the row before repeat it, or hold what it leaves empty."""
    same = np.diff(stamps) == 0.0
    agree, apart = np.ones(same.size, dtype=bool), np.ones(same.size, dtype=bool)
    for values in columns:
        both = np.isfinite(values[:-1]) & np.isfinite(values[1:])
        agree &= ~both | (values[:-1] == values[1:])
        apart &= ~both
    twice = agree[same].mean() >= ALIKE and (same.all() or agree[~same].mean() <= UNLIKE)
    return bool(twice or apart[same].mean() >= ALIKE)


def _even_period(stamps: Array) -> tuple[float | None, float]:
    """Return the time between two rows that makes their stamps, and how far these lie beside it at most.

    The first row with a new stamp comes within a period after it, so these rows lie on a line.
    """
    rows = 1 + np.flatnonzero(np.diff(stamps) > 0.0)
    if rows.size < LEAST_CHANGES or not np.isfinite(stamps).all():
        return None, 0.0
    line = np.polynomial.Polynomial.fit(rows, stamps[rows], 1)
    off = float(np.abs(line(rows) - stamps[rows]).max())
    slope = float(line.convert().coef[1])
    if off > OFF_EVEN * float(np.diff(stamps[rows]).min()) + slope:
        return None, off
    span = float(stamps[rows[-1]] - stamps[rows[0]])
    return _round_period(slope, 2.0 * (slope + off / np.sqrt(rows.size)) / span), off


def _round_period(period: float, tolerance: float) -> float:
    """Return the period, or rate, with the fewest digits within a relative tolerance."""
    for digits in range(12):
        for value in (float(f"{period:.{digits}e}"), 1.0 / float(f"{1.0 / period:.{digits}e}")):
            if abs(value / period - 1.0) <= tolerance:
                return value
    return period


_CLOCK_STEMS = {"x", "xvalue", "xaxis"}  # names of a column of times that say nothing of time
_SUFFIXES = (("x", "y"), ("time", "value"), ("zeit", "wert"), ("t", "value"), ("timestamp", "value"))
_SUFFIX = re.compile(r"^(?P<stem>.+?)[\s_.:/-]+(?P<end>[^\W\d_]+)$")

Pairs = dict[str, list[str]]  # columns by the clock that they go by


def find_pairs(columns: Mapping[str, Column]) -> Pairs:
    """Return the columns that go by each clock, where there are several; nothing for a table with one clock.

    Clocks have one name, or one with a number, and stand before the columns that go by them: "Time, angle, Time,
    pressure"; or both have the signal's name, as "angle_X, angle_Y".
    """
    names = [name for name, column in columns.items() if np.isfinite(column.values).any()]
    stems = {name: re.sub(r"\d+", "", columns[name].header.stem).strip(" _-.").lower() for name in names}
    clocks = [name for name in names if _sounds_like_clock(columns[name], stems[name])]
    alike = [name for name in clocks if stems[name] == stems[clocks[0]]]
    if len({columns[name].header.unit for name in alike}) > 1:
        return {}  # one clock in two units
    if len(alike) < 2 or len(alike) < len(clocks) or alike[0] != names[0]:
        return _by_suffix(names, columns)
    pairs: Pairs = {}
    for name in names:
        if name in alike:
            pairs[name] = []
        else:
            next(reversed(pairs.values())).append(name)
    return pairs if all(pairs.values()) and _all_rise(pairs, columns) else {}


def with_own_clocks(columns: Mapping[str, Column], pairs: Pairs, starts: Mapping[str, float]) -> Content:
    """Return columns with the stamps of their clocks; where all clocks are the same, the first one is the table's.

    Args:
        columns: of the table.
        pairs: columns by their clocks.
        starts: first stamps of clocks that count from these, s.
    """
    first, *others = pairs
    headers = {name: _bare_header(column.header, name in pairs, pairs) for name, column in columns.items()}
    columns = {name: replace(column, header=headers[name]) for name, column in columns.items()}
    origin = min((starts[name] for name in pairs if name in starts), default=0.0)
    stamps = {name: columns[name].values + (starts.get(name, origin) - origin) for name in pairs}
    if all(np.array_equal(stamps[name], stamps[first], equal_nan=True) for name in others):
        kept = {name: column for name, column in columns.items() if name not in others}
        return Content(kept, None, dict.fromkeys(others, f"has the same times as {first}"))
    result = {name: _over(columns[name], stamps[clock]) for clock, names in pairs.items() for name in names}
    what = f"{len(pairs)} clocks: each column goes by the times before it, as {pairs[first][0]} by {first}"
    return Content(result, headers[first], {}, (what,))


def _over(column: Column, stamps: Array) -> Column:
    known = np.isfinite(stamps)
    return replace(column, values=column.values[known], stamps=stamps[known])


def _bare_header(header: Header, clock: bool, pairs: Pairs) -> Header:
    """Return a header without the word that tells a signal's times from its values, where pairs have such."""
    match = _SUFFIX.match(header.stem)
    if match is None or not all(_SUFFIX.match(name) for name in pairs):
        return header
    ends = (match["end"].lower() == end[0 if clock else 1] for end in _SUFFIXES)
    if not any(ends):
        return header
    if clock:
        timed = kind_of_unit(header.unit) == TIME
        return Header(header.name, header.unit if timed else "", stem="time")
    bare = header_of(match["stem"], header.unit)
    return replace(bare, name=header.name, gauge=header.gauge if bare.gauge is None else bare.gauge)


def _by_suffix(names: list[str], columns: Mapping[str, Column]) -> Pairs:
    """Return the pairs of columns whose names differ in their last word alone, "X" and "Y"."""
    if len(names) < 4 or len(names) % 2:
        return {}
    pairs: Pairs = {}
    for clock, value in zip(names[::2], names[1::2], strict=True):
        ends = [_SUFFIX.match(columns[name].header.stem) for name in (clock, value)]
        if ends[0] is None or ends[1] is None or ends[0]["stem"] != ends[1]["stem"]:
            return {}
        if (ends[0]["end"].lower(), ends[1]["end"].lower()) not in _SUFFIXES:
            return {}
        pairs[clock] = [value]
    return pairs if _all_rise(pairs, columns) else {}


def _sounds_like_clock(column: Column, stem: str) -> bool:
    words = words_of(column.header.stem)
    timed = kind_of_unit(column.header.unit) == TIME if column.header.unit else True
    plain = re.sub(r"[\W_]+", "", stem)
    return timed and (plain in _CLOCK_STEMS or meanings([w for w in words if not w.isdigit()]) == {"clock"})


def _all_rise(pairs: Pairs, columns: Mapping[str, Column]) -> bool:
    return all(_rises(columns[name].values) for name in pairs)


def _rises(values: Array) -> bool:
    steps = np.diff(values[np.isfinite(values)])
    return bool(steps.size and np.all(steps >= 0.0) and np.any(steps > 0.0))
