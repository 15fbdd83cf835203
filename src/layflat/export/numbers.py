"""Numbers of C, each read back by a compiler to its bits; and the range of single precision."""

from collections.abc import Iterator
from math import inf, isfinite, isinf, isnan
from typing import Any

import numpy as np

from layflat.errors import InputError

MIN_SINGLE = float(np.finfo(np.float32).tiny)  # smallest number of single precision with all its digits
MAX_SINGLE = float(np.finfo(np.float32).max)


def c_number(value: float, real: str) -> str:
    """Return a number in C: the shortest decimal that is read back to the same bits in `real` ("double" or "float")."""
    if isinstance(value, int):
        return str(value)
    if isnan(value):
        return "NAN"
    if isinf(value):
        return "INFINITY" if value == inf else "-INFINITY"
    return f"{np.float32(value)!s}f" if real == "float" else repr(float(value))


def check_single(value: Any, name: str, where: str) -> None:
    """Check that single precision holds all numbers of a nested tuple.

    Args:
        value: the tuple; infinite numbers and those that are none (NaN) pass.
        name: name of the tuple, for the message.
        where: the machine's file or name, for the message.

    Raises:
        InputError: a number is too large, or so small that it loses digits.
    """
    for path, number in _named_numbers(value, name):
        if number != 0.0 and isfinite(number) and not MIN_SINGLE <= abs(number) <= MAX_SINGLE:
            raise InputError(
                f"{path} is {number:g}, out of the range of single precision",
                where=where,
                right="export in double precision",
            )


def _named_numbers(value: Any, name: str) -> Iterator[tuple[str, float]]:
    """Yield the numbers of a nested tuple with their paths."""
    if not isinstance(value, tuple):
        yield name, float(value)
        return
    labels = getattr(value, "_fields", None)
    for i, item in enumerate(value):
        yield from _named_numbers(item, f"{name}.{labels[i]}" if labels else f"{name}[{i}]")
