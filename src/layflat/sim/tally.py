"""Metrics of a move that grow from record to record: the same for a trace and for runs that keep none.

Of a joint the error is its angle less what is asked for; of the tip it is the distance from its goal.
"""

from math import floor, inf
from typing import NamedTuple

from layflat.jit import kernel, law
from layflat.lanes import select


class Tally(NamedTuple):
    """A move so far."""

    settled: float  # records until it stays within the band
    overshoot: float  # largest error beyond the goal
    last_sum: float  # sum of the last errors
    last_low: float
    last_high: float


EMPTY = Tally(0.0, 0.0, 0.0, inf, -inf)
COLUMNS = len(Tally._fields)
SETTLED, OVERSHOOT, LAST_SUM, LAST_LOW, LAST_HIGH = range(COLUMNS)

LAST_PART = 0.8  # what comes after this share of a move counts as its end


@law
def last_records(count):
    """How many of a move's records come before its end."""
    return floor(LAST_PART * count)


@law
def emptied(tally, when):
    """The tally, or an empty one when a move begins."""
    return Tally(
        select(when, 0.0, tally.settled),
        select(when, 0.0, tally.overshoot),
        select(when, 0.0, tally.last_sum),
        select(when, inf, tally.last_low),
        select(when, -inf, tally.last_high),
    )


@law
def counted(tally, i, count, error, way, band):
    """Count record i of `count`; `way` is the sign of the way to go. An error that is not a number lies outside."""
    late = i >= last_records(count)
    return Tally(
        select(abs(error) <= band, tally.settled, i + 1.0),
        max(tally.overshoot, way * error),
        tally.last_sum + select(late, error, 0.0),
        select(late, min(tally.last_low, error), tally.last_low),
        select(late, max(tally.last_high, error), tally.last_high),
    )


@kernel
def tallied(errors, way, band):
    """The tally of a move from all its errors."""
    tally = EMPTY
    for i in range(len(errors)):
        tally = counted(tally, i, len(errors), errors[i], way, band)
    return tally
