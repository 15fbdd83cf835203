"""Signals over time as people write them, turned into a row of numbers for each control cycle.

Steps mean the same in every signal: a value holds from its time on, a joint that a step does not name keeps the value
that it had, and before the first step all have the value that they start with.
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
from layflat.motion.aliasing import check_function_rate, check_table_rate
from layflat.motion.labelled import is_labelled, labelled_row, labelled_steps
from layflat.motion.signal_values import Angles, Sampling, SignalKind, Value, check_real, read_number, read_row


class Labelled(Protocol):
    """A table of pandas or xarray."""

    @property
    def attrs(self) -> Any:
        """Notes that the table carries, such as its units, by name."""


Steps = Sequence[tuple[Value, Angles]]
Signal = Angles | Steps | Callable[[float], Angles] | Array | Labelled
"""A constant, steps of (time, values), a function of time, an array of one row per control cycle, or a labelled table
(a DataFrame or Series of pandas, a DataArray of xarray) with times in its index and joints as names."""

TIME_ROUNDING = 1e-9  # by which a time may miss a control cycle, s


def expand_signal(signal: Any, kind: SignalKind, before: Array, sampling: Sampling) -> Array:
    """Return the values of a signal in every control cycle, (cycles, names), in SI units.

    Args:
        signal: see `Signal`; of arrays every row is a control cycle.
        kind: of the signal, with the names of its columns.
        before: values (names,) before the first step, and of names that are left out.
        sampling: the control cycles.

    Raises:
        InputError: naming the argument: what is given is no such signal, holds a value that is wrong, goes on after
            the end, or changes faster than the control cycles can follow.
    """
    if is_labelled(signal):
        row = labelled_row(signal, kind)
        if row is None:
            return _table(signal, kind, before, sampling)
        signal = row
    if isinstance(signal, np.ndarray) and signal.ndim > 0:
        return read_rows(signal, kind, sampling.cycles)
    if callable(signal):
        rows = _function(signal, kind, before, sampling.times)
        check_function_rate(lambda times: _function(signal, kind, before, times), rows, sampling, kind.where)
        return rows
    if is_steps(signal):
        times, values = read_steps(signal, kind, before)
        _check_ends(times, kind.where, sampling)
        return _held(times, values, before, sampling.times)
    return np.tile(read_row(signal, kind, before), (sampling.cycles, 1))


def is_steps(signal: object) -> TypeGuard[Steps]:
    """Return whether a signal is a sequence of (time, values) pairs."""
    return isinstance(signal, (list, tuple)) and len(signal) > 0 and all(
        isinstance(item, tuple) and len(item) == 2 for item in signal
    )  # fmt: skip


def read_steps(steps: Steps, kind: SignalKind, before: Array) -> tuple[Array, Array]:
    """Return the times (s) of steps and the values from then on, (steps, names); names left out keep what they had.

    Raises:
        InputError: a time or value is wrong, a time is before the start, or they do not grow.
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
    """Refuse a step that no control cycle takes."""
    if times[-1] > sampling.times[-1] + TIME_ROUNDING:
        right = f"the run ends at {sampling.end:g} s: give an earlier time, or a longer duration"
        raise InputError(f"{times[-1]:g} s is after the end", where=where, right=right)
    cycles = np.ceil((times - TIME_ROUNDING) / sampling.cycle)
    late = np.flatnonzero(np.diff(cycles) <= 0.0)
    if len(late):
        a, b = times[late[0]], times[late[0] + 1]
        what = f"its steps at {a:g} s and {b:g} s fall into one control cycle of {sampling.cycle:g} s"
        raise InputError(what, where=where, right="the first would not act: leave one out")


def _held(times: Array, values: Array, before: Array, instants: Array) -> Array:
    """Return the values that hold at instants: each from its time on."""
    which = np.searchsorted(times - TIME_ROUNDING, instants, side="right")
    rows: Array = np.concatenate([before[None], values])[which]
    return rows


def _table(signal: Any, kind: SignalKind, before: Array, sampling: Sampling) -> Array:
    """Return the values of a labelled table: each row from its time on."""
    times, values = labelled_steps(signal, kind)
    if times[-1] > sampling.end + TIME_ROUNDING:
        right = f"the run ends at {sampling.end:g} s: give a longer duration, or leave out later rows"
        raise InputError(f"its last row, at {times[-1]:g} s, is after the end", where=kind.where, right=right)
    values = np.where(np.isnan(values), before, values)
    rows = _held(times, values, before, sampling.times)
    check_table_rate(times, values, rows, sampling, kind.where)
    return rows


def _function(signal: Callable[[float], Any], kind: SignalKind, before: Array, times: Array) -> Array:
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
        array: (count, names), or (count,) where all names share a value.
        kind: of the signal.
        count: of the rows, one a control cycle.

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
        right = _shape_wanted(array, count, width)
        raise InputError(f"an array of shape {array.shape} does not fit", where=kind.where, right=right)
    if wide.dtype.kind in "UO":
        wide = np.array([read_number(value, kind.quantity, kind.where) for value in wide.ravel()]).reshape(wide.shape)
    if not np.isfinite(wide).all():
        raise InputError("holds a value that is not finite", where=kind.where, right="give numbers only")
    return np.ascontiguousarray(wide, dtype=np.float64)


def _shape_wanted(array: NDArray[Any], count: int, width: int) -> str:
    """Return words for the shape that an array should have, and for the likely mistake."""
    right = f"give shape {(count, width)}: a row for each control cycle, a column for each value in it"
    if array.shape == (width,):
        return f"{right}; or a list for one value each"
    if array.shape in {(count + 1, width), (count + 1,)}:
        return f"{right}; a run's records have one more: leave out the last"
    if array.shape == (width, count):
        return f"{right}; this one is transposed"
    return right
