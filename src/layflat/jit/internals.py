"""Undocumented parts of numba and llvmlite that are used here.

docs/compiler.md states for each its purpose, gain and replacement.
"""

# mypy: disable-error-code="attr-defined,no-untyped-call"
# The compiler's own modules are untyped.

from collections.abc import Callable, Iterable
from contextlib import suppress
from typing import Any

from llvmlite.binding import ffi
from numba import types
from numba.core.codegen import CPUCodeLibrary, JITCodeLibrary
from numba.core.compiler import Compiler
from numba.core.cpu import CPUContext
from numba.core.datamodel.packer import ArgPacker
from numba.core.imputils import lower_constant, user_function
from numba.core.runtime.context import NRTContext
from numba.core.typing import Context
from numba.core.typing.templates import AbstractTemplate, infer_global

__all__ = [
    "ArgPacker",
    "CPUCodeLibrary",
    "CPUContext",
    "Compiler",
    "JITCodeLibrary",
    "NRTContext",
    "ffi",
    "is_for_host",
    "lower_constant",
    "register_typing",
    "tolerate_failed_save",
    "user_function",
]


def tolerate_failed_save(dispatcher: Any) -> Any:
    """Make a compiled function ignore that its machine code can't be saved, as on a full disk; return it."""
    save = dispatcher._cache.save_overload

    def save_where_possible(*args: Any) -> None:
        with suppress(OSError):
            save(*args)

    dispatcher._cache.save_overload = save_where_possible
    return dispatcher


def is_for_host(context: Any) -> bool:
    """Return whether a typing or target context of numba is that of this computer's processor."""
    return isinstance(context, (Context, CPUContext))


def register_typing(functions: Iterable[Any], rule: Callable[..., Any], in_context: bool = False) -> None:
    """Register a typing rule of calls.

    Args:
        functions: called functions.
        rule: returns, for the types of the arguments, that of the result, a signature where arguments are converted
            first, or None where it does not apply.
        in_context: whether the rule takes the typing context before the arguments.
    """
    for function in functions:

        class CallTyping(AbstractTemplate):
            key = function

            def generic(self, args: Any, kws: Any) -> Any:  # noqa: ARG002  (the compiler's own interface)
                result = rule(self.context, *args) if in_context else rule(*args)
                return result(*args) if isinstance(result, types.Type) else result

        infer_global(function)(CallTyping)
