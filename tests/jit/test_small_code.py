"""Small portable code: long laws that are called in several places stay functions, laws of items get all in lanes.

No bit changes.
"""

import ctypes
from typing import NamedTuple

import numpy as np
from numba import carray, types  # type: ignore[attr-defined]

from layflat.jit import composition, law
from layflat.jit.objects import code_size, host, load, machine_code
from layflat.jit.portable import c_function
from layflat.lanes import Like, each, read_numbers, select

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


class Share(NamedTuple):
    """Named tuple of two numbers."""

    of: float
    rest: float


@law
def parted(share, x, shared):  # type: ignore[no-untyped-def]
    """Return a named tuple, a truth, and a number that is the same for all."""
    y = max(four_times(x) * share.of - shared.rest, share.rest)
    return Share(y, x / share.of), (y > 0.2) & (x < shared.of), 7.0


@law
def branched(x, truth):  # type: ignore[no-untyped-def]
    """Return a number by a branch, which lanes do not take."""
    if truth:
        return 2.0 * x
    return -x


@composition
def of_items(shares, numbers, shared):  # type: ignore[no-untyped-def]
    after, truths, same = each(parted, shares, numbers, shared)
    return after, each(branched, numbers, truths), same


def entry_of_items(numbers):  # type: ignore[no-untyped-def]
    xs = numbers[0], numbers[1], numbers[2]
    shares = (Share(xs[0], 0.25), Share(xs[1], xs[2]), Share(0.75, -xs[0]))
    after, signed, same = of_items(shares, xs, Share(0.5, 0.125))
    for j in range(3):
        numbers[j + 3], numbers[j + 6], numbers[j + 9] = after[j].of, after[j].rest, signed[j]
    numbers[12] = same[0] + same[1] + same[2]


def test_items_in_lanes_have_the_same_bits_in_less_space() -> None:
    sizes, results = [], []
    for small in (False, True):
        text = c_function("f", entry_of_items, (types.CPointer(types.float64),), "ptr %a", "ptr %a", small=small)
        code = machine_code(text, ("f",), host(), ordered=False)
        numbers = np.array([0.3, 0.8, 0.45, *[0.0] * 10])
        load(code, "f", (ctypes.c_void_p,))(numbers.ctypes.data)
        sizes.append(code_size(code))
        results.append(numbers)
    assert sizes[1] < 0.8 * sizes[0]
    assert np.array_equal(results[1], results[0])
    alone = np.array([0.3, 0.8, 0.45, *[0.0] * 10])
    entry_of_items(alone)
    assert np.array_equal(alone, results[0])


class Model(NamedTuple):
    """Numbers that a law gets by their address in small code."""

    shares: tuple[Share, Share]
    numbers: tuple[float, ...]


@law
def modelled(model, x):  # type: ignore[no-untyped-def]
    """Return a number that depends on all numbers of a model."""
    y = four_times(four_times(x)) * model.shares[0].of - model.shares[1].rest
    for number in model.numbers:
        y = four_times(y * number)
    return four_times(y + model.shares[0].rest * model.shares[1].of)


@law
def modelled_twice(model, x):  # type: ignore[no-untyped-def]
    """Return a number by two calls: the second is with another model, whose numbers are computed."""
    y = modelled(model, x)
    return y + modelled(Model((model.shares[0], Share(y, x)), model.numbers), x - 0.5 * y)


MODEL_NUMBERS = 24
MODEL = Model((Share(0.0, 0.0),) * 2, (0.0,) * (MODEL_NUMBERS - 4))


def entry_of_models(constants, numbers):  # type: ignore[no-untyped-def]
    model = read_numbers(MODEL_LIKE, carray(constants, (MODEL_NUMBERS,)))
    numbers[0] = modelled_twice(model, 0.3)
    numbers[1] = modelled_twice(model, numbers[0])


MODEL_LIKE = Like.from_tuple(MODEL)


def test_laws_get_the_address_of_constants() -> None:
    sizes, results = [], []
    for small, constant in ((False, ""), (True, ""), (True, "noalias readonly ")):
        pointers = (types.CPointer(types.float64),) * 2
        taken = f"ptr {constant}%a, ptr %b"
        text = c_function("f", entry_of_models, pointers, taken, "ptr %a, ptr %b", small=small)
        code = machine_code(text, ("f",), host(), ordered=False)
        constants, numbers = np.linspace(0.1, 0.9, MODEL_NUMBERS), np.zeros(2)
        load(code, "f", (ctypes.c_void_p,) * 2)(constants.ctypes.data, numbers.ctypes.data)
        sizes.append(code_size(code))
        results.append(numbers.tolist())
    assert results[1] == results[2] == results[0]
    assert sizes[2] < sizes[1] < sizes[0]


def test_numbers_that_may_change_are_copied() -> None:
    """A model that lies where the results go is read before they are written."""
    results = []
    for small in (False, True):
        pointers = (types.CPointer(types.float64),) * 2
        text = c_function("f", entry_of_models, pointers, "ptr %a, ptr %b", "ptr %a, ptr %b", small=small)
        code = machine_code(text, ("f",), host(), ordered=False)
        numbers = np.linspace(0.1, 0.9, MODEL_NUMBERS)
        load(code, "f", (ctypes.c_void_p,) * 2)(numbers.ctypes.data, numbers.ctypes.data)
        results.append(numbers.tolist())
    assert results[1] == results[0]
