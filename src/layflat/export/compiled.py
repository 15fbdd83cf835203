"""Machine code of entries: portable code once, then an object file for each target."""

# mypy: disable-error-code="no-untyped-call"
# The compiler's own modules are untyped.

from typing import Any, NamedTuple

from layflat.export.entries import Entry
from layflat.export.single import in_single_precision
from layflat.export.stack import stack_bytes
from layflat.export.targets import Target
from layflat.jit.objects import OF_EVERY_TARGET, compiled_module, in_registers, machine_code

SIZE_BY_PRECISION = {"double": 8, "single": 4}  # of a number, bytes
LLVM_NUMBERS = {"double": "double", "single": "float"}


class CompiledEntry(NamedTuple):
    """Machine code of an entry."""

    code: bytes  # object file
    stack: int  # upper bound, without functions of the compiler's library, bytes


def portable_entry(entry: Entry, prefix: str, precision: str) -> str:
    """Return LLVM's portable text of an entry as the C function `prefix_name`.

    Args:
        entry: the entry.
        prefix: prefix of all names in C.
        precision: "double" or "single".
    """
    from numba import types  # noqa: PLC0415  # only where something is exported

    from layflat.jit.portable import c_function  # noqa: PLC0415

    real = types.float64 if precision == "double" else types.float32
    number_kinds: dict[str, tuple[Any, str]] = {
        "real": (real, LLVM_NUMBERS[precision]), "int32_t": (types.int32, "i32"), "int64_t": (types.int64, "i64")
    }  # fmt: skip
    kinds, taken, passed, addresses = [], [], [], []
    for argument in entry.arguments:
        if argument.like is None:
            kind, llvm = number_kinds[argument.number]
            kinds.append(kind)
            taken.append(f"{llvm} %{argument.name}")
            passed.append(taken[-1])
        else:
            taken.append(f"ptr %{argument.name}")
            for place in argument.places:
                part = f"%{argument.name}" if place == 0 else f"%{argument.name}.{place}"
                if place:
                    size = place * SIZE_BY_PRECISION[precision]
                    addresses.append(f"{part} = getelementptr i8, ptr %{argument.name}, i32 {size}")
                for view in argument.views:
                    kinds.append(types.CPointer(number_kinds[view][0]))
                    passed.append(f"ptr {part}")
    name, integer = f"{prefix}_{entry.name}", bool(entry.result)
    words = ", ".join(taken), ", ".join(passed)
    text = c_function(name, entry.function, tuple(kinds), *words, addresses=addresses, integer=integer)
    if precision == "single" and not entry.lanes:
        return in_single_precision(in_registers(text, (name,)))
    return text


def object_file(entry: Entry, text: str, prefix: str, target: Target) -> bytes:
    """Return the object file of an entry.

    Args:
        entry: the entry.
        text: its portable text.
        prefix: prefix of all names in C.
        target: the target.

    Raises:
        CompilerError: the code would call a function that the target lacks.
    """
    names = (f"{prefix}_{entry.name}",)
    return machine_code(text, names, target.processor, ordered=False, outside=OF_EVERY_TARGET)


def compiled_entry(entry: Entry, text: str, prefix: str, target: Target) -> CompiledEntry:
    """Return the object file of an entry, and the stack that it takes.

    Args:
        entry: the entry.
        text: its portable text.
        prefix: prefix of all names in C.
        target: the target.

    Raises:
        CompilerError: the code would call a function that the target lacks, or the stack is unknown.
    """
    module = compiled_module(text, (f"{prefix}_{entry.name}",), target.processor, OF_EVERY_TARGET)
    return CompiledEntry(module.code, stack_bytes(module.assembly, target.processor.triple))
