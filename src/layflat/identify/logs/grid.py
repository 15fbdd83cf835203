"""Resampling to one clock: commands are held, measured signals are interpolated, gaps stay open.

Stamps may jitter, be duplicated or missing, or go backwards once.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from layflat.arrays import Array
from layflat.errors import InputError
from layflat.identify.logs.vocabulary import SIGNALS, channel_name

GAP_PERIODS = 4.5  # periods between two samples from which they are a gap: more than three samples are missing
EVEN_TOLERANCE = 1e-6  # deviation from an even clock that is rounding, in periods
STAMP_ROUNDING = 2e-9  # the same in s, for stamps in whole nanoseconds
MAX_INSTANTS = 50_000_000  # of a grid; more mean a wrong unit of time
MAX_VALUES = 400_000_000  # of all signals on a grid: 3.2 GB, and as much again for the data set
MAX_FILLED = 3_000_000  # instants of a grid that is much finer than the samples
MUCH_FINER = 4.0  # instants a sample from which a grid is much finer


@dataclass(frozen=True)
class SampleClock:
    """Stamps of the kept rows of a file, s, strictly rising, with the faults that were mended."""

    time: Array
    rows: NDArray[np.intp]  # kept rows of the file
    firsts: NDArray[np.intp]  # first row with the stamp of each of these rows
    period: float  # median, s; 0 for less than two samples
    jitter: float  # rms deviation of the steps from the period, gaps left out, s
    even: bool  # the stamps are those of an even clock, with none missing
    duplicates: int  # samples left out because the next one has the same stamp
    undated: int  # samples left out because they have no stamp
    reset: tuple[float, float] | None  # stamps between which the clock jumped back; None if it didn't
    cut: int  # samples left out on the other side of the jump
    first_undated: int = 0  # number of the first sample without stamp, from 1; 0 where all have one
    reset_at: int = 0  # number of the first sample after the jump; 0 where there is none


def build_clock(stamps: Array, where: str) -> SampleClock:
    """Return the clock of stamps (s): without undated samples, the last of each stamp, the longer part about a reset.

    Raise InputError if time goes backwards more than once, or all stamps are equal.
    """
    rows = np.flatnonzero(np.isfinite(stamps))
    undated = stamps.size - rows.size
    first_undated = int(np.argmin(np.isfinite(stamps))) + 1 if undated else 0
    falls = np.flatnonzero(np.diff(stamps[rows]) < 0.0)
    reset_at = int(rows[falls[0] + 1]) + 1 if falls.size else 0
    rows, reset, cut = _cut_at_reset(stamps, rows, where)
    time = stamps[rows]
    is_last = np.append(np.diff(time) > 0.0, True) if rows.size else np.zeros(0, dtype=bool)
    duplicates = int(rows.size - is_last.sum())
    firsts = rows[np.append(True, is_last[:-1])] if rows.size else rows
    rows, time = rows[is_last], time[is_last]
    if time.size < 2 and duplicates > 0:
        problem = f"all {rows.size + duplicates} samples have the stamp {time[0]:g} s"
        raise InputError(problem, where=where, right="name a column that rises as its clock")
    period, jitter, even = _estimate_period(time) if time.size > 1 else (0.0, 0.0, False)
    return SampleClock(
        time, rows, firsts, period, jitter, even, duplicates, undated, reset, cut, first_undated, reset_at
    )


def _estimate_period(time: Array) -> tuple[float, float, bool]:
    """Return period and jitter of a clock, s, and whether it is even, with no stamp missing.

    The period is the mean one, and jitter 0, of a clock that is even but for missing stamps; else it is the median.
    """
    steps = np.diff(time)
    median = float(np.median(steps))
    counts = np.rint(steps / median)
    mean = float((time[-1] - time[0]) / max(counts.sum(), 1.0))
    deviation = np.abs(time - time[0] - mean * np.append(0.0, counts.cumsum())).max()
    rounding = max(EVEN_TOLERANCE * mean, STAMP_ROUNDING + 4.0 * float(np.spacing(np.abs(time).max())))
    if counts.min() >= 1.0 and deviation <= rounding:
        return mean, 0.0, bool(counts.max() == 1.0)
    regular = steps[steps <= GAP_PERIODS * median]
    return median, float(np.sqrt(np.mean((regular - median) ** 2))), False


def _cut_at_reset(
    stamps: Array, rows: NDArray[np.intp], where: str
) -> tuple[NDArray[np.intp], tuple[float, float] | None, int]:
    """Return the rows of the longer part of a clock that was set back once, the stamps around it, and the rows cut.

    All rows, None and 0 if it was never set back; raise InputError if it was more often.
    """
    falls = np.flatnonzero(np.diff(stamps[rows]) < 0.0)
    if not falls.size:
        return rows, None, 0
    first = int(falls[0])
    before, after = float(stamps[rows[first]]), float(stamps[rows[first + 1]])
    if falls.size > 1:
        first_jump = f"first from {before:.6g} s to {after:.6g} s at sample {rows[first + 1] + 1}"
        right = "order the samples by time, or cut the log where its clock was set; one jump is cut by itself"
        raise InputError(f"time goes backwards {falls.size} times, {first_jump}", where=where, right=right)
    kept = max(rows[: first + 1], rows[first + 1 :], key=len)
    return kept, (before, after), rows.size - kept.size


@dataclass(frozen=True)
class SignalSeries:
    """A signal of a joint (None where there is none), in SI over its own clock; NaN where there is no sample."""

    signal: str
    joint: str | None
    clock: SampleClock
    values: Array
    source: dict[str, object]  # its entry in the log's attributes

    @property
    def channel(self) -> str:
        """Name of signal and joint, such as "angle.elbow"."""
        return channel_name(self.signal, self.joint)


@dataclass(frozen=True)
class TimeGrid:
    """Instants to which all signals are resampled: start + i x period, s of the log's own clock.

    A grid that is not `even` has all stamps of all clocks; nothing is interpolated on it.
    """

    start: float
    period: float
    stamps: Array
    even: bool = True

    @property
    def time(self) -> Array:
        """Seconds since the start, (instants,)."""
        return self.period * np.arange(self.stamps.size, dtype=np.float64) if self.even else self.stamps - self.start


def build_grid(clocks: Sequence[SampleClock], cycle: float | None, where: str) -> TimeGrid:
    """Return an even grid over all clocks.

    Where the finest clock is even and spans the others, its own stamps are the grid, so that its samples stay as they
    are.

    Args:
        clocks: clocks of all signals.
        cycle: period of the grid, s; None: that of the finest clock.
        where: file, for messages.

    Raises:
        InputError: too few samples, or too many instants.
    """
    usable = [clock for clock in clocks if clock.period > 0.0]
    if not usable:
        raise InputError("has less than two samples", where=where, right="give a log of a motion")
    start, end = min(float(c.time[0]) for c in usable), max(float(c.time[-1]) for c in usable)
    finest = min(usable, key=lambda clock: (clock.period, -clock.time.size))
    period = finest.period if cycle is None else cycle
    spans = finest.time[0] == start and finest.time[-1] == end
    if finest.even and spans and abs(period / finest.period - 1.0) * finest.time.size < 1e-3:
        return TimeGrid(start, finest.period, finest.time)
    size = int((end - start) / period * (1.0 + 1e-9) + 1e-6) + 1
    samples = max(clock.time.size for clock in usable)
    if cycle is not None and size > max(MAX_FILLED, MUCH_FINER * samples):
        problem = f"{cycle:g} s make {size:.3g} instants of {samples} samples"
        raise InputError(problem, where="cycle", right=f"give {finest.period / MUCH_FINER:.2g} s or more")
    if size > MAX_INSTANTS:
        problem = f"{end - start:g} s at {period:g} s a sample are {(end - start) / period:.2g} samples, too many"
        raise InputError(problem, where=where, right="check the unit of time")
    if size * len(clocks) > MAX_VALUES:
        problem = f"{len(clocks)} signals at {size} instants are {8e-9 * size * len(clocks):.2g} GB"
        raise InputError(problem, where=where, right="cut the log, map fewer columns, or give a longer cycle")
    if size < 2:
        raise InputError(
            f"{end - start:g} s are less than a period of {period:g} s", where=where, right="give a shorter `cycle`"
        )
    return TimeGrid(start, period, start + period * np.arange(size, dtype=np.float64))


def build_recorded_grid(clocks: Sequence[SampleClock], where: str) -> TimeGrid:
    """Return the grid of all stamps of all clocks; raise InputError if there are fewer than two."""
    stamps = np.unique(np.concatenate([clock.time for clock in clocks]))
    if stamps.size < 2:
        raise InputError("has less than two samples", where=where, right="give a log of a motion")
    return TimeGrid(float(stamps[0]), float(np.median(np.diff(stamps))), stamps, even=False)


def resample(series: SignalSeries, grid: TimeGrid) -> Array:
    """Return a signal on the grid, (instants,): commands held, NaN before the first; others NaN outside and in gaps."""
    finite = np.isfinite(series.values)
    time, values = series.clock.time[finite], series.values[finite]
    if not time.size:
        return np.full(grid.stamps.size, np.nan)
    slack = 1e-6 * grid.period
    if SIGNALS[series.signal].held:
        last = np.searchsorted(time, grid.stamps + slack, side="right") - 1
        return np.where(last >= 0, values[np.maximum(last, 0)], np.nan)
    inside = np.clip(grid.stamps, time[0], time[-1])
    result = np.interp(inside, time, values)
    result[np.abs(inside - grid.stamps) > slack] = np.nan
    for since, until in find_gaps(series):
        first, end = np.searchsorted(grid.stamps, (since + slack, until - slack))
        result[first:end] = np.nan
    return result


def find_gaps(series: SignalSeries) -> list[tuple[float, float]]:
    """Return the stamps (s) of the samples before and after each gap of more than `GAP_PERIODS` periods."""
    time = series.clock.time[np.isfinite(series.values)]
    steps = np.diff(time)
    if not steps.size:
        return []
    wide = np.flatnonzero(steps > GAP_PERIODS * max(float(np.median(steps)), series.clock.period))
    return [(float(time[i]), float(time[i + 1])) for i in wide]
