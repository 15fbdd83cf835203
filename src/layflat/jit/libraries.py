"""Compiled laws and kernels: what is made of each, and how laws are called.

Laws are only ever inlined: they are compiled as far as that takes, and no machine code is made of them. The compiler
would make a library of every law, optimised to the last and ready to be called from Python. A kernel is optimised as a
whole in any case, so that this took a sixth of the time in which it is compiled.

Laws are handed named tuples as they are, and hand on what refers to nothing without a look at all that is in it. The
compiler would hand over each of their numbers, often hundreds, as an argument of its own, and look in each for what it
refers to, to count who does. Both together took a seventh of the time in which four joints in space with the tracking
law are compiled.

A kernel's instructions are put in order once all else is done (see ordering.py).
"""

# mypy: disable-error-code="no-untyped-call,misc"
# The compiler's own modules are untyped.

from contextlib import suppress
from copy import copy
from functools import cache
from typing import Any, cast
from weakref import WeakKeyDictionary

from llvmlite import binding, ir
from numba.core.cgutils import normalize_ir_text
from numba.core.codegen import CPUCodeLibrary, JITCodeLibrary
from numba.core.compiler import Compiler
from numba.core.cpu import CPUContext
from numba.core.datamodel.packer import ArgPacker
from numba.core.imputils import user_function
from numba.core.runtime.context import NRTContext
from numba.core.types import BaseNamedTuple

from layflat.jit.meanwhile import Work
from layflat.jit.ordering import ordered


class _AsItIs:
    """A named tuple as an argument."""

    def __init__(self, model: Any) -> None:
        self.get_argument_type = model.get_value_type

    def as_argument(self, builder: Any, value: Any) -> Any:  # noqa: ARG002
        return value

    from_argument = as_argument


class _Models:
    """Models by which arguments are handed to a law, by their types."""

    def __init__(self, models: Any) -> None:
        self._models = models

    def lookup(self, kind: Any) -> Any:
        model = self._models.lookup(kind)
        return _AsItIs(model) if isinstance(kind, BaseNamedTuple) else model


_refers: WeakKeyDictionary[Any, bool] = WeakKeyDictionary()


class _References(NRTContext):
    """Counting of references."""

    def get_meminfos(self, builder: Any, kind: Any, value: Any) -> Any:
        if kind not in _refers:
            _refers[kind] = self._context.data_model_manager[kind].contains_nrt_meminfo()
        return super().get_meminfos(builder, kind, value) if _refers[kind] else ()


_sizes: dict[str, int] = {}


class _LawContext(CPUContext):
    """Context in which a law is compiled and called; all that it calls itself is called as that was compiled."""

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


@cache
def _triple() -> str:
    triple: str = binding.get_process_triple()
    return triple


def _parsed(name: str, text: str) -> Any:
    module = binding.parse_assembly(text)
    module.name = name
    return module


class _Nowhere:
    """Keeper of the environments of machine code, where there is none."""

    def set_env(self, name: str, env: Any) -> None:
        """Keep nothing."""


class _LawLibrary(JITCodeLibrary):
    """LLVM does all of its work later (see meanwhile.py): who asks for what came of it waits."""

    def __init__(self, codegen: Any, name: str) -> None:
        # As all libraries, but for the empty module that a processor's begin with: a law has one of its own.
        super(CPUCodeLibrary, self).__init__(codegen, name)
        self._linking_libraries: list[Any] = []
        self._shared_module = None
        self._work, self._module = Work(), cast("Any", None)

    @property
    def codegen(self) -> _Nowhere:
        return _Nowhere()

    @property
    def _final_module(self) -> Any:
        self._work.wait()
        return self._module

    @_final_module.setter
    def _final_module(self, module: Any) -> None:
        self._module = module

    def create_ir_module(self, name: str) -> Any:
        module: Any = ir.Module(normalize_ir_text(name))
        module.triple, module.data_layout = _triple(), self._codegen._data_layout
        return module

    def add_ir_module(self, ir_module: Any) -> None:
        self._work.add(self._add, ir_module.name, normalize_ir_text(str(ir_module)))

    def finalize(self) -> None:
        for library in self._linking_libraries:
            self._reload_init.update(library._reload_init)
        self._finalized = True
        self._work.add(self._finish)

    def _add(self, name: str, text: str) -> None:
        module = _parsed(name, text)
        module.verify()
        self._optimize_functions(module)
        if self._module is None:
            self._module = module
        else:
            self._module.link_in(module)

    def _finish(self) -> None:
        for library in dict.fromkeys(self._linking_libraries):
            self._module.link_in(library._get_module_for_linking(), preserve=True)
        # As much as keeps what is inlined small.
        passes, builder = self._codegen._module_pass_manager(opt=1, loop_vectorize=False, slp_vectorize=False)
        passes.run(self._module, builder)
        self._module.verify()
        self._finalize_dynamic_globals()


class _KernelLibrary(JITCodeLibrary):
    def _optimize_final_module(self) -> None:
        super()._optimize_final_module()
        name, text = self._final_module.name, str(self._final_module)
        in_order = ordered(text)
        if in_order == text:
            return
        # Text that LLVM can't read again is no loss but of speed.
        with suppress(RuntimeError):
            self._final_module = _parsed(name, in_order)


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
