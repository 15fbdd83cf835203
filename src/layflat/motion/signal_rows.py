"""Expansion of signals over time, as people write them, into a row of numbers for each control cycle.

Steps mean the same in every signal: a value holds from its time on, a joint that a step does not name keeps its value,
and before the first step all joints have their initial value.

A signal that changes faster than the control cycles sample it is refused, as values between two samples would be lost
silently. Between two samples, a signal that is sampled often enough lies between their values, or little beyond them; a
signal with a period of less than two samples does not.
"""

from collections.abc import Callable, Sequence
from itertools import pairwise
from typing import Any, Protocol, TypeGuard

import numpy as np
from numpy.typing import NDArray

from layflat.arrays import Array
from layflat.description import units as u
from layflat.errors import InputError
from layflat.jit.outside import NO_FAILURES
from layflat.motion.labelled import is_labelled, read_labelled_row, read_labelled_steps
from layflat.motion.signal_values import Angles, Sampling, SignalKind, Value, check_real, read_number, read_row

MAX_TRIED = 2000  # control cycles in which a function is evaluated between samples
GOLDEN_RATIO = 0.6180339887498949  # its multiples give fractions of cycles that never repeat
MAX_EXCESS = 0.4
"""Rms excess beyond the neighbouring samples over the standard deviation: 0.42 or more for sines and square waves of
less than two samples per period, 0.39 or less for others."""
MAX_EXCESS_OF_CHANGE = 0.23  # rms excess over the rms change from sample to sample: for a ripple on a slow motion
RELATIVE_ROUNDING = 1e-9  # excess over the largest value


def check_function_rate(function: Callable[[Array], Array], rows: Array, sampling: Sampling, where: str) -> None:
    """Refuse a function of time that changes too fast for the control cycles; fewer than three are not checked.

    Args:
        function: function from times (s) to values, (times, names).
        rows: its values in the control cycles, (cycles, names).
        sampling: the control cycles.
        where: the argument in messages.

    Raises:
        InputError: naming `where`: what happens between the control cycles would be lost.
    """
    if sampling.cycles < 3:
        return
    first = np.unique(np.linspace(0, sampling.cycles - 2, min(MAX_TRIED, sampling.cycles - 1)).astype(int))
    fraction = np.modf(GOLDEN_RATIO * (first + 1))[0]
    between = function(sampling.cycle * (first + fraction))
    _check_rate(between, rows[first], rows[first + 1], sampling, where)


def check_table_rate(times: Array, values: Array, rows: Array, sampling: Sampling, where: str) -> None:
    """Refuse a table with more rows than control cycles if those between the cycles would be lost.

    Tables for fewer than three cycles are not checked.

    Args:
        times: times of the rows, s.
        values: (rows, names).
        rows: those that hold in the control cycles, (cycles, names).
        sampling: the control cycles.
        where: the argument in messages.

    Raises:
        InputError: naming `where`: rows between the control cycles would be lost.
    """
    inside = (times > 0.0) & (times < sampling.cycle * (sampling.cycles - 1))
    if sampling.cycles < 3 or inside.sum() <= sampling.cycles:
        return
    first = np.floor(times[inside] / sampling.cycle).astype(int)
    _check_rate(values[inside], rows[first], rows[first + 1], sampling, where)


def _check_rate(between: Array, before: Array, after: Array, sampling: Sampling, where: str) -> None:
    """Raise InputError if a signal changes faster than its control cycles can sample.

    `between` are values between cycles, `before` and `after` those in the cycles around them, each (values, names).
    """
    low, high = np.minimum(before, after), np.maximum(before, after)
    excess = np.sqrt(np.mean(np.maximum(0.0, np.maximum(between - high, low - between)) ** 2, axis=0))
    deviation = np.std(np.concatenate([between, before]), axis=0)
    change = np.sqrt(np.mean((after - before) ** 2, axis=0))
    large = excess > RELATIVE_ROUNDING * np.abs(between).max()
    if np.any(large & ((excess > MAX_EXCESS * deviation) | (excess > MAX_EXCESS_OF_CHANGE * change))):
        what = f"changes faster than control cycles of {1e3 * sampling.cycle:g} ms can follow"
        right = f"give periods of {2e3 * sampling.cycle:g} ms or more, or an array with a row for each cycle"
        raise InputError(what, where=where, right=right)


