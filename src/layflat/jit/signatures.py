"""Arguments of portable kernels: their types as a text, and their numbers as words of memory.

A word has eight bytes: a float, an integer, the address of an array, or its size along an axis. Nested tuples are taken
apart; a `Like` is constant and has no words.
"""

from collections.abc import Iterator
from typing import Any

from layflat.lanes import Like
from layflat.lazy import numpy as np


class UnportableError(TypeError):
    """Argument that has no words: neither array, number, `Like` nor a tuple of these."""


def signature_text(args: tuple[Any, ...]) -> str:
    """Return the types of arguments as a text: equal texts mean the same machine code.

    Raises:
        UnportableError: an argument has no words, or an array is not contiguous in C's order.
    """
    return ",".join(map(_type_text, args))


def _type_text(arg: Any) -> str:
    """Return the type of an argument as a text; raise UnportableError as `signature_text` does."""
    if isinstance(arg, np.ndarray):
        if not arg.flags.c_contiguous:
            raise UnportableError("an array's items are not in C's order")
        return f"{arg.dtype.str}{arg.ndim}"
    if isinstance(arg, float):
        return "f"
    if isinstance(arg, int | np.integer):
        return "i"
    if isinstance(arg, tuple):
        return f"{_class_text(type(arg))}({signature_text(arg)})"
    if isinstance(arg, Like):
        return f"Like[{arg.text}]"
    raise UnportableError(f"{type(arg).__name__} is neither array, number, Like nor tuple")


def _class_text(kind: type) -> str:
    return "" if kind is tuple else f"{kind.__module__}.{kind.__qualname__}"


def words(args: tuple[Any, ...]) -> Iterator[int | float]:
    """Yield the value of every word; arrays have to outlive the use of their addresses."""
    for arg in args:
        if isinstance(arg, np.ndarray):
            yield arg.__array_interface__["data"][0]
            yield from arg.shape
        elif isinstance(arg, tuple):
            yield from words(arg)
        elif not isinstance(arg, Like):
            yield float(arg) if isinstance(arg, float) else int(arg)
