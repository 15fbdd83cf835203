"""What the compiler makes of a law, and of a kernel.

Laws are only ever inlined: they are compiled as far as that takes, and no machine code is made of them. The compiler
would make a library of every law, optimised to the last and ready to be called from Python. A kernel is optimised as a
whole in any case, so that this took a sixth of the time in which it is compiled.

A kernel's instructions are put in order once all else is done (see ordering.py).
"""

# mypy: disable-error-code="no-untyped-call,misc"
# The compiler's own modules are untyped.

from contextlib import suppress
from typing import Any

from llvmlite import binding
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler

from layflat.jit.calls import law_context
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


class LawCompiler(Compiler):
    """Compiles a law to what kernels inline."""

    def __init__(self, typing_context: Any, context: Any, library: Any, *rest: Any) -> None:
        own = library or _LawLibrary(context.codegen(), "law")
        super().__init__(typing_context, law_context(context), own, *rest)


class KernelCompiler(Compiler):
    """Compiles a kernel to machine code."""

    def __init__(self, typing_context: Any, context: Any, library: Any, *rest: Any) -> None:
        if library is None:
            library = _KernelLibrary(context.codegen(), "kernel")
            library.enable_object_caching()  # its machine code is kept on disk
        super().__init__(typing_context, context, library, *rest)
