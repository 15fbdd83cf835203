"""Clocks of a log: those in two columns, counters that start anew, and which column is the clock."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from layflat.arrays import Array
from layflat.description.units import TIME
from layflat.errors import InputError
from layflat.identify.logs.headers import Header, words_of
from layflat.identify.logs.paired_clocks import find_shared
from layflat.identify.logs.table import Column, Table
from layflat.identify.logs.units import kind_of_unit, unit_written
from layflat.identify.logs.vocabulary import meanings

_PARTS = (
    ("sec", "nanosec", 1e-9),
    ("secs", "nsecs", 1e-9),
    ("sec", "nsec", 1e-9),
    ("sec", "usec", 1e-6),
    ("seconds", "nanoseconds", 1e-9),
)
_MILLISECONDS = {"millitm", "ms", "msec", "millis", "millisecond", "milliseconds", "milli"}
STEPS = ((0.7, "s"), (700.0, "ms"), (7e5, "us"), (np.inf, "ns"))  # units of a clock, by its greatest usual step
EPOCHS = ((5e8, 5e9, "s"), (5e11, 5e12, "ms"), (5e14, 5e15, "us"), (5e17, 5e18, "ns"))  # of dates from 1986 on, by unit
DAY_NUMBERS = ((2e4, 8e4), (7e5, 8e5))  # of dates in spreadsheets and in MATLAB
MAX_DAY_STEP = 0.1  # days between two samples; more is no log of a motion
DAY = 86400.0  # s
FIRST_OF_DAY, DAY_STEP = 1e-3, 2e-6  # least fraction of a day, and its greatest step, that tell it from seconds
COUNTERS = (2.0**16, 2.0**24, 2.0**32, DAY, 1e3 * DAY, 1e6 * DAY)  # at which whole numbers of a clock start anew
TURNS = (65.536, 16777.216, 4294.967296, 4294967.296, DAY, 1e3 * DAY)  # the same of numbers with fractions
TICKS = frozenset(["tick", "ticks", "counter", "count", "counts", "cycles", "cnt"])
_TIMES = re.compile(r"[x*×·]?\s*(?P<number>\d+(?:[.,]\d+)?)\s*[x*×·]?\s*(?P<unit>[^\d\s/]+)")
FEW_SHARED = 0.05  # fraction of rows with the stamp of the row before that may be left out
MAX_FALLS = 0.01  # fraction of steps back of what is still a clock
RIGHT = 'give the log a column of times; or say period = "5 ms" (--period) if its samples are evenly spaced'


@dataclass(frozen=True)
class ClockChoice:
    """A column taken for the clock, its unit, and why."""

    column: str
    unit: str
    why: str
    scores: Mapping[str, tuple[float, str]]  # of each column that may be the clock
    period: float | None = None  # s between rows that are evenly spaced, as many share a stamp


def join_stamps(columns: dict[str, Column]) -> dict[str, Column]:
    """Return the columns, and one in s for each pair of seconds and their fraction, as "t.sec" and "t.nanosec"."""
    joined = {}
    for name, column in columns.items():
        for whole, rest, size in _PARTS:
            stem = name.removesuffix(whole)
            partner = columns.get(stem + rest)
            if stem != name and partner is not None and column.values.size == partner.values.size:
                since = column.values - column.values[np.isfinite(column.values)][:1].sum()
                base = stem.rstrip("._/") or "stamp"
                note = f"{name} and {stem + rest} together, as seconds since the first second"
                joined[base] = replace(
                    column, values=since + size * partner.values, header=Header(base, "s", stem=base), notes=(note,)
                )
                break
    coarse = [n for n, c in columns.items() if c.header.unit == "s" and c.stamps is None and _is_coarse(c.values)]
    fine = [n for n, c in columns.items() if _MILLISECONDS & set(words_of(n)) and _is_fraction(c.values)]
    if coarse and len(fine) == 1:
        name = f"{coarse[-1]} + {fine[0]}"
        note = f"{coarse[-1]} in s and {fine[0]} in ms together"
        values = columns[coarse[-1]].values + 1e-3 * columns[fine[0]].values
        joined[name] = Column(values, Header(name, "s", stem=name), notes=(note,))
    return columns | {name: column for name, column in joined.items() if name not in columns}


def _is_coarse(values: Array) -> bool:
    known = values[np.isfinite(values)]
    return bool(known.size > 2 and np.all(known % 1.0 == 0.0) and np.mean(np.diff(known) == 0.0) > 0.5)


def _is_fraction(values: Array) -> bool:
    known = values[np.isfinite(values)]
    return bool(known.size and known.min() >= 0.0 and known.max() < 1000.0 and np.all(known % 1.0 == 0.0))


def unwrap_counter(stamps: Array) -> tuple[Array, list[int]]:
    """Return the stamps of a counter, of 16, 24 or 32 bits or of a day, as they would go on, and where it starts anew.

    A counter with a sign goes from half of its size to the negative half.
    """
    known = np.flatnonzero(np.isfinite(stamps))
    values = stamps[known]
    steps = np.diff(values)
    back = np.flatnonzero(steps < 0.0)
    if not back.size:
        return stamps, []
    usual = float(np.median(steps[steps > 0.0])) if np.any(steps > 0.0) else 0.0
    for size in TURNS if np.any(values % 1.0 != 0.0) else COUNTERS:
        jumps = steps[back] + size
        inside = values.max() < (size if values.min() >= 0.0 else 0.5 * size) and values.min() >= -0.5 * size
        if inside and usual > 0.0 and np.all((jumps > 0.0) & (jumps < 20.0 * usual)):
            result = stamps.copy()
            result[known[1:]] += size * np.cumsum(steps < 0.0)
            return result, [int(known[i + 1]) + 1 for i in back]
    return stamps, []


def choose_clock(table: Table) -> ClockChoice:
    """Return the column that is the clock, by its unit and name; raise InputError where none can be.

    A column whose unit is not one of time, or whose name says something else, is never taken.
    """
    if table.clock is not None:
        return _own_times(table, table.clock)
    scores = {name: score for name, column in table.columns.items() if (score := _score(column)) is not None}
    named = {name: score for name, score in scores.items() if score[0] >= 1.0} or scores
    if not named:
        why, right = _why_not(table)
        raise InputError(f"no column rises as a clock does{why}", where=str(table.path), right=right)
    chosen = max(named, key=lambda name: named[name][0])
    if TICKS & set(words_of(table.columns[chosen].header.stem)) and not table.columns[chosen].header.unit:
        what = f"column {chosen!r} counts ticks, and nothing says how long one is"
        right = (
            'say period = "5 ms" (--period) if the samples are evenly spaced, or write a mapping with unit = "0.1 ms"'
        )
        raise InputError(what, where=str(table.path), right=right)
    unit, why = _unit(table.columns[chosen])
    said = "".join(f"; {note}" for note in table.columns[chosen].notes)
    others = [column.values for name, column in table.columns.items() if name not in scores]
    told, period = describe_stamps(table.columns[chosen].values, unit, others, f"{table.path}: {chosen}")
    return ClockChoice(chosen, unit, f"the clock {named[chosen][1]}; {why}{said}{told}", scores, period)


def _own_times(table: Table, clock: Header) -> ClockChoice:
    """Return the clock of a table whose columns have times of their own."""
    why = "every sample has a time of its own"
    timed = {name: one for name, one in table.columns.items() if one.stamps is not None}
    if clock.unit and (not timed or any(one.topic for one in timed.values())):
        return ClockChoice(clock.name, clock.unit, why, {})  # messages, of which several may come at once
    longest = max((one.stamps for one in timed.values() if one.stamps is not None), key=lambda stamps: stamps.size)
    unit, said = _unit(Column(longest, clock))
    told: dict[str, float | None] = {}
    for one in timed.values():
        if one.stamps is not None:
            note, period = describe_stamps(one.stamps, unit, [one.values], f"{table.path}: {one.header.name}")
            told.setdefault(note, period)
    periods = {period for period in told.values() if period is not None}
    if len(periods) > 1 or (periods and None in told.values()):
        raise InputError(f"samples share stamps of {clock.name!r}, and come at different rates", where=str(table.path),
                         right="export stamps with more digits")  # fmt: skip
    note = next((note for note, period in told.items() if period is not None), next(iter(told)))
    return ClockChoice(clock.name, unit, f"{why}; {said}{note}", {}, next(iter(periods), None))


def describe_stamps(values: Array, unit: str, others: Sequence[Array], where: str) -> tuple[str, float | None]:
    """Return a note on a clock that goes back or has stamps for several rows, and the period that such rows have.

    Args:
        values: of the clock, a row each.
        unit: of these.
        others: values of other columns, which tell rows that are written twice.
        where: file and column, for messages.

    Returns:
        The note, empty for a sound clock; and the time between two rows in s, None where each has its stamp.

    Raises:
        InputError: most rows share their stamp, and nothing tells how they lie between two.
    """
    values, anew = unwrap_counter(values)
    notes = [f"a counter that starts anew at sample {anew[0]}, read as going on"] if anew else []
    known = np.flatnonzero(np.isfinite(values))
    falls = np.flatnonzero(np.diff(values[known]) < 0.0)
    at = int(known[falls[0] + 1]) + 1 if falls.size else 0
    if falls.size == 1:
        longer = f"up to {at - 1}" if 2 * at > values.size else f"from {at} on"
        notes.append(f"set back at sample {at}, so that only the samples {longer} are used")
        if np.mean(np.diff(values[known]) == 0.0) > FEW_SHARED:
            what = f"many rows share their stamp, and the clock is set back at sample {at}"
            raise InputError(what, where=where, right="cut the log there, and map each part")
    elif falls.size:
        notes.append(f"goes back {falls.size} times, first at sample {at}, which no log may: cut it there")
    if known.size < values.size:
        notes.append(f"{values.size - known.size} rows without a time are left out")
    shared, period = find_shared(values, others), None
    if shared is not None and shared.repeated:
        notes.append(f"{shared.rows} rows have the stamp of the row before, and repeat it or fill its gaps")
    elif shared is not None and shared.fraction > FEW_SHARED:
        seconds = TIME.convert(unit if unit[:1].isdigit() else f"1 {unit}")
        told = f"only {shared.of - shared.rows} of {shared.of} rows have a stamp of their own, in steps of "
        told += f"{shared.step:.4g} {unit}"
        if shared.period is None:
            right = (
                'if the rows are evenly spaced, say by how much: period = "5 ms" (--period); else record finer stamps'
            )
            raise InputError(told, where=where, right=right)
        period = shared.period * seconds
        off = f", which the stamps fit within {shared.off:.2g} {unit}" if shared.off > shared.period else ""
        notes.append(f"{told}, so that they are taken for evenly spaced by {1e3 * period:.6g} ms{off}: check it")
    elif shared is not None:
        notes.append(f"{shared.rows} rows have the stamp of the row before: the last of each is used")
    return "".join(f"; {note}" for note in notes), period


def _score(column: Column) -> tuple[float, str] | None:
    """Return how much speaks for a clock, and what; None for a column that is none."""
    header, values = column.header, unwrap_counter(column.values)[0]
    words = words_of(header.stem)
    meant = meanings(words)
    timed = (bool(header.unit) and kind_of_unit(header.unit) == TIME) or bool(_scaled_unit(header))
    if (header.unit and not timed) or (header.unknown and not timed) or not rises(values):
        return None
    named = "clock" in meant and (timed or not meant & {"pressure", "angle", "torque", "force", "rate", "temperature"})
    coarse = 0.5 if np.median(np.diff(values[np.isfinite(values)])) <= 0.0 else 0.0
    arrival = 0.7 if "arrival" in words else 0.0
    falls = 1.0 if np.sum(np.diff(values[np.isfinite(values)]) < 0.0) > 1 else 0.0
    if named or timed:
        why = "by its name and unit" if named and timed else "by its name" if named else "by its unit"
        return 2.0 * timed + 2.0 * named - coarse - arrival - falls, why
    steps = np.diff(values[np.isfinite(values)])
    low, high = np.percentile(steps, (10.0, 90.0))
    if meant or not 0.0 < high <= 1.5 * low or _counts(values):
        return None
    return 0.5, "as its values rise evenly"


def _scaled_unit(header: Header) -> str:
    """Return the unit of a clock that is stated with a number, as "0.1 ms" in "t [0.1 ms]" and "t [x 10 us]"."""
    match = _TIMES.fullmatch(header.unknown)
    found = unit_written(match["unit"]) if match else None
    if match is None or found is None or kind_of_unit(found[0]) != TIME:
        return ""
    return f"{match['number'].replace(',', '.')} {found[0]}"


def _counts(values: Array) -> bool:
    """Return whether a column is the number of the sample."""
    known = values[np.isfinite(values)]
    return bool(known.size > 1 and np.all(known == np.arange(known.size) + known[0]))


def usual_step(values: Array) -> float:
    """Return the median of the steps forward of a column; 0 where there are none."""
    steps = np.diff(values[np.isfinite(values)])
    return float(np.median(steps[steps > 0.0])) if (steps > 0.0).any() else 0.0


def rises(values: Array) -> bool:
    """Return whether a column rises as a clock does: it may be set back once."""
    steps = np.diff(values[np.isfinite(values)])
    return bool(steps.size and np.any(steps > 0.0) and np.sum(steps < 0.0) <= max(1.0, MAX_FALLS * steps.size))


def _unit(column: Column) -> tuple[str, str]:
    """Return the unit of a clock, and why."""
    if stated := _scaled_unit(column.header) or column.header.unit:
        return stated, "unit as in the header" if not column.notes else "unit by its stamps"
    for word in words_of(column.header.stem):
        found = unit_written(word, listed=True) if len(word) > 1 else None
        if found is not None and kind_of_unit(found[0]) == TIME:
            return found[0], f"unit by the word {word!r}"
    known = column.values[np.isfinite(column.values)]
    first, last = float(known[0]), float(known[-1])
    step = usual_step(known)
    if last > first and np.median(np.diff(known)) <= 0.0:  # rows share stamps
        step = (last - first) / known.size
    for low, high, unit in EPOCHS:
        if low < first < high and low < last < high:
            return unit, f"unit by its values of {first:.4g}, which are dates in {unit}: check it"
    if any(low < first <= last < high for low, high in DAY_NUMBERS) and step < MAX_DAY_STEP:
        return "day", f"unit by its values of {first:.6g}, which are dates in days: check it"
    if FIRST_OF_DAY < first < 1.0 and FIRST_OF_DAY < last < 1.0 and step < DAY_STEP:
        return "day", f"unit by its values of {first:.6g} with steps of {step:.3g}, which are parts of a day: check it"
    unit = next(unit for most, unit in STEPS if step < most)
    return unit, f"unit by its steps of {step:.4g}: check it"


def _why_not(table: Table) -> tuple[str, str]:
    """Return the reason that keeps a column that sounds like a clock from being one, and what would do."""
    for name, why in table.words.items():
        if "clock" in meanings(words_of(name)):
            return f": column {name!r} {why}", RIGHT
    for name, column in table.columns.items():
        if "clock" in meanings(words_of(column.header.stem)):
            unit = column.header.unit or column.header.unknown
            falls = np.flatnonzero(np.diff(column.values[np.isfinite(column.values)]) < 0.0)
            if unit and kind_of_unit(unit) != TIME:
                why = f': the unit {unit!r} of column {name!r} is not one of time; a mapping may say unit = "0.1 ms"'
                return why, RIGHT
            if falls.size:
                why = f": column {name!r} falls {falls.size} times, first at sample {falls[0] + 2}"
                return why, f"order the rows by it if they are out of order, or {RIGHT}"
    counted = next((name for name, column in table.columns.items() if _counts(column.values)), None)
    return f": column {counted!r} counts samples" if counted is not None else "", RIGHT
