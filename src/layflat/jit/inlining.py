"""Choice whether kernels inline the laws that they call, which is fast, or call them, which is small."""

from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar

LAWS_INLINED = ContextVar("laws_inlined", default=True)
"""Choice of the code that is being compiled: true where laws are inlined."""


@contextmanager
def laws_as_functions() -> Iterator[None]:
    """Compile laws within as functions that are called, not inlined, for code that is to be small (see `portable`)."""
    token = LAWS_INLINED.set(False)
    try:
        yield
    finally:
        LAWS_INLINED.reset(token)
