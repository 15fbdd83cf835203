"""Metrics of a move, accumulated from record to record: the same for a trace and for runs that keep none.

The error of a joint is its angle less the demand; that of the tip is its distance from the goal.
"""

from math import floor, inf
from typing import NamedTuple

import numpy as np

from layflat.arrays import Array
from layflat.jit import law, portable_kernel
from layflat.lanes import select, write_numbers


class Tally(NamedTuple):
    """Accumulated metrics of a move; errors are in rad, or in m of the tip."""

    settled: float  # number of records until the error stays within the band
    overshoot: float  # largest error beyond the goal
    last_sum: float  # sum of the errors in the last part of the move
    last_low: float  # smallest of these
    last_high: float  # largest of these


EMPTY_TALLY = Tally(0.0, 0.0, 0.0, inf, -inf)
COLUMNS = len(Tally._fields)
SETTLED_RECORDS, OVERSHOOT, LAST_SUM, LAST_LOW, LAST_HIGH = range(COLUMNS)

LAST_PART = 0.8  # fraction of a move's records after which its last part begins


@law
def last_records(count):
    """Return the number of records before the last part of a move of `count` records."""
    return floor(LAST_PART * count)


@law
def reset_tally(tally, when):
    """Return the tally, or an empty one where `when` is true."""
    return Tally(
        select(when, 0.0, tally.settled),
        select(when, 0.0, tally.overshoot),
        select(when, 0.0, tally.last_sum),
        select(when, inf, tally.last_low),
        select(when, -inf, tally.last_high),
    )


@law
def update_tally(tally, i, count, error, direction, band):
    """Return the tally after record i of `count`.

    `direction` is the sign of the move, by which an overshoot is positive; an error that is NaN lies outside the band.
    """
    late = i >= last_records(count)
    return Tally(
        select(abs(error) <= band, tally.settled, i + 1.0),
        max(tally.overshoot, direction * error),
        tally.last_sum + select(late, error, 0.0),
        select(late, min(tally.last_low, error), tally.last_low),
        select(late, max(tally.last_high, error), tally.last_high),
    )


@portable_kernel()
def write_tally(errors, direction, band, numbers):
    """Write the tally of a move from all its errors, (records,), into `numbers`."""
    tally = EMPTY_TALLY
    for i in range(len(errors)):
        tally = update_tally(tally, i, len(errors), errors[i], direction, band)
    write_numbers(numbers, tally)


def tally_errors(errors: Array, direction: float, band: float) -> Tally:
    """Return the tally of a move.

    Args:
        errors: all its errors, (records,), rad or m.
        direction: sign of the move, by which an overshoot is positive.
        band: limit of the error's magnitude at which the move has settled, in the errors' unit.
    """
    numbers = np.empty(COLUMNS)
    write_tally(np.ascontiguousarray(errors), float(direction), band, numbers)
    return Tally(*numbers.tolist())
