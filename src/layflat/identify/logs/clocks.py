"""Clocks of a log: choice of the clock's column, seconds with their fraction in another column, counters that wrap."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from layflat.arrays import Array
from layflat.description.units import TIME
from layflat.errors import InputError
from layflat.identify.logs.paired_clocks import find_shared_stamps
from layflat.identify.logs.table import Header, LogColumn, LogTable, split_words
from layflat.identify.logs.vocabulary import kind_of_unit, parse_unit, word_roles

_SPLIT_STAMPS = (
    ("sec", "nanosec", 1e-9),
    ("secs", "nsecs", 1e-9),
    ("sec", "nsec", 1e-9),
    ("sec", "usec", 1e-6),
    ("seconds", "nanoseconds", 1e-9),
)
_MILLISECOND_WORDS = {"millitm", "ms", "msec", "millis", "millisecond", "milliseconds", "milli"}
CLOCK_UNITS = ((0.7, "s"), (700.0, "ms"), (7e5, "us"), (np.inf, "ns"))  # upper limit of the step, by unit of a clock
EPOCH_RANGES = ((5e8, 5e9, "s"), (5e11, 5e12, "ms"), (5e14, 5e15, "us"), (5e17, 5e18, "ns"))
"""Lower and upper value of dates from 1986 on, by unit of seconds since 1970."""
DAY_NUMBER_RANGES = ((2e4, 8e4), (7e5, 8e5))  # days of dates in spreadsheets and in MATLAB
MAX_DAY_STEP = 0.1  # days between two samples; more is no log of a motion
SECONDS_PER_DAY = 86400.0  # s
MIN_DAY_FRACTION, MAX_DAY_FRACTION_STEP = 1e-3, 2e-6  # limits that distinguish fractions of a day from seconds
COUNTER_SIZES = (
    2.0**16,
    2.0**24,
    2.0**32,
    SECONDS_PER_DAY,
    1e3 * SECONDS_PER_DAY,
    1e6 * SECONDS_PER_DAY,
)  # at which a clock of integers wraps
FRACTIONAL_COUNTER_SIZES = (
    65.536,
    16777.216,
    4294.967296,
    4294967.296,
    SECONDS_PER_DAY,
    1e3 * SECONDS_PER_DAY,
)  # at which a clock with fractions wraps, s or ms
TICK_WORDS = frozenset(["tick", "ticks", "counter", "count", "counts", "cycles", "cnt"])
_NUMBERED_UNIT = re.compile(r"[x*×·]?\s*(?P<number>\d+(?:[.,]\d+)?)\s*[x*×·]?\s*(?P<unit>[^\d\s/]+)")
MAX_SHARED_FRACTION = 0.05  # fraction of rows with the stamp of the row before that may be left out
MAX_FALLING_FRACTION = 0.01  # fraction of steps back that a clock may have
CLOCK_ADVICE = 'give the log a column of times, or `period="5 ms"` if its samples are evenly spaced'


@dataclass(frozen=True)
class ClockChoice:
    """Column chosen as the clock, its unit, and the reason."""

    column: str
    unit: str
    why: str
    scores: Mapping[str, tuple[float, str]]  # of each column that may be the clock
    period: float | None = None  # s between rows that are evenly spaced, as many share a stamp


def join_stamps(columns: dict[str, LogColumn]) -> dict[str, LogColumn]:
    """Return the columns with joined stamps added, in s.

    A pair such as "t.sec" and "t.nanosec" becomes one column that counts from the first second. The last column of
    repeated whole seconds and the only one of milliseconds below 1000 become one as well. Existing names are kept.
    """
    joined = {}
    for name, column in columns.items():
        for whole, rest, size in _SPLIT_STAMPS:
            stem = name.removesuffix(whole)
            partner = columns.get(stem + rest)
            if stem != name and partner is not None and column.values.size == partner.values.size:
                seconds = column.values - column.values[np.isfinite(column.values)][:1].sum()
                base = stem.rstrip("._/") or "stamp"
                note = f"{name} and {stem + rest} together, as seconds since the first second"
                joined[base] = replace(
                    column, values=seconds + size * partner.values, header=Header(base, "s", stem=base), notes=(note,)
                )
                break
    coarse = [n for n, c in columns.items() if c.header.unit == "s" and c.stamps is None and _is_coarse(c.values)]
    fine = [n for n, c in columns.items() if _MILLISECOND_WORDS & set(split_words(n)) and _is_fraction(c.values)]
    if coarse and len(fine) == 1:
        name = f"{coarse[-1]} + {fine[0]}"
        note = f"{coarse[-1]} in s and {fine[0]} in ms together"
        values = columns[coarse[-1]].values + 1e-3 * columns[fine[0]].values
        joined[name] = LogColumn(values, Header(name, "s", stem=name), notes=(note,))
    return columns | {name: column for name, column in joined.items() if name not in columns}


def _is_coarse(values: Array) -> bool:
    """Return whether values are whole seconds, most of them repeated."""
    finite = values[np.isfinite(values)]
    return bool(finite.size > 2 and np.all(finite % 1.0 == 0.0) and np.mean(np.diff(finite) == 0.0) > 0.5)


def _is_fraction(values: Array) -> bool:
    """Return whether values are whole milliseconds within a second."""
    finite = values[np.isfinite(values)]
    return bool(finite.size and finite.min() >= 0.0 and finite.max() < 1000.0 and np.all(finite % 1.0 == 0.0))


def unwrap_counter(stamps: Array) -> tuple[Array, list[int]]:
    """Return the stamps of a counter without its wraps, and the sample numbers, from 1, that follow a wrap.

    Counters of 16, 24 and 32 bits and of a day are known. A signed one wraps from half of its size to minus that.
    Stamps that fall otherwise are returned as they are, with no numbers.
    """
    finite = np.flatnonzero(np.isfinite(stamps))
    values = stamps[finite]
    steps = np.diff(values)
    wraps = np.flatnonzero(steps < 0.0)
    if not wraps.size:
        return stamps, []
    typical_step = float(np.median(steps[steps > 0.0])) if np.any(steps > 0.0) else 0.0
    for size in FRACTIONAL_COUNTER_SIZES if np.any(values % 1.0 != 0.0) else COUNTER_SIZES:
        jumps = steps[wraps] + size
        inside = values.max() < (size if values.min() >= 0.0 else 0.5 * size) and values.min() >= -0.5 * size
        if inside and typical_step > 0.0 and np.all((jumps > 0.0) & (jumps < 20.0 * typical_step)):
            result = stamps.copy()
            result[finite[1:]] += size * np.cumsum(steps < 0.0)
            return result, [int(finite[i + 1]) + 1 for i in wraps]
    return stamps, []


def choose_clock(table: LogTable) -> ClockChoice:
    """Choose the column that is the clock, by its unit and name.

    A column whose unit is not one of time, or whose name says something else, is never chosen.

    Raises:
        InputError: no column can be the clock, it counts ticks of unknown length, or rows share its stamps and
            `describe_stamps` refuses them.
    """
    if table.clock is not None:
        return _choose_stamped_clock(table, table.clock)
    scores = {name: score for name, column in table.columns.items() if (score := _score_clock(column)) is not None}
    named = {name: score for name, score in scores.items() if score[0] >= 1.0} or scores
    if not named:
        why, right = _explain_no_clock(table)
        raise InputError(f"no column rises as a clock does{why}", where=str(table.path), right=right)
    chosen = max(named, key=lambda name: named[name][0])
    if TICK_WORDS & set(split_words(table.columns[chosen].header.stem)) and not table.columns[chosen].header.unit:
        problem = f"column {chosen!r} counts ticks, and nothing says how long one is"
        right = 'give `period="5 ms"` if the samples are evenly spaced, or write a mapping with unit = "0.1 ms"'
        raise InputError(problem, where=str(table.path), right=right)
    unit, why = _clock_unit(table.columns[chosen])
    column_notes = "".join(f"; {note}" for note in table.columns[chosen].notes)
    others = [column.values for name, column in table.columns.items() if name not in scores]
    fault_note, period = describe_stamps(table.columns[chosen].values, unit, others, f"{table.path}: {chosen}")
    return ClockChoice(chosen, unit, f"the clock {named[chosen][1]}; {why}{column_notes}{fault_note}", scores, period)


def _choose_stamped_clock(table: LogTable, clock: Header) -> ClockChoice:
    """Return the clock of a table in which each column has its own stamps: unit, and period (s) of shared stamps.

    Columns of messages (with a topic) keep the unit of `clock` and have no period. Raise InputError if columns share
    stamps at different rates.
    """
    reason = "every sample has a time of its own"
    timed = {name: column for name, column in table.columns.items() if column.stamps is not None}
    if clock.unit and (not timed or any(column.topic for column in timed.values())):
        return ClockChoice(clock.name, clock.unit, reason, {})  # messages, of which several may come at once
    longest = max(
        (column.stamps for column in timed.values() if column.stamps is not None), key=lambda stamps: stamps.size
    )
    unit, unit_reason = _clock_unit(LogColumn(longest, clock))
    periods_by_note: dict[str, float | None] = {}
    for column in timed.values():
        if column.stamps is not None:
            note, period = describe_stamps(column.stamps, unit, [column.values], f"{table.path}: {column.header.name}")
            periods_by_note.setdefault(note, period)
    periods = {period for period in periods_by_note.values() if period is not None}
    if len(periods) > 1 or (periods and None in periods_by_note.values()):
        raise InputError(f"samples share stamps of {clock.name!r}, and come at different rates", where=str(table.path),
                         right="export stamps with more digits")  # fmt: skip
    note = next((note for note, period in periods_by_note.items() if period is not None), next(iter(periods_by_note)))
    return ClockChoice(clock.name, unit, f"{reason}; {unit_reason}{note}", {}, next(iter(periods), None))


def describe_stamps(values: Array, unit: str, others: Sequence[Array], where: str) -> tuple[str, float | None]:
    """Describe the faults of a clock: steps back, missing stamps, and stamps that several rows share.

    Args:
        values: stamps, (rows,), in `unit`.
        unit: unit of the stamps.
        others: values of other columns, (rows,) each, which tell rows that are written twice.
        where: file and column, for messages.

    Returns:
        A note, empty for a valid clock; and the period of evenly spaced rows that share stamps, s, else None.

    Raises:
        InputError: many rows share their stamp, and either they are not evenly spaced or the clock is set back.
    """
    values, wrapped = unwrap_counter(values)
    notes = [f"a counter that starts anew at sample {wrapped[0]}, read as going on"] if wrapped else []
    finite = np.flatnonzero(np.isfinite(values))
    falls = np.flatnonzero(np.diff(values[finite]) < 0.0)
    reset_sample = int(finite[falls[0] + 1]) + 1 if falls.size else 0
    if falls.size == 1:
        used_part = f"up to {reset_sample - 1}" if 2 * reset_sample > values.size else f"from {reset_sample} on"
        notes.append(f"set back at sample {reset_sample}, so that only the samples {used_part} are used")
        if np.mean(np.diff(values[finite]) == 0.0) > MAX_SHARED_FRACTION:
            problem = f"many rows share their stamp, and the clock is set back at sample {reset_sample}"
            raise InputError(problem, where=where, right="cut the log there, and map each part")
    elif falls.size:
        notes.append(f"goes back {falls.size} times, first at sample {reset_sample}, which no log may: cut it there")
    if finite.size < values.size:
        notes.append(f"{values.size - finite.size} rows without a time are left out")
    shared, period = find_shared_stamps(values, others), None
    if shared is not None and shared.repeated:
        notes.append(f"{shared.rows} rows have the stamp of the row before, and repeat it or fill its gaps")
    elif shared is not None and shared.fraction > MAX_SHARED_FRACTION:
        seconds = TIME.convert(unit if unit[:1].isdigit() else f"1 {unit}")
        problem = f"only {shared.total - shared.rows} of {shared.total} rows have a stamp of their own, in steps of "
        problem += f"{shared.step:.4g} {unit}"
        if shared.period is None:
            right = 'if the rows are evenly spaced, say by how much: `period="5 ms"`; else record finer stamps'
            raise InputError(problem, where=where, right=right)
        period = shared.period * seconds
        deviation = (
            f", which the stamps fit within {shared.deviation:.2g} {unit}" if shared.deviation > shared.period else ""
        )
        notes.append(
            f"{problem}, so that they are taken for evenly spaced by {1e3 * period:.6g} ms{deviation}: check it"
        )
    elif shared is not None:
        notes.append(f"{shared.rows} rows have the stamp of the row before: the last of each is used")
    return "".join(f"; {note}" for note in notes), period


def _score_clock(column: LogColumn) -> tuple[float, str] | None:
    """Return the points of a column for being the clock, and the reason; None if it can't be one."""
    header, values = column.header, unwrap_counter(column.values)[0]
    words = split_words(header.stem)
    roles = word_roles(words)
    timed = (bool(header.unit) and kind_of_unit(header.unit) == TIME) or bool(_scaled_unit(header))
    if (header.unit and not timed) or (header.unknown and not timed) or not is_rising(values):
        return None
    named = "clock" in roles and (timed or not roles & {"pressure", "angle", "torque", "force", "rate", "temperature"})
    coarse = 0.5 if np.median(np.diff(values[np.isfinite(values)])) <= 0.0 else 0.0
    arrival = 0.7 if "arrival" in words else 0.0
    falls = 1.0 if np.sum(np.diff(values[np.isfinite(values)]) < 0.0) > 1 else 0.0
    if named or timed:
        why = "by its name and unit" if named and timed else "by its name" if named else "by its unit"
        return 2.0 * timed + 2.0 * named - coarse - arrival - falls, why
    steps = np.diff(values[np.isfinite(values)])
    low, high = np.percentile(steps, (10.0, 90.0))
    if roles or not 0.0 < high <= 1.5 * low or _is_sample_number(values):
        return None
    return 0.5, "as its values rise evenly"


