"""Metrics of a move that grow from record to record: the same for a trace and for runs that keep none.

A tally is a row of numbers, `COLUMNS` long. Of a joint the error is its angle less what is asked for; of the tip it is
the distance from its goal.
"""

from math import inf

import numpy as np

from layflat.jit import kernel, law

SETTLED, OVERSHOOT, LAST_SUM, LAST_LOW, LAST_HIGH = range(5)
"""Records until it stays within the band; largest error beyond the goal; sum, least and greatest of the last errors."""
COLUMNS = 5

LAST_PART = 0.8
"""What comes after this share of a move counts as its end."""


@law
def last_records(count):
    """How many of a move's records come before its end."""
    return int(LAST_PART * count)


@law
def clear(row):
    """Begin a move."""
    row[SETTLED], row[OVERSHOOT], row[LAST_SUM], row[LAST_LOW], row[LAST_HIGH] = 0.0, 0.0, 0.0, inf, -inf


@law
def add(row, i, count, error, way, band):
    """Add record i of `count`; `way` is the sign of the way to go. An error that is not a number lies outside."""
    if not abs(error) <= band:
        row[SETTLED] = i + 1.0
    row[OVERSHOOT] = max(row[OVERSHOOT], way * error)
    if i >= last_records(count):
        row[LAST_SUM] += error
        row[LAST_LOW] = min(row[LAST_LOW], error)
        row[LAST_HIGH] = max(row[LAST_HIGH], error)


@kernel
def tallied(errors, way, band):
    """The tally of a move from all its errors."""
    row = np.empty(COLUMNS)
    clear(row)
    for i in range(len(errors)):
        add(row, i, len(errors), errors[i], way, band)
    return row
