"""The clock of a log: stamps that jitter, stand twice, are missing or go backwards."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from layflat.errors import InputError

Array = NDArray[np.float64]

GAP = 4.5
"""Periods between two samples that are a gap: more than three samples are missing."""

EVEN = 1e-6
"""Deviation from an even clock, in periods, that is rounding."""

NANOSECONDS = 2e-9
"""The same in s, for stamps that are whole nanoseconds."""


@dataclass(frozen=True)
class Clock:
    """Stamps as they can be used.

    Attributes:
        time: (samples,) rising, s.
        rows: (samples,) rows of the file that are kept.
        period: median, s; 0 for less than two samples.
        jitter: rms deviation of the steps from the period, gaps left out, s.
        even: the stamps are those of an even clock, with none missing.
        duplicates: samples left out because the next one has the same stamp.
        undated: samples left out because they have no stamp.
        reset: stamps between which the clock jumped back; None if it didn't.
        cut: samples left out for it.
    """

    time: Array
    rows: NDArray[np.intp]
    period: float
    jitter: float
    even: bool
    duplicates: int
    undated: int
    reset: tuple[float, float] | None
    cut: int


def clock_of(stamps: Array, where: str) -> Clock:
    """Make stamps (s) usable: undated samples go; of several with one stamp the last stays; a reset is cut.

    Raises:
        InputError: time goes backwards more than once, or never goes on.
    """
    rows = np.flatnonzero(np.isfinite(stamps))
    undated = stamps.size - rows.size
    rows, reset, cut = _without_reset(stamps, rows, where)
    time = stamps[rows]
    last = np.append(np.diff(time) > 0.0, True) if rows.size else np.zeros(0, dtype=bool)
    duplicates = int(rows.size - last.sum())
    rows, time = rows[last], time[last]
    if time.size < 2:
        if rows.size + duplicates > 1:
            raise InputError(
                f"all {rows.size + duplicates} samples have the stamp {time[0]:g} s", where=where,
                right="name a column that rises as its clock",
            )  # fmt: skip
        return Clock(time, rows, 0.0, 0.0, False, duplicates, undated, reset, cut)
    steps = np.diff(time)
    period, on_grid, even = _period(time, steps)
    usual = steps[steps <= GAP * period]
    jitter = 0.0 if on_grid else float(np.sqrt(np.mean((usual - period) ** 2)))
    return Clock(time, rows, period, jitter, even, duplicates, undated, reset, cut)


def _period(time: Array, steps: Array) -> tuple[float, bool, bool]:
    """Period of a clock, s; whether all stamps are whole periods apart; and whether none is missing between them."""
    median = float(np.median(steps))
    counts = np.rint(steps / median)
    mean = float((time[-1] - time[0]) / max(counts.sum(), 1.0))
    off = np.abs(time - time[0] - mean * np.append(0.0, counts.cumsum())).max()
    rounding = max(EVEN * mean, NANOSECONDS + 4.0 * float(np.spacing(np.abs(time).max())))
    on_grid = bool(counts.min() >= 1.0 and off <= rounding)
    return (mean if on_grid else median), on_grid, on_grid and bool(counts.max() == 1.0)


def _without_reset(
    stamps: Array, rows: NDArray[np.intp], where: str
) -> tuple[NDArray[np.intp], tuple[float, float] | None, int]:
    """Rows of the longer part where a clock was set back once."""
    back = np.flatnonzero(np.diff(stamps[rows]) < 0.0)
    if not back.size:
        return rows, None, 0
    first = int(back[0])
    before, after = float(stamps[rows[first]]), float(stamps[rows[first + 1]])
    if back.size > 1:
        raise InputError(
            f"time goes backwards {back.size} times, first from {before:.6g} s to {after:.6g} s at sample "
            f"{rows[first + 1] + 1}",
            where=where,
            right="order the samples by time, or cut the log where its clock was set; one jump is cut by itself",
        )
    parts = rows[: first + 1], rows[first + 1 :]
    kept = max(parts, key=len)
    return kept, (before, after), rows.size - kept.size
