"""Functions as LLVM's code of no processor in particular: one function of C's calling convention, without a heap.

numba's own code is for this computer. Here it is taken before its last optimisation, and wrapped so that it needs
nothing of Python: `objects` makes machine code of it for any processor, which is bit for bit the same function.
"""

# mypy: disable-error-code="no-untyped-call,misc"
# The compiler's own modules are untyped.

import re
from collections.abc import Callable, Iterable, Iterator
from itertools import count
from typing import Any

import numpy as np
from numba import carray, njit, types  # type: ignore[attr-defined]
from numba.extending import intrinsic

from layflat.jit.compiler import INLINE_OPTIONS
from layflat.jit.internals import Compiler, JITCodeLibrary
from layflat.jit.libraries import NoEnvironments
from layflat.jit.objects import without_target
from layflat.lanes import Like

C_ROOTS = {"sqrt": ("double", "f64"), "sqrtf": ("float", "f32")}
"""Roots that numba calls of the C library; as instructions they are the same bits everywhere, and set no errno."""

COUNTS_OF_REFERENCES = (
    "NRT_incref",
    "NRT_decref",
    "NRT_MemInfo_call_dtor",
)  # of views of the caller's arrays, which nobody frees

FROZEN_ARRAYS = re.compile(r"= freeze (\{.*\}) (%[\w.$\"-]+)$", re.MULTILINE)
"""Arrays frozen as a whole where a loop depends on one: sizes and strides would no longer be known as constants.

Only the fields of their owners are undefined, which nobody reads.
"""


class _PortableLibrary(JITCodeLibrary):
    """Library whose code is neither optimised for this processor nor ever runs here."""

    @property
    def codegen(self) -> Any:
        return NoEnvironments()

    def _optimize_final_module(self) -> None:
        """Do nothing: each target has passes of its own."""

    def _finalize_final_module(self) -> None:
        self._finalize_dynamic_globals()
        self._finalized = True


class _PortableCompiler(Compiler):
    """Compiler of functions to code of no processor."""

    def __init__(self, typing_context: Any, context: Any, library: Any, *rest: Any) -> None:
        super().__init__(typing_context, context, library or _PortableLibrary(context.codegen(), "portable"), *rest)


@intrinsic
def _pointer(_: Any, word: Any) -> Any:
    """Return a word as an address."""

    def emit(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        return builder.inttoptr(args[0], context.get_value_type(sig.return_type))

    return types.voidptr(word), emit


def portable_code(name: str, kernel: Any, args: tuple[Any, ...], results: int) -> str:
    """Return LLVM's text of a kernel as `void name(int64_t *words)`.

    Args:
        name: name of the function.
        kernel: `PortableKernel`.
        args: arguments of the types that it is compiled for.
        results: number of integers that it returns; they are the first words, those of the arguments follow.

    The text may declare functions from outside: `objects.machine_code` refuses those that it does not know.
    """
    source, names = _entry_source(kernel, args, results)
    exec(source, names)
    kinds = types.CPointer(types.int64), types.CPointer(types.float64)
    return c_function(name, names["entry"], kinds, "ptr %words", "ptr %words, ptr %words")


def _entry_source(kernel: Any, args: tuple[Any, ...], results: int) -> tuple[str, dict[str, Any]]:
    """Return a function that calls a kernel with arguments read from words, as Python source, and the names it uses."""
    names: dict[str, Any] = {"carray": carray, "pointer": _pointer, "kernel": kernel.dispatcher}
    words = count(results)
    passed = ", ".join(_expression(arg, words, names) for arg in args)
    stored = "".join(f"words[{i}], " for i in range(results))
    call = f"{stored.removesuffix(', ')} = kernel({passed})" if results else f"kernel({passed})"
    return f"def entry(words, numbers):\n    {call}\n", names


def _expression(arg: Any, words: Iterator[int], names: dict[str, Any]) -> str:
    """Return the expression that reads an argument from the next `words`; add types and constants to `names`."""
    name = f"constant{len(names)}"
    if isinstance(arg, np.ndarray):
        names[name] = arg.dtype.type
        address, *sizes = (f"words[{next(words)}]" for _ in range(1 + arg.ndim))
        return f"carray(pointer({address}), ({', '.join(sizes)},), {name})"
    if isinstance(arg, tuple):
        names[name] = type(arg)
        items = ", ".join(_expression(item, words, names) for item in arg)
        return f"({items},)" if type(arg) is tuple else f"{name}({items})"
    if isinstance(arg, Like):
        names[name] = arg
        return name
    return f"{'numbers' if isinstance(arg, float) else 'words'}[{next(words)}]"


def c_function(
    name: str, function: Callable[..., Any], kinds: tuple[Any, ...], taken: str, passed: str, *,
    addresses: Iterable[str] = (), integer: bool = False,
) -> str:  # fmt: skip
    """Return LLVM's text of a function with C's calling convention around a function of pointers and numbers.

    Args:
        name: its name.
        function: the function.
        kinds: numba's types of its arguments.
        taken: arguments of the C function in LLVM's words, such as "ptr %a, double %b".
        passed: arguments of the function likewise.
        addresses: instructions that compute some of these.
        integer: whether it returns an integer, which the C function returns; else that returns nothing.
    """
    dispatcher = njit(pipeline_class=_PortableCompiler, **INLINE_OPTIONS)(function)
    dispatcher.compile(kinds)
    (compiled,) = dispatcher.overloads.values()
    inner = compiled.fndesc.llvm_func_name
    quoted = inner if re.fullmatch(r"[\w.$-]+", inner) else f'"{inner}"'
    short = "%long = load i64, ptr %ret\n  %short = trunc i64 %long to i32\n  ret i32 %short"
    return f"""{_self_contained(without_target(str(compiled.library._final_module)))}
define {"i32" if integer else "void"} @{name}({taken}) nounwind {{
entry:
  %ret = alloca i64, align 16
  %exc = alloca [2 x i64], align 16
  {"".join(f"{line}{chr(10)}  " for line in addresses)}%status = call i32 @{quoted}(ptr %ret, ptr %exc, {passed})
  {short if integer else "ret void"}
}}
"""


def _self_contained(text: str) -> str:
    """Return a module with bodies for C's roots and for counts of references, which numba would call outside.

    Other functions from outside stay declared: `objects.machine_code` refuses those that it does not know.
    """
    text = FROZEN_ARRAYS.sub(r"= select i1 true, \1 \2, \1 \2", text)
    for name in COUNTS_OF_REFERENCES:
        text = re.sub(
            rf"^declare void @{name}\(.*$|^define .*void @{name}\(.*\{{\n[\s\S]*?^\}}$",
            f"define internal void @{name}(ptr %p) alwaysinline {{ ret void }}",
            text,
            flags=re.MULTILINE,
        )
    for name, (kind, suffix) in C_ROOTS.items():
        root = f"{kind} @llvm.sqrt.{suffix}({kind}"
        body = f"define internal {kind} @{name}({kind} %x) alwaysinline {{ %y = call {root} %x) ret {kind} %y }}"
        text, replaced = re.subn(rf"^declare {kind} @{name}\(.*$", body, text, flags=re.MULTILINE)
        if replaced and f"declare {root})" not in text:
            text += f"\ndeclare {root})\n"
    return text
