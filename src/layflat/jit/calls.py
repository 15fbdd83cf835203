"""How laws are called, and what they count of what they hand on.

Laws are handed named tuples as they are, and hand on what refers to nothing without a look at all that is in it. The
compiler would hand over each of their numbers, often hundreds, as an argument of its own, and look in each for what it
refers to, to count who does. Both together took a seventh of the time in which four joints in space with the tracking
law are compiled.
"""

# mypy: disable-error-code="no-untyped-call,misc"
# The compiler's own modules are untyped.

from copy import copy
from typing import Any
from weakref import WeakKeyDictionary

from numba.core.cpu import CPUContext
from numba.core.datamodel.packer import ArgPacker
from numba.core.imputils import user_function
from numba.core.runtime.context import NRTContext
from numba.core.types import BaseNamedTuple


class _AsItIs:
    """A named tuple as an argument."""

    def __init__(self, model: Any) -> None:
        self.get_argument_type = model.get_value_type

    def as_argument(self, builder: Any, value: Any) -> Any:  # noqa: ARG002
        return value

    from_argument = as_argument


class _Models:
    """How arguments are handed to a law, by their types."""

    def __init__(self, models: Any) -> None:
        self._models = models

    def lookup(self, kind: Any) -> Any:
        model = self._models.lookup(kind)
        return _AsItIs(model) if isinstance(kind, BaseNamedTuple) else model


_refers: WeakKeyDictionary[Any, bool] = WeakKeyDictionary()


class _References(NRTContext):
    """What counts references."""

    def get_meminfos(self, builder: Any, kind: Any, value: Any) -> Any:
        if kind not in _refers:
            _refers[kind] = self._context.data_model_manager[kind].contains_nrt_meminfo()
        return super().get_meminfos(builder, kind, value) if _refers[kind] else ()


_sizes: dict[str, int] = {}


class _LawContext(CPUContext):
    """How a law is compiled and called; all that it calls itself is called as that was compiled."""

    @property
    def nrt(self) -> Any:
        return _References(self, self.enable_nrt)

    def get_abi_sizeof(self, kind: Any) -> Any:
        # To ask LLVM is to wait until it has done what it is at.
        name = str(kind)
        if name not in _sizes:
            _sizes[name] = super().get_abi_sizeof(kind)
        return _sizes[name]

    def get_arg_packer(self, kinds: Any) -> Any:
        return ArgPacker(_Models(self.data_model_manager), kinds)

    def get_function(self, *called: Any) -> Any:
        return _as_kind(CPUContext, self).get_function(*called)

    def insert_user_function(self, function: Any, described: Any, libraries: Any = ()) -> None:
        call = user_function(described, libraries)

        def called(context: Any, *rest: Any) -> Any:
            return call(law_context(context), *rest)

        called.signature, called.libs = call.signature, call.libs  # type: ignore[attr-defined]
        self._defns[function].append(called, called.signature)  # type: ignore[attr-defined]


def law_context(context: Any) -> Any:
    """The compiler's context, as it is for laws."""
    return _as_kind(_LawContext, context)


def _as_kind(kind: type, context: Any) -> Any:
    other = copy(context)
    other.__class__ = kind
    return other
