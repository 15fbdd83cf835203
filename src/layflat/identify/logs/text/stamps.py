"""Dates and clock times of text tables, as seconds since the first."""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import date
from typing import NamedTuple

import numpy as np

from layflat.arrays import Array
from layflat.identify.logs.text.numbers import is_missing, normalize_cell

_MONTHS = (
    "jan janv januar january jän jänner", "feb febr fév févr februar february février", "mar mär mrz mars march märz",
    "apr avr april avril", "mai may", "jun juin juni june", "jul juil juillet juli july", "aug août aout august",
    "sep sept september septembre", "okt oct october oktober octobre", "nov november novembre",
    "dez dec déc december dezember décembre",
)  # fmt: skip
MONTHS = {word: 1 + i for i, words in enumerate(_MONTHS) for word in words.split()}

_DATE_PATTERN = (
    r"(?:(?P<y>\d{4})(?P<s0>[-/.])(?P<m>\d{1,2})(?P=s0)(?P<d>\d{1,2})"
    r"|(?P<a>\d{1,2})(?P<sep>[./-])(?P<b>\d{1,2})(?P=sep)(?P<c>\d{4}|\d{2})"
    r"|(?P<yy>\d{4})(?P<mm>\d{2})(?P<dd>\d{2})(?=[T _]\d)"
    r"|(?P<d2>\d{1,2})[-. ]+(?P<word>[^\W\d_]{3,9})\.?[-, ]+(?P<y2>\d{4}|\d{2})"
    r"|(?P<word3>[^\W\d_]{3,9})\.? (?P<d3>\d{1,2}),? (?P<y3>\d{4}))"
)
_CLOCK_PATTERN = (
    r"(?:(?P<days>\d+)(?: days?,? |\.(?=\d\d:\d\d:)))?"
    r"(?:(?P<h>\d{1,4}):(?P<min>\d{1,2}):(?P<s>\d{1,2})(?:[.,](?P<f>\d*)|:(?P<ms>\d{3}))?"
    r"|(?P<h2>\d{2})(?P<min2>\d{2})(?P<s2>\d{2})(?:[.,](?P<f2>\d+))?"
    r"|(?P<min3>\d{1,2}):(?P<s3>\d{2})[.,](?P<f3>\d+)"
    r"|(?P<h4>\d{1,2}):(?P<min4>\d{2}))"
    r"(?: ?(?P<half>[AaPp])\.?[Mm]\.?)?"
)
_ZONE_PATTERN = r"(?: ?(?P<zone>Z|UTC|GMT|[-+]\d{2}:?\d{2}))?"
_DATE_STAMP = re.compile(rf"(?:[^\W\d_]{{2,9}}\.?,? )?{_DATE_PATTERN}(?:[T ,;_-]+{_CLOCK_PATTERN}{_ZONE_PATTERN})?")
_CLOCK_STAMP = re.compile(rf"{_CLOCK_PATTERN}{_ZONE_PATTERN}")

SECONDS_PER_DAY = 86400.0  # s
SECONDS_PER_HOUR = 3600.0  # s


class _Stamp(NamedTuple):
    """Date and time of day of a stamp."""

    date: tuple[int, int, int] | None  # year, month, day; or year and two numbers in the order written
    order: (
        str  # "ymd"; "/" for an unknown order; "." and "-" for day first; "bare" for digits or hours and minutes alone
    )
    seconds: float  # whole, of the day, in UTC where a zone is stated
    fraction: float
    zoned: bool
    hours: bool  # False for minutes and seconds alone


@dataclass(frozen=True)
class StampReading:
    """Seconds since the first stamp, NaN where a cell holds none, with a note on their format."""

    seconds: Array
    dated: bool
    note: str
    start: float = 0.0  # first stamp, s since the start of year 1, or of its day where it has no date


def is_stamp(text: str) -> bool:
    """Return whether a normalized cell is a date or a clock time."""
    return _parse_stamp(text) is not None


def read_stamps(cells: Sequence[str]) -> StampReading | None:
    """Read a column of dates, dates with times, or times of day.

    None where fewer than half of the filled cells are stamps, or these are of several kinds, ambiguous or invalid.
    """
    parts = [None if is_missing(cell) else _parse_stamp(normalize_cell(cell)) for cell in cells]
    stamps = [part for part in parts if part is not None]
    filled = sum(not is_missing(cell) for cell in cells)
    kinds = {(part.date is None, part.zoned, part.hours) for part in stamps}
    if not stamps or 2 * len(stamps) < filled or len(kinds) > 1 or (stamps[0].date is None and _are_ambiguous(stamps)):
        return None
    if stamps[0].date is None:
        return _clock_seconds(parts, stamps[0].hours)
    orders = ["ymd"] if stamps[0].order == "ymd" else ["dmy"] if stamps[0].order in ".-" else ["dmy", "mdy"]
    readings = [(order, reading) for order in orders if (reading := _date_seconds(parts, order)) is not None]
    if not readings:
        return None
    if len(readings) == 2 and not np.array_equal(readings[0][1][0], readings[1][1][0], equal_nan=True):
        readings.sort(key=lambda reading: _roughness(reading[1][0]))
        first = next(normalize_cell(cell) for cell in cells if not is_missing(cell))
        order = {"dmy": "day/month", "mdy": "month/day"}[readings[0][0]]
        note = f"dates such as {first!r} are read as {order}, which is smoother: check it"
    else:
        note = "dates and times are read as seconds since the first"
    since, start = readings[0][1]
    return StampReading(since, True, note, start)


