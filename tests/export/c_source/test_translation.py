"""Small laws in C, with the numbers of Python: operations in their order, and the corners of each."""

# mypy: disable-error-code="no-untyped-def"
# Laws are untyped.

import math
import re
import struct
from collections.abc import Callable
from math import copysign, floor, isnan, sqrt
from pathlib import Path
from typing import Any, NamedTuple

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numba import njit

from layflat.export.c_source.c_types import REAL_TYPE
from layflat.jit import composition, law
from layflat.lanes import abreast, apart, each, gather, halves, join, select, slots, sums_from, sums_up_to, total
from tests.export.c_source.programs import compiled, translated

OFFSET = 0.75  # of the sum, 1
COUNT = 3


class Point(NamedTuple):
    """A point."""

    x: float
    y: float


@law
def associations(a, b, c):
    return a - (b - c) + a / (b * c) * (a - -b) - (a + b) * (c - 2) / 3


@law
def extremes(a, b, c):
    return min(a, b, c) + 2.0 * max(a, b, c - a, -c)


@law
def zeros(a, b, c):
    return copysign(1.0, min(a, b)) + 3.0 * copysign(1.0, max(b, c)) + 5.0 * copysign(1.0, a - floor(c))


@law
def conditions(a, b, c):
    inside = (a < b) & (b <= c) | (a == c)
    ordered = a < b < c and not isnan(c)
    return select(inside, 1.0, 0.0) + (2.0 if ordered else 4.0) + 8.0 * (a > b)


@law
def powers(a, b, c):
    return a**2 + (a + b) ** 3 - c**5


@law
def _both(a, b):
    return a + b, a * b


@law
def results(a, b, c):
    s, p = _both(a, b)
    p, s = s * c, p - c
    return s - p


@law
def loops(a, b, c):
    first, second = a, b
    for i in range(COUNT):
        first, second = second, first * c + i
        if first > 10.0:
            first = OFFSET - first
            break
    n = 0
    while n < 4 and second < 5.0:
        second = second + 0.5 * n
        n += 1
    return first - second


@law
def _scaled(x, point):
    return x * point.x + point.y


@composition
def tuples(a, b, c):
    x = slots((a, b, c))
    for i in range(1, len(x)):
        for j in range(i):
            x[i], x[j] = x[j] - x[i], x[i] + (i + j) % 2 - (i - 3) // 2
    scaled = each(_scaled, gather((a, b, c), x), Point(b, c))
    point = Point(scaled[0], total(scaled))
    return point.x - point.y + (a, b)[-1]


@law
def _squared(a):
    return a * a + 1.0


@composition
def side_by_side(a, b, c):
    first, second = halves(_squared(join(a, b)) - c)
    return first / (1.0 + abs(second)) + sqrt(abs(first))


@law
def branches(a, b, c):
    if a > b:
        if c > 0.0:
            return a
        found = b
    elif a < b:
        found = c
    else:
        found = a + b
    return found * 2.0


@composition
def _double_first(items, changed):
    for i in range(len(items)):
        changed[i] = 2.0 * items[i]


@composition
def changes(a, b, c):
    kept, copied, alone = slots((a, b, c)), slots((a, b, c)), slots((c,))
    _double_first(kept, copied)
    _double_first(copied, slots(kept))
    _double_first(slots(kept), kept)
    _double_first(alone, alone)
    return kept[0] - copied[1] * copied[2] + alone[0]


@law
def _pointed(a, b):
    return Point(a * b, a - b)


@composition
def running_sums(a, b, c):
    like = a, b, c
    sums = sums_from(sums_up_to(_pointed(abreast(like), c), like), like)
    return apart(sums.x, like)[1] - apart(sums.y, like)[0] * apart(_pointed(abreast(like), b).y, like)[2]


LAWS = [
    *(associations, extremes, zeros, conditions, powers, results, loops),
    *(tuples, side_by_side, running_sums, branches, changes),
]
numbers = st.floats(allow_nan=False, allow_infinity=False, min_value=-1e3, max_value=1e3) | st.sampled_from(
    [0.0, -0.0, 1.0, -1.0, 0.5]
)


@pytest.fixture(scope="module", params=LAWS, ids=[one.__name__ for one in LAWS])
def pair(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> tuple[Any, Callable[..., float]]:
    folder: Path = tmp_path_factory.mktemp("law")
    # Python's own power rounds once, the compiler's in each product.
    reference = njit(powers.__wrapped__) if request.param is powers else request.param
    return reference, compiled(request.param, [REAL_TYPE] * 3, folder)


@settings(max_examples=150, deadline=None)
@given(numbers, numbers, numbers)
def test_c_computes_what_python_does(pair: tuple[Any, Callable[..., float]], a: float, b: float, c: float) -> None:
    python, c_function = pair
    try:
        expected = float(python(a, b, c))
    except (ZeroDivisionError, OverflowError):  # C goes on with infinity
        return
    assert struct.pack("d", c_function(a, b, c)) == struct.pack("d", expected)


def test_a_function_is_called_once_for_all_parts_of_its_result() -> None:
    _, function = translated(running_sums, [REAL_TYPE] * 3)
    calls = re.findall(r"pointed\(.*?\)", " ".join(line.text for line in function.lines))
    assert len(calls) == len({*calls}) == 4  # results that nothing reads are left out


def test_the_first_of_min_and_max_wins_against_nan(tmp_path: Path) -> None:
    c_function = compiled(extremes, [REAL_TYPE] * 3, tmp_path)
    for args in [(math.nan, 1.0, 2.0), (1.0, math.nan, 2.0), (1.0, 2.0, math.nan)]:
        python = extremes(*args)
        assert struct.pack("d", c_function(*args)) == struct.pack("d", python) or math.isnan(python)
