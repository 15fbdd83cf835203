"""Small portable code: long laws that are called in several places stay functions, and no bit changes."""

import ctypes

import numpy as np
from numba import types

from layflat.jit import law
from layflat.jit.objects import code_size, host, load, machine_code
from layflat.jit.portable import c_function
from layflat.lanes import select

CALLS = 6


@law
def once(x):  # type: ignore[no-untyped-def]
    return select(x > 0.5, 1.5 * x * (1.0 - x), x - x * x / 3.0)


@law
def four_times(x):  # type: ignore[no-untyped-def]
    return once(once(once(once(x))))


@law
def long(x):  # type: ignore[no-untyped-def]
    y = four_times(four_times(four_times(four_times(x))))
    return four_times(four_times(four_times(four_times(y)))) + y


def entry(numbers):  # type: ignore[no-untyped-def]
    x = numbers[0]
    numbers[1] = long(x)
    numbers[2] = long(x + 0.1)
    numbers[3] = long(x + 0.2)
    numbers[4] = long(x + 0.3)
    numbers[5] = long(x + 0.4)
    numbers[6] = long(x + 0.5)


def test_small_code_has_the_same_bits_in_less_space() -> None:
    sizes, results = [], []
    for small in (False, True, False):
        text = c_function("f", entry, (types.CPointer(types.float64),), "ptr %a", "ptr %a", small=small)
        code = machine_code(text, ("f",), host(), ordered=False)
        numbers = np.array([0.3, *[0.0] * CALLS])
        load(code, "f", (ctypes.c_void_p,))(numbers.ctypes.data)
        sizes.append(code_size(code))
        results.append(numbers)
    assert sizes[1] < 0.4 * sizes[0]
    assert sizes[2] == sizes[0]  # what is compiled later inlines again
    assert np.array_equal(results[1], results[0])
    assert results[0][1:].tolist() == [long(0.3 + shift) for shift in (0.0, 0.1, 0.2, 0.3, 0.4, 0.5)]
    assert len({*results[0][1:].tolist()}) == CALLS
