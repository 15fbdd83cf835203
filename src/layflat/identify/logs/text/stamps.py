"""Dates and clock times as people write them, as seconds since the first."""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import date
from typing import NamedTuple

import numpy as np

from layflat.arrays import Array
from layflat.identify.logs.text.numbers import is_missing, plain

_MONTHS = (
    "jan janv januar january jän jänner", "feb febr fév févr februar february février", "mar mär mrz mars march märz",
    "apr avr april avril", "mai may", "jun juin juni june", "jul juil juillet juli july", "aug août aout august",
    "sep sept september septembre", "okt oct october oktober octobre", "nov november novembre",
    "dez dec déc december dezember décembre",
)  # fmt: skip
MONTHS = {word: 1 + i for i, words in enumerate(_MONTHS) for word in words.split()}

_DATE = (
    r"(?:(?P<y>\d{4})(?P<s0>[-/.])(?P<m>\d{1,2})(?P=s0)(?P<d>\d{1,2})"
    r"|(?P<a>\d{1,2})(?P<sep>[./-])(?P<b>\d{1,2})(?P=sep)(?P<c>\d{4}|\d{2})"
    r"|(?P<yy>\d{4})(?P<mm>\d{2})(?P<dd>\d{2})(?=[T _]\d)"
    r"|(?P<d2>\d{1,2})[-. ]+(?P<word>[^\W\d_]{3,9})\.?[-, ]+(?P<y2>\d{4}|\d{2})"
    r"|(?P<word3>[^\W\d_]{3,9})\.? (?P<d3>\d{1,2}),? (?P<y3>\d{4}))"
)
_CLOCK = (
    r"(?:(?P<days>\d+)(?: days?,? |\.(?=\d\d:\d\d:)))?"
    r"(?:(?P<h>\d{1,4}):(?P<min>\d{1,2}):(?P<s>\d{1,2})(?:[.,](?P<f>\d*)|:(?P<ms>\d{3}))?"
    r"|(?P<h2>\d{2})(?P<min2>\d{2})(?P<s2>\d{2})(?:[.,](?P<f2>\d+))?"
    r"|(?P<min3>\d{1,2}):(?P<s3>\d{2})[.,](?P<f3>\d+)"
    r"|(?P<h4>\d{1,2}):(?P<min4>\d{2}))"
    r"(?: ?(?P<half>[AaPp])\.?[Mm]\.?)?"
)
_ZONE = r"(?: ?(?P<zone>Z|UTC|GMT|[-+]\d{2}:?\d{2}))?"
_DATED = re.compile(rf"(?:[^\W\d_]{{2,9}}\.?,? )?{_DATE}(?:[T ,;_-]+{_CLOCK}{_ZONE})?")
_TIMED = re.compile(rf"{_CLOCK}{_ZONE}")

DAY = 86400.0  # s
HOUR = 3600.0  # s


class _Stamp(NamedTuple):
    """A stamp in its parts: three numbers of its date, in the order written, and its time of day."""

    date: tuple[int, int, int] | None  # year, month, day; year, first, second where the order has to be found
    order: str  # "ymd" where it is known, "/" where it isn't, "." and "-" for day first
    seconds: float  # whole, of the day, in UTC where a zone is said
    fraction: float
    zoned: bool
    hours: bool  # False of minutes and seconds alone


@dataclass(frozen=True)
class Stamps:
    """Seconds since the first stamp, NaN where a cell holds none, and what had to be decided."""

    seconds: Array
    dated: bool
    note: str
    start: float = 0.0  # the first stamp, s since the start of the first year, or of its day where it has no date


def is_stamp(text: str) -> bool:
    """Return whether a plain text is a date or a clock time."""
    return _stamp(text) is not None


