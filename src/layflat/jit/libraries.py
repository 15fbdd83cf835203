"""What the compiler makes of a law, and of a kernel.

Laws are only ever inlined: they are compiled as far as that takes, and no machine code is made of them. The compiler
would make a library of every law, optimised to the last and ready to be called from Python. A kernel is optimised as a
whole in any case, so that this took a sixth of the time in which it is compiled.

Laws are handed named tuples as they are, and hand on what refers to nothing without a look at all that is in it. The
compiler would hand over each of their numbers, often hundreds, as an argument of its own, and look in each for what it
refers to, to count who does; both together took a seventh of the time.

A kernel's instructions are put in order once all else is done (see ordering.py).
"""

# mypy: disable-error-code="no-untyped-call,misc"
# The compiler's own modules are untyped.

from contextlib import suppress
from copy import copy
from typing import Any
from weakref import WeakKeyDictionary

from llvmlite import binding
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler
from numba.core.cpu import CPUContext
from numba.core.datamodel.packer import ArgPacker
from numba.core.imputils import user_function
from numba.core.runtime.context import NRTContext
from numba.core.types import BaseNamedTuple

from layflat.jit.ordering import ordered


class _Nowhere:
    """What keeps the environments of machine code, where there is none."""

    def set_env(self, name: str, env: Any) -> None:
        """Keep nothing."""


class _LawLibrary(JITCodeLibrary):
    @property
    def codegen(self) -> _Nowhere:
        return _Nowhere()

    def _optimize_final_module(self) -> None:
        # As much as keeps what is inlined small.
        passes, builder = self._codegen._module_pass_manager(opt=1, loop_vectorize=False, slp_vectorize=False)
        passes.run(self._final_module, builder)

    def _finalize_final_module(self) -> None:
        self._finalize_dynamic_globals()
        self._finalized = True


class _KernelLibrary(JITCodeLibrary):
    def _optimize_final_module(self) -> None:
        super()._optimize_final_module()
        name, text = self._final_module.name, str(self._final_module)
        in_order = ordered(text)
        if in_order == text:
            return
        # Text that LLVM can't read again is no loss but of speed.
        with suppress(RuntimeError):
            self._final_module = binding.parse_assembly(in_order)
            self._final_module.name = name


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


class _LawContext(CPUContext):
    """How a law is compiled and called; all that it calls itself is called as that was compiled."""

    @property
    def nrt(self) -> Any:
        return _References(self, self.enable_nrt)

    def get_arg_packer(self, kinds: Any) -> Any:
        return ArgPacker(_Models(self.data_model_manager), kinds)

    def get_function(self, *called: Any) -> Any:
        return _as_kind(CPUContext, self).get_function(*called)

    def insert_user_function(self, function: Any, described: Any, libraries: Any = ()) -> None:
        call = user_function(described, libraries)

        def called(context: Any, *rest: Any) -> Any:
            return call(_as_kind(_LawContext, context), *rest)

        called.signature, called.libs = call.signature, call.libs  # type: ignore[attr-defined]
        self._defns[function].append(called, called.signature)  # type: ignore[attr-defined]


def _as_kind(kind: type, context: Any) -> Any:
    other = copy(context)
    other.__class__ = kind
    return other


class LawCompiler(Compiler):
    """Compiles a law to what kernels inline."""

    def __init__(self, typing_context: Any, context: Any, library: Any, *rest: Any) -> None:
        own = library or _LawLibrary(context.codegen(), "law")
        super().__init__(typing_context, _as_kind(_LawContext, context), own, *rest)


class KernelCompiler(Compiler):
    """Compiles a kernel to machine code."""

    def __init__(self, typing_context: Any, context: Any, library: Any, *rest: Any) -> None:
        if library is None:
            library = _KernelLibrary(context.codegen(), "kernel")
            library.enable_object_caching()  # its machine code is kept on disk
        super().__init__(typing_context, context, library, *rest)