class LabelledTable(Protocol):
    """Table of pandas or xarray."""

    @property
    def attrs(self) -> Any:
        """Attributes of the table, such as its units, by name."""


Steps = Sequence[tuple[Value, Angles]]
Signal = Angles | Steps | Callable[[float], Angles] | Array | LabelledTable
"""A constant, steps of (time, values), a function of time, an array of one row per control cycle, or a labelled table
(a DataFrame or Series of pandas, a DataArray of xarray) with times in its index and joints as names."""

TIME_ROUNDING = 1e-9  # deviation of a time from a control cycle, s


def expand_signal(signal: Any, kind: SignalKind, before: Array, sampling: Sampling) -> Array:
    """Return the values of a signal in every control cycle, (cycles, names), in SI units.

    Args:
        signal: see `Signal`; of arrays every row is a control cycle.
        kind: kind of the signal, with the names of its columns.
        before: values (names,) before the first step, and of names that are left out.
        sampling: the control cycles.

    Raises:
        InputError: naming the argument: it is no such signal, holds a wrong value, continues after the end, or changes
            faster than the control cycles can follow.
    """
    if is_labelled(signal):
        row = read_labelled_row(signal, kind)
        if row is None:
            return _expand_table(signal, kind, before, sampling)
        signal = row
    if isinstance(signal, np.ndarray) and signal.ndim > 0:
        return read_rows(signal, kind, sampling.cycles)
    if callable(signal):
        rows = _evaluate_function(signal, kind, before, sampling.times)
        check_function_rate(lambda times: _evaluate_function(signal, kind, before, times), rows, sampling, kind.where)
        return rows
    if is_steps(signal):
        times, values = read_steps(signal, kind, before)
        _check_ends(times, kind.where, sampling)
        return _hold_values(times, values, before, sampling.times)
    return np.tile(read_row(signal, kind, before), (sampling.cycles, 1))


def is_steps(signal: object) -> TypeGuard[Steps]:
    """Return whether a signal is a list or tuple, not empty, of tuples (time, values)."""
    return isinstance(signal, (list, tuple)) and len(signal) > 0 and all(
        isinstance(item, tuple) and len(item) == 2 for item in signal
    )  # fmt: skip


def read_steps(steps: Steps, kind: SignalKind, before: Array) -> tuple[Array, Array]:
    """Return the times (s) of steps and the values from these on, (steps, names).

    Args:
        steps: pairs of time and values.
        kind: kind of the signal, with the names of its columns.
        before: values (names,) before the first step; a name that a step leaves out keeps its value.

    Raises:
        InputError: a time or value is wrong, a time is before the start, or times do not increase.
    """
    times = [read_number(time, u.TIME, kind.where) for time, _ in steps]
    if times[0] < 0.0:
        raise InputError(f"{times[0]:g} s is before the start", where=kind.where, right='begin with ("0 s", ...)')
    if any(b <= a for a, b in pairwise(times)):
        raise InputError(
            "the times of its steps do not grow", where=kind.where, right='give ("0 s", ...), ("1 s", ...)'
        )
    rows, last = [], before
    for _, values in steps:
        last = read_row(values, kind, last)
        rows.append(last)
    return np.array(times), np.array(rows)


def _check_ends(times: Array, where: str, sampling: Sampling) -> None:
    """Raise InputError for a step after the end, or one that is followed by another in the same control cycle."""
    if times[-1] > sampling.times[-1] + TIME_ROUNDING:
        right = f"the run ends at {sampling.end:g} s: give an earlier time, or a longer duration"
        raise InputError(f"{times[-1]:g} s is after the end", where=where, right=right)
    cycles = np.ceil((times - TIME_ROUNDING) / sampling.cycle)
    late = np.flatnonzero(np.diff(cycles) <= 0.0)
    if len(late):
        a, b = times[late[0]], times[late[0] + 1]
        what = f"its steps at {a:g} s and {b:g} s fall into one control cycle of {sampling.cycle:g} s"
        raise InputError(what, where=where, right="the first would not act: leave one out")