def _scaled_unit(header: Header) -> str:
    """Return the unit of a clock with a number, such as "0.1 ms" of "t [0.1 ms]"; "" for other units."""
    match = _NUMBERED_UNIT.fullmatch(header.unknown)
    parsed = parse_unit(match["unit"]) if match else None
    if match is None or parsed is None or kind_of_unit(parsed[0]) != TIME:
        return ""
    return f"{match['number'].replace(',', '.')} {parsed[0]}"


def _is_sample_number(values: Array) -> bool:
    """Return whether a column numbers the samples."""
    finite = values[np.isfinite(values)]
    return bool(finite.size > 1 and np.all(finite == np.arange(finite.size) + finite[0]))


def median_step(values: Array) -> float:
    """Return the median of the positive steps of a column; 0 where there are none."""
    steps = np.diff(values[np.isfinite(values)])
    return float(np.median(steps[steps > 0.0])) if (steps > 0.0).any() else 0.0


def is_rising(values: Array) -> bool:
    """Return whether a column rises as a clock does: one step in a hundred, or a single one, may be negative."""
    steps = np.diff(values[np.isfinite(values)])
    return bool(
        steps.size and np.any(steps > 0.0) and np.sum(steps < 0.0) <= max(1.0, MAX_FALLING_FRACTION * steps.size)
    )


