"""From samples with stamps to one clock: commands are held, what was measured is interpolated, gaps stay open.

Stamps may jitter, stand twice, be missing or go backwards once.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from layflat.arrays import Array
from layflat.errors import InputError
from layflat.identify.logs.vocabulary import SIGNALS, channel_name

GAP = 4.5  # periods between two samples that are a gap: more than three samples are missing
EVEN = 1e-6  # deviation from an even clock, in periods, that is rounding
NANOSECONDS = 2e-9  # the same in s, for stamps that are whole nanoseconds
MAX_INSTANTS = 50_000_000  # of a grid; more would be a wrong unit of time
MAX_VALUES = 400_000_000  # of all signals on a grid: 3.2 GB, and what is made of them takes as much again
MAX_FILLED = 3_000_000  # instants of a grid that is much finer than its samples
MUCH_FINER = 4.0  # instants for each sample


@dataclass(frozen=True)
class Clock:
    """Stamps as they can be used: rising, s, of the rows of the file that are kept."""

    time: Array
    rows: NDArray[np.intp]
    firsts: NDArray[np.intp]  # first row with the stamp of each of these rows
    period: float  # median, s; 0 for less than two samples
    jitter: float  # rms deviation of the steps from the period, gaps left out, s
    even: bool  # the stamps are those of an even clock, with none missing
    duplicates: int  # samples left out because the next one has the same stamp
    undated: int  # samples left out because they have no stamp
    reset: tuple[float, float] | None  # stamps between which the clock jumped back; None if it didn't
    cut: int  # samples left out for it
    first_undated: int = 0  # number of the first sample without stamp, from 1; 0 where all have one
    reset_at: int = 0  # number of the first sample after the jump; 0 where there is none


def clock_of(stamps: Array, where: str) -> Clock:
    """Make stamps (s) usable: undated samples go; of several with one stamp the last stays; a reset is cut.

    Raise InputError if time goes backwards more than once, or never goes on.
    """
    rows = np.flatnonzero(np.isfinite(stamps))
    undated = stamps.size - rows.size
    first_undated = int(np.argmin(np.isfinite(stamps))) + 1 if undated else 0
    falls = np.flatnonzero(np.diff(stamps[rows]) < 0.0)
    reset_at = int(rows[falls[0] + 1]) + 1 if falls.size else 0
    rows, reset, cut = _without_reset(stamps, rows, where)
    time = stamps[rows]
    last = np.append(np.diff(time) > 0.0, True) if rows.size else np.zeros(0, dtype=bool)
    duplicates = int(rows.size - last.sum())
    firsts = rows[np.append(True, last[:-1])] if rows.size else rows
    rows, time = rows[last], time[last]
    if time.size < 2 and duplicates > 0:
        what = f"all {rows.size + duplicates} samples have the stamp {time[0]:g} s"
        raise InputError(what, where=where, right="name a column that rises as its clock")
    period, jitter, even = _period(time) if time.size > 1 else (0.0, 0.0, False)
    return Clock(time, rows, firsts, period, jitter, even, duplicates, undated, reset, cut, first_undated, reset_at)


def _period(time: Array) -> tuple[float, float, bool]:
    """Period and jitter of a clock, s; and whether it is even, with no stamp missing."""
    steps = np.diff(time)
    median = float(np.median(steps))
    counts = np.rint(steps / median)
    mean = float((time[-1] - time[0]) / max(counts.sum(), 1.0))
    off = np.abs(time - time[0] - mean * np.append(0.0, counts.cumsum())).max()
    rounding = max(EVEN * mean, NANOSECONDS + 4.0 * float(np.spacing(np.abs(time).max())))
    if counts.min() >= 1.0 and off <= rounding:
        return mean, 0.0, bool(counts.max() == 1.0)
    usual = steps[steps <= GAP * median]
    return median, float(np.sqrt(np.mean((usual - median) ** 2))), False


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
        at = f"first from {before:.6g} s to {after:.6g} s at sample {rows[first + 1] + 1}"
        right = "order the samples by time, or cut the log where its clock was set; one jump is cut by itself"
        raise InputError(f"time goes backwards {back.size} times, {at}", where=where, right=right)
    kept = max(rows[: first + 1], rows[first + 1 :], key=len)
    return kept, (before, after), rows.size - kept.size


@dataclass(frozen=True)
class Series:
    """A signal of a joint (None where there is none), in SI over its own clock; NaN where there is no sample."""

    signal: str
    joint: str | None
    clock: Clock
    values: Array
    source: dict[str, object]  # what the log's attributes tell of it

    @property
    def channel(self) -> str:
        """Signal and joint in one word."""
        return channel_name(self.signal, self.joint)


@dataclass(frozen=True)
class Grid:
    """Instants that all signals are brought to: start + i x period, in s of the log's own clock.

    One that is not `even` has all stamps of all clocks, and nothing is interpolated between them.
    """

    start: float
    period: float
    stamps: Array
    even: bool = True

    @property
    def time(self) -> Array:
        """Seconds since the start, (instants,)."""
        return self.period * np.arange(self.stamps.size, dtype=np.float64) if self.even else self.stamps - self.start


def grid_over(clocks: Sequence[Clock], cycle: float | None, where: str) -> Grid:
    """The grid over all clocks: with the period of the finest, or a given one.

    Where the finest clock is even and spans the others, its own stamps are the grid, and its samples stay as they are.
    Raise InputError if there are too few samples, or too many instants.
    """
    usable = [clock for clock in clocks if clock.period > 0.0]
    if not usable:
        raise InputError("has less than two samples", where=where, right="give a log of a motion")
    start, end = min(float(c.time[0]) for c in usable), max(float(c.time[-1]) for c in usable)
    finest = min(usable, key=lambda clock: (clock.period, -clock.time.size))
    period = finest.period if cycle is None else cycle
    spans = finest.time[0] == start and finest.time[-1] == end
    if finest.even and spans and abs(period / finest.period - 1.0) * finest.time.size < 1e-3:
        return Grid(start, finest.period, finest.time)
    size = int((end - start) / period * (1.0 + 1e-9) + 1e-6) + 1
    samples = max(clock.time.size for clock in usable)
    if cycle is not None and size > max(MAX_FILLED, MUCH_FINER * samples):
        what = f"{cycle:g} s make {size:.3g} instants of {samples} samples"
        raise InputError(what, where="cycle", right=f"give {finest.period / MUCH_FINER:.2g} s or more")
    if size > MAX_INSTANTS:
        what = f"{end - start:g} s at {period:g} s a sample are too many"
        raise InputError(what, where=where, right="check the unit of time")
    if size * len(clocks) > MAX_VALUES:
        what = f"{len(clocks)} signals at {size} instants are {8e-9 * size * len(clocks):.2g} GB"
        raise InputError(what, where=where, right="cut the log, map fewer columns, or give a longer cycle")
    if size < 2:
        raise InputError(f"{end - start:g} s are less than a period of {period:g} s", where=where, right="give less")
    return Grid(start, period, start + period * np.arange(size, dtype=np.float64))


def grid_as_recorded(clocks: Sequence[Clock], where: str) -> Grid:
    """All stamps of all clocks, as they are; raise InputError if there are too few."""
    stamps = np.unique(np.concatenate([clock.time for clock in clocks]))
    if stamps.size < 2:
        raise InputError("has less than two samples", where=where, right="give a log of a motion")
    return Grid(float(stamps[0]), float(np.median(np.diff(stamps))), stamps, even=False)


def resampled(series: Series, grid: Grid) -> Array:
    """A signal on the grid, (instants,); NaN where nothing is known."""
    known = np.isfinite(series.values)
    time, values = series.clock.time[known], series.values[known]
    if not time.size:
        return np.full(grid.stamps.size, np.nan)
    slack = 1e-6 * grid.period
    if SIGNALS[series.signal].held:
        last = np.searchsorted(time, grid.stamps + slack, side="right") - 1
        return np.where(last >= 0, values[np.maximum(last, 0)], np.nan)
    inside = np.clip(grid.stamps, time[0], time[-1])
    result = np.interp(inside, time, values)
    result[np.abs(inside - grid.stamps) > slack] = np.nan
    for since, until in gaps(series):
        first, end = np.searchsorted(grid.stamps, (since + slack, until - slack))
        result[first:end] = np.nan
    return result


def gaps(series: Series) -> list[tuple[float, float]]:
    """Stamps (s) of the samples on both sides of each gap."""
    time = series.clock.time[np.isfinite(series.values)]
    steps = np.diff(time)
    if not steps.size:
        return []
    wide = np.flatnonzero(steps > GAP * max(float(np.median(steps)), series.clock.period))
    return [(float(time[i]), float(time[i + 1])) for i in wide]