def read_stamps(cells: Sequence[str]) -> Stamps | None:
    """Read a column of dates, dates with times, or times of day; None where less than half of the cells are such."""
    parts = [None if is_missing(cell) else _stamp(plain(cell)) for cell in cells]
    known = [part for part in parts if part is not None]
    filled = sum(not is_missing(cell) for cell in cells)
    kinds = {(part.date is None, part.zoned, part.hours) for part in known}
    if not known or 2 * len(known) < filled or len(kinds) > 1 or (known[0].date is None and _bare(known)):
        return None
    if known[0].date is None:
        return _of_the_day(parts, known[0].hours)
    orders = ["ymd"] if known[0].order == "ymd" else ["dmy"] if known[0].order in ".-" else ["dmy", "mdy"]
    readings = [(order, reading) for order in orders if (reading := _dated(parts, order)) is not None]
    if not readings:
        return None
    if len(readings) == 2 and not np.array_equal(readings[0][1][0], readings[1][1][0], equal_nan=True):
        readings.sort(key=lambda reading: _roughness(reading[1][0]))
        first = next(plain(cell) for cell in cells if not is_missing(cell))
        order = {"dmy": "day/month", "mdy": "month/day"}[readings[0][0]]
        note = f"dates such as {first!r} are read as {order}, which is smoother: check it"
    else:
        note = "dates and times are read as seconds since the first"
    since, start = readings[0][1]
    return Stamps(since, True, note, start)


def _bare(known: list[_Stamp]) -> bool:
    """Tell whether times are hours and minutes alone, which may be minutes and seconds, or digits without colons."""
    return all(part.order == "bare" for part in known)


def _stamp(text: str) -> _Stamp | None:
    match = _DATED.fullmatch(text) or _TIMED.fullmatch(text)
    if match is None:
        return None
    part = match.groupdict()
    day, order = _date_of(part)
    if day is None and order:
        return None
    hour, minute, second = (int(part[k] or part.get(f"{k}2") or part.get(f"{k}3") or part.get(f"{k}4") or 0)
                            for k in ("h", "min", "s"))  # fmt: skip
    fraction = float(f"0.{part['f'] or part['f2'] or part['f3'] or part['ms'] or 0}")
    if minute > 59 or second > 60 or (hour > 23 and day is not None):
        return None
    if part["half"]:
        hour = hour % 12 + (12 if part["half"] in "pP" else 0)
    seconds = DAY * int(part["days"] or 0) + HOUR * hour + 60.0 * minute + second
    zone = part["zone"]
    if zone and zone[0] in "+-":
        sign = -1.0 if zone[0] == "+" else 1.0
        seconds += sign * (HOUR * int(zone[1:3]) + 60.0 * int(zone[-2:]))
    bare = day is None and not part["half"] and (part["h4"] is not None or part["h2"] is not None)
    return _Stamp(day, "bare" if bare else order, seconds, fraction, bool(zone), part["min3"] is None)


def _date_of(part: dict[str, str | None]) -> tuple[tuple[int, int, int] | None, str]:
    """Return the numbers of a date and their order; None and an order where it can be no date."""
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


def _dated(parts: Sequence[_Stamp | None], order: str) -> tuple[Array, float] | None:
    """Return seconds since the first stamp, and that stamp, with the numbers of dates in an order.

    None where these are no dates.
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
        seconds[i] = DAY * (days - start[0]) + (part.seconds - start[1]) + part.fraction
    if start is None:
        return None
    offset = float(seconds[np.flatnonzero(np.isfinite(seconds))[0]])
    return seconds - offset, DAY * start[0] + start[1] + offset


def _roughness(seconds: Array) -> float:
    """Return how unevenly stamps go on: the largest step, and more where they go back."""
    steps = np.diff(seconds[np.isfinite(seconds)])
    return float(np.abs(steps).max(initial=0.0) * (10.0 if (steps < 0.0).any() else 1.0))


def _of_the_day(parts: Sequence[_Stamp | None], hours: bool) -> Stamps:
    """Return seconds of clock times that go on past midnight, or past the hour where they have no hours."""
    seconds = np.array([np.nan if part is None else part.seconds for part in parts])
    fractions = np.array([np.nan if part is None else part.fraction for part in parts])
    known = np.flatnonzero(np.isfinite(seconds))
    turn = DAY if hours else HOUR
    clock, note = (
        seconds[known] - seconds[known[0]] + fractions[known],
        "clock times are read as seconds since the first",
    )
    back = np.flatnonzero(np.diff(clock) < -0.5 * turn)
    if back.size and np.nanmax(seconds) < turn:
        clock[1:] += turn * np.cumsum(np.diff(clock) < -0.5 * turn)
        passed = "midnight" if hours else "the hour"
        note += f", on past {passed} at sample {known[back[0]] + 2}"
    result = np.full(len(parts), np.nan)
    result[known] = clock - clock[0]
    return Stamps(result, False, note, float(seconds[known[0]] + fractions[known[0]]))
