"""Signals that change faster than they are read: what lies between two readings would be lost without a word.

A signal that is read often enough lies, between two readings, between their values, or little beyond them. One whose
period is shorter than two readings does not.
"""

from collections.abc import Callable

import numpy as np

from layflat.arrays import Array
from layflat.errors import InputError
from layflat.motion.signal_values import Sampling

MAX_TRIED = 2000  # control cycles in which a function is evaluated once more
GOLDEN = 0.6180339887498949  # fractions of cycles that never repeat
MAX_EXCESS = 0.4
"""Excess beyond the readings around, rms over the standard deviation: 0.42 or more of sines and square waves of less
than two readings a period, 0.39 or less of others."""
MAX_EXCESS_OF_CHANGE = 0.23  # the same over the rms change from reading to reading: of a ripple on a slow motion
ROUNDING = 1e-9  # of the largest value


def check_function_rate(function: Callable[[Array], Array], rows: Array, sampling: Sampling, where: str) -> None:
    """Refuse a function of time that changes too fast for the control cycles.

    Args:
        function: from times (s) to values, (times, names).
        rows: its values in the control cycles, (cycles, names).
        sampling: the control cycles.
        where: the argument in messages.

    Raises:
        InputError: naming `where`: what happens between the control cycles would be lost.
    """
    if sampling.cycles < 3:
        return
    first = np.unique(np.linspace(0, sampling.cycles - 2, min(MAX_TRIED, sampling.cycles - 1)).astype(int))
    fraction = np.modf(GOLDEN * (first + 1))[0]
    between = function(sampling.cycle * (first + fraction))
    _refuse(between, rows[first], rows[first + 1], sampling, where)


def check_table_rate(times: Array, values: Array, rows: Array, sampling: Sampling, where: str) -> None:
    """Refuse a table whose rows between the control cycles go elsewhere than those in them.

    Args:
        times: of the rows, s.
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
    _refuse(values[inside], rows[first], rows[first + 1], sampling, where)


def _refuse(between: Array, before: Array, after: Array, sampling: Sampling, where: str) -> None:
    low, high = np.minimum(before, after), np.maximum(before, after)
    excess = np.sqrt(np.mean(np.maximum(0.0, np.maximum(between - high, low - between)) ** 2, axis=0))
    deviation = np.std(np.concatenate([between, before]), axis=0)
    change = np.sqrt(np.mean((after - before) ** 2, axis=0))
    large = excess > ROUNDING * np.abs(between).max()
    if np.any(large & ((excess > MAX_EXCESS * deviation) | (excess > MAX_EXCESS_OF_CHANGE * change))):
        what = f"changes faster than control cycles of {1e3 * sampling.cycle:g} ms can follow"
        right = f"give periods of {2e3 * sampling.cycle:g} ms or more, or an array with a row for each cycle"
        raise InputError(what, where=where, right=right)
