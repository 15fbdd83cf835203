"""Libraries of compiled laws and kernels, and the calling convention of laws.

Laws are only ever inlined: they are compiled as far as inlining needs, without machine code. Numba would make a library
of every law, fully optimised and callable from Python. A kernel is optimised as a whole in any case, so that this took
a sixth of its compile time.

Laws get named tuples as whole arguments, and tuples without references are passed on without inspection. Numba would
pass each of their numbers, often hundreds, as an argument of its own, and inspect each for references to count. Both
together took a seventh of the compile time of four joints in space with the tracking law.

A kernel's instructions are reordered at the end (see ordering.py).
"""

# mypy: disable-error-code="no-untyped-call,misc"
# The compiler's own modules are untyped.

from contextlib import suppress
from copy import copy
from functools import cache
from typing import Any, cast
from weakref import WeakKeyDictionary

from llvmlite import binding, ir
from numba import types
from numba.core.cgutils import normalize_ir_text

from layflat.jit.compile_session import LlvmWork
from layflat.jit.internals import (
    ArgPacker,
    Compiler,
    CPUCodeLibrary,
    CPUContext,
    JITCodeLibrary,
    NRTContext,
    user_function,
)
from layflat.jit.ordering import order_instructions


class _WholeTuple:
    """Argument model of a named tuple that is not flattened."""

    def __init__(self, model: Any) -> None:
        self.get_argument_type = model.get_value_type

    def as_argument(self, builder: Any, value: Any) -> Any:  # noqa: ARG002
        return value

    from_argument = as_argument


class _ArgumentModels:
    """Data models of a law's arguments, by their types."""

    def __init__(self, models: Any) -> None:
        self._models = models

    def lookup(self, kind: Any) -> Any:
        model = self._models.lookup(kind)
        return _WholeTuple(model) if isinstance(kind, types.BaseNamedTuple) else model


_holds_references: WeakKeyDictionary[Any, bool] = WeakKeyDictionary()


class _References(NRTContext):
    """Reference counting."""

    def get_meminfos(self, builder: Any, kind: Any, value: Any) -> Any:  # language: numba's interface
        """Return the references in a value; none, without emitting code, for a type that is known to hold none."""
        if kind not in _holds_references:
            _holds_references[kind] = self._context.data_model_manager[kind].contains_nrt_meminfo()
        return super().get_meminfos(builder, kind, value) if _holds_references[kind] else ()


class _LawContext(CPUContext):
    """Context in which a law is compiled and called; its own calls use the conventions of the callees."""

    @property
    def nrt(self) -> Any:
        return _References(self, self.enable_nrt)

    def get_arg_packer(self, kinds: Any) -> Any:
        return ArgPacker(_ArgumentModels(self.data_model_manager), kinds)

    def get_function(self, *called: Any) -> Any:
        return _copy_as(CPUContext, self).get_function(*called)

    def insert_user_function(self, function: Any, described: Any, libraries: Any = ()) -> None:  # language: numba's
        """Register a law for other laws, which call it in the context of laws."""
        call = user_function(described, libraries)

        def called(context: Any, *rest: Any) -> Any:
            return call(law_context(context), *rest)

        called.signature, called.libs = call.signature, call.libs  # type: ignore[attr-defined]
        self._defns[function].append(called, called.signature)  # type: ignore[attr-defined]


def law_context(context: Any) -> Any:
    """Return a copy of numba's target context with the calling convention of laws."""
    return _copy_as(_LawContext, context)


def _copy_as(kind: type, context: Any) -> Any:
    """Return a shallow copy of a context as an instance of another class."""
    other = copy(context)
    other.__class__ = kind
    return other


@cache
def _triple() -> str:
    triple: str = binding.get_process_triple()
    return triple


def _parse_module(name: str, text: str) -> Any:
    """Return LLVM's text parsed as a module of this name; raise RuntimeError if it is invalid."""
    module = binding.parse_assembly(text)
    module.name = name
    return module


class NoEnvironments:
    """Registry of environments of machine code that stores nothing."""

    def set_env(self, name: str, env: Any) -> None:
        """Do nothing."""


class _LawLibrary(JITCodeLibrary):
    """Library of a law whose LLVM work runs in a thread (see compile_session.py); access to the result waits."""

    def __init__(self, codegen: Any, name: str) -> None:
        # As the base class, without the empty module that it begins with: a law has its own.
        super(CPUCodeLibrary, self).__init__(codegen, name)
        self._linking_libraries: list[Any] = []
        self._shared_module = None
        self._work, self._module = LlvmWork(), cast("Any", None)

    @property
    def codegen(self) -> NoEnvironments:
        return NoEnvironments()

    @property
    def _final_module(self) -> Any:
        self._work.wait()
        return self._module

    @_final_module.setter
    def _final_module(self, module: Any) -> None:
        self._module = module

    def create_ir_module(self, name: str) -> Any:
        """Return an empty module for this computer's processor."""
        module: Any = ir.Module(normalize_ir_text(name))
        module.triple, module.data_layout = _triple(), self._codegen._data_layout
        return module

    def add_ir_module(self, ir_module: Any) -> None:
        self._work.add(self._add_module, ir_module.name, normalize_ir_text(str(ir_module)))

    def finalize(self) -> None:
        """End the collection of code; the thread links and optimises the rest."""
        for library in self._linking_libraries:
            self._reload_init.update(library._reload_init)
        self._finalized = True
        self._work.add(self._link_and_optimize)

    def _add_module(self, name: str, text: str) -> None:
        """Parse, verify and optimise a module's text, and link it into that of the library."""
        module = _parse_module(name, text)
        module.verify()
        self._optimize_functions(module)
        if self._module is None:
            self._module = module
        else:
            self._module.link_in(module)

    def _link_and_optimize(self) -> None:
        """Link the modules of the called laws and optimise the result, such that inlined code stays small."""
        for library in dict.fromkeys(self._linking_libraries):
            self._module.link_in(library._get_module_for_linking(), preserve=True)
        # Optimisation that keeps inlined code small.
        passes, builder = self._codegen._module_pass_manager(opt=1, loop_vectorize=False, slp_vectorize=False)
        passes.run(self._module, builder)
        self._module.verify()
        self._finalize_dynamic_globals()


class _KernelLibrary(JITCodeLibrary):
    """Library of a kernel, whose instructions are scheduled after the optimisation."""

    def _optimize_final_module(self) -> None:
        """Optimise the module and put its instructions in order; if LLVM can't parse these, only speed is lost."""
        super()._optimize_final_module()
        name, text = self._final_module.name, str(self._final_module)
        in_order = order_instructions(text)
        if in_order == text:
            return
        # If LLVM can't parse the text, only speed is lost.
        with suppress(RuntimeError):
            self._final_module = _parse_module(name, in_order)


class LawCompiler(Compiler):
    """Compiler of laws, to code that kernels inline."""

    def __init__(self, typing_context: Any, context: Any, library: Any, *rest: Any) -> None:
        law_library = library or _LawLibrary(context.codegen(), "law")
        super().__init__(typing_context, law_context(context), law_library, *rest)


class KernelCompiler(Compiler):
    """Compiler of kernels, to machine code."""

    def __init__(self, typing_context: Any, context: Any, library: Any, *rest: Any) -> None:
        if library is None:
            library = _KernelLibrary(context.codegen(), "kernel")
            library.enable_object_caching()  # its machine code is kept on disk
        super().__init__(typing_context, context, library, *rest)
