"""From samples with stamps to one clock: commands are held, what was measured is interpolated, gaps stay open."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from layflat.errors import InputError
from layflat.identify.logs.clock import GAP, Array, Clock
from layflat.identify.logs.signals import SIGNALS, channel_name

MOST = 50_000_000
"""Instants of a grid; more would be a wrong unit of time."""


@dataclass(frozen=True)
class Series:
    """A signal of a joint over its own clock.

    Attributes:
        signal: standard name.
        joint: its joint; None where there is none.
        clock: its stamps.
        values: (samples of the clock,), SI, NaN where there is none.
        source: what the log's attributes tell of it.
    """

    signal: str
    joint: str | None
    clock: Clock
    values: Array
    source: dict[str, object]

    @property
    def channel(self) -> str:
        """Signal and joint in one word."""
        return channel_name(self.signal, self.joint)


@dataclass(frozen=True)
class Grid:
    """Instants that all signals are brought to: start + i x period, for i < size; in s of the log's own clock.

    One that is not `even` has all stamps of all clocks, and nothing is interpolated between them.
    """

    start: float
    period: float
    size: int
    stamps: Array
    even: bool = True

    @property
    def time(self) -> Array:
        """Seconds since the start, (size,)."""
        return self.period * np.arange(self.size, dtype=np.float64) if self.even else self.stamps - self.start


def grid_over(clocks: Sequence[Clock], cycle: float | None, where: str) -> Grid:
    """The grid over all clocks: with the period of the finest, or a given one.

    Where the finest clock is even and spans the others, its own stamps are the grid, and its samples stay as they are.

    Raises:
        InputError: there are too few samples, or too many instants.
    """
    usable = [clock for clock in clocks if clock.period > 0.0]
    if not usable:
        raise InputError("has less than two samples", where=where, right="give a log of a motion")
    start, end = min(float(c.time[0]) for c in usable), max(float(c.time[-1]) for c in usable)
    finest = min(usable, key=lambda clock: (clock.period, -clock.time.size))
    period = finest.period if cycle is None else cycle
    spans = finest.time[0] == start and finest.time[-1] == end
    if finest.even and spans and abs(period / finest.period - 1.0) * finest.time.size < 1e-3:
        return Grid(start, finest.period, finest.time.size, finest.time)
    size = int((end - start) / period * (1.0 + 1e-9) + 1e-6) + 1
    if size > MOST:
        raise InputError(
            f"{end - start:g} s at {period:g} s a sample are too many", where=where, right="check the unit of time"
        )
    if size < 2:
        raise InputError(f"{end - start:g} s are less than a period of {period:g} s", where=where, right="give less")
    return Grid(start, period, size, start + period * np.arange(size, dtype=np.float64))


def grid_as_recorded(clocks: Sequence[Clock], where: str) -> Grid:
    """All stamps of all clocks, as they are.

    Raises:
        InputError: there are too few.
    """
    stamps = np.unique(np.concatenate([clock.time for clock in clocks]))
    if stamps.size < 2:
        raise InputError("has less than two samples", where=where, right="give a log of a motion")
    return Grid(float(stamps[0]), float(np.median(np.diff(stamps))), stamps.size, stamps, even=False)


def resampled(series: Series, grid: Grid) -> Array:
    """A signal on the grid, (size,); NaN where nothing is known."""
    known = np.isfinite(series.values)
    time, values = series.clock.time[known], series.values[known]
    if not time.size:
        return np.full(grid.size, np.nan)
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
