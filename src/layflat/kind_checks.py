"""Checks of what the laws of a kind from outside return: its shape, its types, and that its numbers are finite.

A law is called as plain Python, whether it will be compiled or not, with numbers as they may come. What is wrong is
one line that names the law, the kind, and the file and line in which it stands.
"""

import math
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from layflat.errors import KindError
from layflat.jit import Law
from layflat.jit.outside import NO_FAILURES, first_line, place_in_kinds
from layflat.lazy import numpy as np


class MisfitError(Exception):
    """A law returned a wrong result; the text says which."""


def check_number(value: Any, what: str) -> None:
    """Raise MisfitError if a value is no finite number of Python or NumPy; a bool is none."""
    is_number = isinstance(value, (int, float, np.integer, np.floating)) and not isinstance(value, bool)
    if not is_number:
        raise MisfitError(f"{what} is {described(value)}, not a number")
    if not math.isfinite(value):
        raise MisfitError(f"{what} is {value}, not a finite number")


def check_items(value: Any, count: int, what: str) -> None:
    """Raise MisfitError if a value is not a plain tuple of a length.

    Args:
        value: result of a law.
        count: expected number of items.
        what: its name in the message.
    """
    if type(value) is not tuple:
        raise MisfitError(f"{what} is {described(value)}, not a tuple of {count}")
    if len(value) != count:
        raise MisfitError(f"{what} has {len(value)} items, not {count}")


def check_numbers(value: Any, count: int, what: str) -> None:
    """Raise MisfitError if a value is not a plain tuple of a number of finite numbers.

    Args:
        value: result of a law.
        count: expected number of items.
        what: its name in the message.
    """
    check_items(value, count, what)
    for i, item in enumerate(value):
        check_number(item, f"item {i + 1} of {what}")


def check_record(value: Any, cls: type, what: str) -> None:
    """Raise MisfitError if a value is not a named tuple of a class, of finite numbers or of tuples of these.

    Args:
        value: result of a law.
        cls: expected class.
        what: its name in the message.
    """
    if type(value) is not cls:
        raise MisfitError(f"{what} is {described(value)}, not a {cls.__name__}")
    check_nested(value, what)


def check_nested(value: Any, what: str) -> None:
    """Raise MisfitError if a value is not a nested tuple of finite numbers, or one of its tuples is empty."""
    if not isinstance(value, tuple):
        raise MisfitError(f"{what} is {described(value)}, not a named tuple of floats")
    if not value:
        raise MisfitError(f"{what} is an empty tuple, not a named tuple of one float or more")
    names = getattr(value, "_fields", None) or [f"item {i + 1}" for i in range(len(value))]
    for name, item in zip(names, value, strict=True):
        inner = f"{name} of {what}"
        if isinstance(item, tuple):
            check_nested(item, inner)
        else:
            check_number(item, inner)


def check_alike(value: Any, like: Any, what: str) -> None:
    """Raise MisfitError if a value has a tuple of another class or length than a reference, or no finite number.

    Args:
        value: result of a law.
        like: the reference, a number or a nested tuple of numbers, which are not compared.
        what: name of the value in the message.
    """
    if not isinstance(like, tuple):
        check_number(value, what)
        return
    if type(value) is not type(like):
        kind = "tuple" if type(like) is tuple else type(like).__name__
        raise MisfitError(f"{what} is {described(value)}, not a {kind} as before")
    if len(value) != len(like):
        raise MisfitError(f"{what} has {len(value)} items, not {len(like)} as before")
    names = getattr(like, "_fields", None) or [f"item {i + 1}" for i in range(len(like))]
    for name, item, before in zip(names, value, like, strict=True):
        check_alike(item, before, f"{name} of {what}")


def described(value: Any) -> str:
    """Return a short description of a value for messages, such as "a tuple of 3"."""
    if value is None:
        return "None"
    if isinstance(value, str):
        return f"the text {value[:20]!r}"
    if isinstance(value, (bool, complex, np.bool_)):
        return repr(value)
    if isinstance(value, np.ndarray):
        return "an array"
    if type(value) is tuple:
        return f"a tuple of {len(value)}"
    name = type(value).__name__
    return f"{'an' if name[0].lower() in 'aeiou' else 'a'} {name}"


@contextmanager
def naming_law(kind: str, entry: str, law: Callable[..., Any], when: str = "") -> Iterator[None]:
    """Turn an error of a law, or of its result, into one line that names the law.

    Errors of `NO_FAILURES`, and arithmetic errors of a law that will be compiled, pass unchanged.

    Args:
        kind: thing and name of the kind, such as "valve 'spool'".
        entry: the law's name in the kind.
        law: the law.
        when: text with the time of the run, such as " at 0.2 s", for the message; empty outside a run.

    Raises:
        KindError: it names the law's kind, and its file and line.
    """
    try:
        yield
    except MisfitError as error:
        raise KindError(f"`{entry}` of {kind} returns a wrong result{when}: {error}", where=place_of(law)) from None
    except NO_FAILURES:
        raise
    except BaseException as error:
        if _is_compiled_otherwise(law, error):
            raise
        what = f"`{entry}` of {kind} fails{when}: {first_line(error)}"
        raise KindError(what, where=place_in_kinds(error) or place_of(law)) from error


@contextmanager
def tolerating_arithmetic(law: Callable[..., Any]) -> Iterator[None]:
    """End the block at an arithmetic error that a law to be compiled raises as plain Python; all other errors pass.

    Compiled, 1/0 is infinite and raises nothing.
    """
    try:
        yield
    except (ArithmeticError, ValueError) as error:
        if not _is_compiled_otherwise(law, error):
            raise


def _is_compiled_otherwise(law: Callable[..., Any], error: BaseException) -> bool:
    """Return whether a law will be compiled and the error is arithmetic, so that it raises nothing once compiled."""
    of_arithmetic = isinstance(error, ArithmeticError) or str(error) == "math domain error"
    return of_arithmetic and isinstance(law, Law)


def place_of(law: Callable[..., Any]) -> str:
    """Return "file:line" of a law's definition; empty where it is unknown."""
    code = getattr(getattr(law, "py_func", law), "__code__", None)
    return f"{code.co_filename}:{code.co_firstlineno}" if code is not None else ""