def _clock_unit(column: LogColumn) -> tuple[str, str]:
    """Return the unit of a clock, and the reason: its header, a word in its name, or its values."""
    if stated := _scaled_unit(column.header) or column.header.unit:
        return stated, "unit as in the header" if not column.notes else "unit by its stamps"
    for word in split_words(column.header.stem):
        parsed = parse_unit(word, listed=True) if len(word) > 1 else None
        if parsed is not None and kind_of_unit(parsed[0]) == TIME:
            return parsed[0], f"unit by the word {word!r}"
    finite = column.values[np.isfinite(column.values)]
    first, last = float(finite[0]), float(finite[-1])
    step = median_step(finite)
    if last > first and np.median(np.diff(finite)) <= 0.0:  # rows share stamps
        step = (last - first) / finite.size
    for low, high, unit in EPOCH_RANGES:
        if low < first < high and low < last < high:
            return unit, f"unit by its values of {first:.4g}, which are dates in {unit}: check it"
    if any(low < first <= last < high for low, high in DAY_NUMBER_RANGES) and step < MAX_DAY_STEP:
        return "day", f"unit by its values of {first:.6g}, which are dates in days: check it"
    if MIN_DAY_FRACTION < first < 1.0 and MIN_DAY_FRACTION < last < 1.0 and step < MAX_DAY_FRACTION_STEP:
        return "day", f"unit by its values of {first:.6g} with steps of {step:.3g}, which are parts of a day: check it"
    unit = next(unit for max_step, unit in CLOCK_UNITS if step < max_step)
    return unit, f"unit by its steps of {step:.4g}: check it"


def _explain_no_clock(table: LogTable) -> tuple[str, str]:
    """Return why a column that is named like a clock is none, "" if nothing tells, and the advice."""
    for name, why in table.words.items():
        if "clock" in word_roles(split_words(name)):
            return f": column {name!r} {why}", CLOCK_ADVICE
    for name, column in table.columns.items():
        if "clock" in word_roles(split_words(column.header.stem)):
            unit = column.header.unit or column.header.unknown
            falls = np.flatnonzero(np.diff(column.values[np.isfinite(column.values)]) < 0.0)
            if unit and kind_of_unit(unit) != TIME:
                why = f': the unit {unit!r} of column {name!r} is not one of time; a mapping may say unit = "0.1 ms"'
                return why, CLOCK_ADVICE
            if falls.size:
                why = f": column {name!r} falls {falls.size} times, first at sample {falls[0] + 2}"
                return why, f"order the rows by it if they are out of order, or {CLOCK_ADVICE}"
    counted = next((name for name, column in table.columns.items() if _is_sample_number(column.values)), None)
    return f": column {counted!r} counts samples" if counted is not None else "", CLOCK_ADVICE