def _hold_values(times: Array, values: Array, before: Array, instants: Array) -> Array:
    """Return the values that hold at instants: each from its time on, `before` until the first."""
    which = np.searchsorted(times - TIME_ROUNDING, instants, side="right")
    rows: Array = np.concatenate([before[None], values])[which]
    return rows


def _expand_table(signal: Any, kind: SignalKind, before: Array, sampling: Sampling) -> Array:
    """Return the values of a labelled table in every control cycle: each row from its time on.

    `before` holds until the first row, and throughout for names that the table lacks.

    Raises:
        InputError: a value is wrong or not finite, a row is after the end, or the table changes too fast.
    """
    times, values = read_labelled_steps(signal, kind)
    if times[-1] > sampling.end + TIME_ROUNDING:
        right = f"the run ends at {sampling.end:g} s: give a longer duration, or leave out later rows"
        raise InputError(f"its last row, at {times[-1]:g} s, is after the end", where=kind.where, right=right)
    values = np.where(np.isnan(values), before, values)
    rows = _hold_values(times, values, before, sampling.times)
    check_table_rate(times, values, rows, sampling, kind.where)
    return rows


def _evaluate_function(signal: Callable[[float], Any], kind: SignalKind, before: Array, times: Array) -> Array:
    """Return the values of a user's function at times (s), (times, names); items that it leaves out keep their values.

    Raises:
        InputError: the function fails or returns a wrong value.
    """
    rows = np.empty((len(times), len(kind.names)))
    last = before
    for k, time in enumerate(times.tolist()):
        try:
            values = signal(time)
        except NO_FAILURES:
            raise
        except BaseException as error:  # whatever a user's function raises
            what = f"its function fails at {time:g} s ({type(error).__name__}: {' '.join(str(error).split())})"
            raise InputError(what, where=kind.where, right="give a function of the time in s") from error
        rows[k] = last = read_row(values, kind, last)
    return rows


def read_rows(array: Any, kind: SignalKind, count: int) -> Array:
    """Return rows of values in SI units, (count, names).

    Args:
        array: (count, names), or (count,) where all joints share a value, which axes can't.
        kind: kind of the signal.
        count: number of the rows, one a control cycle.

    Raises:
        InputError: the shape does not fit, or a value is no finite real number.
    """
    try:
        array = array if isinstance(array, np.ndarray) else np.asarray(array)
    except ValueError:  # rows of several lengths
        raise InputError(
            "has rows of several lengths", where=kind.where, right=f"give {len(kind.names)} a row"
        ) from None
    check_real(array, kind)
    width = len(kind.names)
    wide = np.asarray(array)
    if array.ndim == 1 and kind.noun != "axis":
        wide = np.repeat(wide[:, None], width, axis=1)
    if wide.shape != (count, width):
        right = _shape_advice(array, count, width)
        raise InputError(f"an array of shape {array.shape} does not fit", where=kind.where, right=right)
    if wide.dtype.kind in "UO":
        wide = np.array([read_number(value, kind.quantity, kind.where) for value in wide.ravel()]).reshape(wide.shape)
    if not np.isfinite(wide).all():
        raise InputError("holds a value that is not finite", where=kind.where, right="give numbers only")
    return np.ascontiguousarray(wide, dtype=np.float64)


def _shape_advice(array: NDArray[Any], count: int, width: int) -> str:
    """Return advice: the shape that an array should have, and the likely mistake."""
    right = f"give shape {(count, width)}: a row for each control cycle, a column for each value in it"
    if array.shape == (width,):
        return f"{right}; or a list for one value each"
    if array.shape in {(count + 1, width), (count + 1,)}:
        return f"{right}; a run's records have one more: leave out the last"
    if array.shape == (width, count):
        return f"{right}; this one is transposed"
    return right
