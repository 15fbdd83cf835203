"""A WebAssembly module from an object file, without a linker.

A relocatable object that calls nothing from outside needs no relocation: its indices and addresses are already those of
its own sections. It runs once its memory and stack, which it imports, are defined, and its functions are exported.

Source: WebAssembly specification 2.0, section 5; symbols: WebAssembly tool-conventions, Linking.md.
"""

from collections.abc import Iterator, Mapping
from enum import IntEnum

from layflat.errors import CompilerError
from layflat.export.web.binary import (
    ByteReader,
    External,
    SectionId,
    WasmSection,
    join_sections,
    name_bytes,
    read_sections,
    signed_number,
    unsigned_number,
)

PAGE_BYTES = 65536
STACK_BYTES = 4 * PAGE_BYTES  # the tracking law of four joints takes 12 kB
HEAP_ALIGNMENT = 16  # bytes; of the stack, too
SYMBOL_TABLE = 8  # part of the section "linking"
I32_TYPE, I32_CONST, END_OF_EXPRESSION = 0x7F, 0x41, 0x0B
IS_VARIABLE, IS_CONSTANT = bytes([1]), bytes([0])
OWN_IMPORTS = frozenset({"__linear_memory", "__stack_pointer"})
"""Imports of every object file that are defined here."""


class SymbolKind(IntEnum):
    """Kinds of symbols that differ in their form."""

    FUNCTION = 0
    DATA = 1
    SECTION = 3


class SymbolFlag(IntEnum):
    """Flags of symbols that change their form."""

    UNDEFINED = 0x10
    EXPLICIT_NAME = 0x40


def finish_module(object_file: bytes, exports: Mapping[str, str]) -> bytes:
    """Return the module that an object file becomes with a memory and a stack of its own.

    It exports its functions, `memory`, and `__heap_base`, the address from which on memory is the caller's.

    Args:
        object_file: object file for wasm32 that needs no function from outside.
        exports: names under which its functions are exported, by their symbols.

    Raises:
        CompilerError: it needs something from outside, or lacks a symbol.
    """
    found = read_sections(object_file)
    sections = {one.identifier: one.content for one in found if one.identifier != SectionId.CUSTOM}
    _check_imports(sections)
    functions = _function_numbers(found)
    missing = sorted(set(exports) - set(functions))
    if missing:
        raise CompilerError(f"machine code for WebAssembly lacks {', '.join(missing)}")
    end = _data_end(sections.get(SectionId.DATA, b"\0"))
    top = -(-end // HEAP_ALIGNMENT) * HEAP_ALIGNMENT + STACK_BYTES
    address = bytes([I32_CONST]) + signed_number(top) + bytes([END_OF_EXPRESSION])
    pointer, heap = (bytes([I32_TYPE]) + kind + address for kind in (IS_VARIABLE, IS_CONSTANT))
    entries = [_export(name, External.FUNCTION, functions[symbol]) for symbol, name in exports.items()]
    entries += [_export("memory", External.MEMORY, 0), _export("__heap_base", External.GLOBAL, 1)]
    sections.pop(SectionId.IMPORTS, None)
    sections |= {
        SectionId.MEMORIES: unsigned_number(1) + b"\0" + unsigned_number(top // PAGE_BYTES + 1),
        SectionId.GLOBALS: unsigned_number(2) + pointer + heap,
        SectionId.EXPORTS: unsigned_number(len(entries)) + b"".join(entries),
    }
    return join_sections(sections)


def _export(name: str, kind: External, index: int) -> bytes:
    return name_bytes(name) + bytes([kind]) + unsigned_number(index)


def _check_imports(sections: Mapping[int, bytes]) -> None:
    """Check that an object needs but a memory and the pointer of its stack."""
    names = _imported_names(ByteReader(sections.get(SectionId.IMPORTS, b"\0")))
    outside = [name for name in names if name not in OWN_IMPORTS]
    outside += [f"section {one}" for one in sections if one not in set(SectionId)]
    if outside:
        raise CompilerError(f"machine code for WebAssembly needs {', '.join(outside)} from outside")


def _imported_names(reader: ByteReader) -> Iterator[str]:
    for _ in range(reader.number()):
        reader.name()
        yield reader.name()
        kind = reader.byte()
        if kind == External.FUNCTION:
            reader.number()
        elif kind == External.GLOBAL:
            reader.byte(), reader.byte()
        else:
            if kind == External.TABLE:
                reader.byte()
            has_maximum = reader.number() & 1
            for _ in range(1 + has_maximum):
                reader.number()


def _data_end(content: bytes) -> int:
    """Return the address behind the last segment of data."""
    reader, end = ByteReader(content), 0
    for _ in range(reader.number()):
        if reader.number() != 0 or reader.byte() != I32_CONST:
            raise CompilerError("machine code for WebAssembly has data at no fixed address")
        address = reader.number()  # signed, but never negative, so that its bits are those of an unsigned one
        reader.byte()  # the end of the expression
        end = max(end, address + len(reader.bytes()))
    return end


def _function_numbers(sections: list[WasmSection]) -> dict[str, int]:
    """Return the numbers of functions by their symbols."""
    for one in sections:
        reader = ByteReader(one.content)
        if one.identifier != SectionId.CUSTOM or reader.name() != "linking":
            continue
        reader.number()  # version
        while not reader.at_end:
            kind, content = reader.byte(), reader.bytes()
            if kind == SYMBOL_TABLE:
                return dict(_named_functions(ByteReader(content)))
    raise CompilerError("the object file of WebAssembly has no symbols")


def _named_functions(reader: ByteReader) -> Iterator[tuple[str, int]]:
    for _ in range(reader.number()):
        kind, flags = reader.byte(), reader.number()
        is_defined = not flags & SymbolFlag.UNDEFINED
        if kind == SymbolKind.DATA:
            reader.name()
            for _ in range(3 if is_defined else 0):  # segment, offset, size
                reader.number()
        elif kind == SymbolKind.SECTION:
            reader.number()
        else:
            index = reader.number()
            name = reader.name() if is_defined or flags & SymbolFlag.EXPLICIT_NAME else ""
            if kind == SymbolKind.FUNCTION:
                yield name, index