def _are_ambiguous(stamps: list[_Stamp]) -> bool:
    """Return whether stamps are hours and minutes alone, which may be minutes and seconds, or digits alone."""
    return all(part.order == "bare" for part in stamps)


def _parse_stamp(text: str) -> _Stamp | None:
    """Return the stamp of a text; None where it is neither a date nor a clock time."""
    match = _DATE_STAMP.fullmatch(text) or _CLOCK_STAMP.fullmatch(text)
    if match is None:
        return None
    part = match.groupdict()
    day, order = _parse_date(part)
    if day is None and order:
        return None
    hour, minute, second = (int(part[k] or part.get(f"{k}2") or part.get(f"{k}3") or part.get(f"{k}4") or 0)
                            for k in ("h", "min", "s"))  # fmt: skip
    fraction = float(f"0.{part['f'] or part['f2'] or part['f3'] or part['ms'] or 0}")
    if minute > 59 or second > 60 or (hour > 23 and day is not None):
        return None
    if part["half"]:
        hour = hour % 12 + (12 if part["half"] in "pP" else 0)
    seconds = SECONDS_PER_DAY * int(part["days"] or 0) + SECONDS_PER_HOUR * hour + 60.0 * minute + second
    zone = part["zone"]
    if zone and zone[0] in "+-":
        sign = -1.0 if zone[0] == "+" else 1.0
        seconds += sign * (SECONDS_PER_HOUR * int(zone[1:3]) + 60.0 * int(zone[-2:]))
    bare = day is None and not part["half"] and (part["h4"] is not None or part["h2"] is not None)
    return _Stamp(day, "bare" if bare else order, seconds, fraction, bool(zone), part["min3"] is None)


def _parse_date(part: dict[str, str | None]) -> tuple[tuple[int, int, int] | None, str]:
    """Return the numbers of a date and their order; None and "" without date, None and an order for no valid date."""
    if "y" not in part:
        return None, ""
    if part["a"]:
        year = int(part["c"] or 0)
        return (year + 2000 if year < 100 else year, int(part["a"]), int(part["b"] or 0)), str(part["sep"])
    word = part["word"] or part["word3"]
    if word and word.lower() not in MONTHS:
        return None, "ymd"
    year = int(part["y"] or part["yy"] or part["y2"] or part["y3"] or 0)
    month = MONTHS[word.lower()] if word else int(part["m"] or part["mm"] or 0)
    day = int(part["d"] or part["dd"] or part["d2"] or part["d3"] or 0)
    return (year + 2000 if year < 100 else year, month, day), "ymd"


def _date_seconds(parts: Sequence[_Stamp | None], order: str) -> tuple[Array, float] | None:
    """Return seconds since the first stamp, and that stamp, s since the start of year 1; None for invalid dates.

    The order of the numbers is "ymd", "dmy" or "mdy".
    """
    seconds = np.full(len(parts), np.nan)
    start: tuple[int, float] | None = None  # day and seconds of the first stamp
    for i, part in enumerate(parts):
        if part is None or part.date is None:
            continue
        year, first, second = part.date
        month, day = (second, first) if order == "dmy" else (first, second)
        try:
            days = date(year, month, day).toordinal()
        except ValueError:
            return None
        start = start or (days, part.seconds)
        seconds[i] = SECONDS_PER_DAY * (days - start[0]) + (part.seconds - start[1]) + part.fraction
    if start is None:
        return None
    offset = float(seconds[np.flatnonzero(np.isfinite(seconds))[0]])
    return seconds - offset, SECONDS_PER_DAY * start[0] + start[1] + offset


def _roughness(seconds: Array) -> float:
    """Return the largest step of stamps, s, ten times that if they ever go back: low for the right order of dates."""
    steps = np.diff(seconds[np.isfinite(seconds)])
    return float(np.abs(steps).max(initial=0.0) * (10.0 if (steps < 0.0).any() else 1.0))


def _clock_seconds(parts: Sequence[_Stamp | None], hours: bool) -> StampReading:
    """Return seconds since the first clock time, continued past midnight, or past the hour without hours."""
    seconds = np.array([np.nan if part is None else part.seconds for part in parts])
    fractions = np.array([np.nan if part is None else part.fraction for part in parts])
    finite = np.flatnonzero(np.isfinite(seconds))
    wrap = SECONDS_PER_DAY if hours else SECONDS_PER_HOUR
    clock, note = (
        seconds[finite] - seconds[finite[0]] + fractions[finite],
        "clock times are read as seconds since the first",
    )
    wraps = np.flatnonzero(np.diff(clock) < -0.5 * wrap)
    if wraps.size and np.nanmax(seconds) < wrap:
        clock[1:] += wrap * np.cumsum(np.diff(clock) < -0.5 * wrap)
        passed = "midnight" if hours else "the hour"
        note += f", on past {passed} at sample {finite[wraps[0]] + 2}"
    result = np.full(len(parts), np.nan)
    result[finite] = clock - clock[0]
    return StampReading(result, False, note, float(seconds[finite[0]] + fractions[finite[0]]))
