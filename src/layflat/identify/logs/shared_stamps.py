"""Clocks whose stamps are coarser than the rows: whole seconds above samples of 100 Hz, say."""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from layflat.arrays import Array

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
