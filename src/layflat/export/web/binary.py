"""WebAssembly's binary format: numbers, texts and sections.

Source: WebAssembly specification 2.0, section 5.
"""

from collections.abc import Mapping
from enum import IntEnum
from typing import NamedTuple

from layflat.errors import CompilerError

MODULE_HEADER = b"\0asm\1\0\0\0"


class SectionId(IntEnum):
    """Identifiers of sections, in the order in which they stand in a module; custom ones may stand anywhere."""

    TYPES = 1
    IMPORTS = 2
    FUNCTIONS = 3
    MEMORIES = 5
    GLOBALS = 6
    EXPORTS = 7
    DATA_COUNT = 12
    CODE = 10
    DATA = 11
    CUSTOM = 0


class External(IntEnum):
    """Kinds of imports and exports."""

    FUNCTION = 0
    TABLE = 1
    MEMORY = 2
    GLOBAL = 3


class WasmSection(NamedTuple):
    """Section of a module."""

    identifier: int
    content: bytes


class ByteReader:
    """Position in a row of bytes."""

    def __init__(self, data: bytes, place: int = 0) -> None:
        self._data, self._place = data, place

    @property
    def at_end(self) -> bool:
        """True behind the last byte."""
        return self._place >= len(self._data)

    def byte(self) -> int:
        """Return the next byte."""
        self._place += 1
        return self._data[self._place - 1]

    def number(self) -> int:
        """Return an unsigned number in LEB128."""
        result = shift = 0
        while True:
            byte = self.byte()
            result |= (byte & 0x7F) << shift
            shift += 7
            if byte < 0x80:
                return result

    def bytes(self) -> bytes:
        """Return a row of bytes behind its length."""
        size = self.number()
        self._place += size
        return self._data[self._place - size : self._place]

    def name(self) -> str:
        """Return a text behind its length."""
        return self.bytes().decode()


def unsigned_number(value: int) -> bytes:
    """Return a number in LEB128."""
    low, rest = value & 0x7F, value >> 7
    return bytes([low | 0x80]) + unsigned_number(rest) if rest else bytes([low])


def signed_number(value: int) -> bytes:
    """Return a number in LEB128 with its sign."""
    low, rest = value & 0x7F, value >> 7
    if rest == (-1 if low & 0x40 else 0):
        return bytes([low])
    return bytes([low | 0x80]) + signed_number(rest)


def name_bytes(name: str) -> bytes:
    """Return a name behind its length."""
    return unsigned_number(len(name.encode())) + name.encode()


def read_sections(module: bytes) -> list[WasmSection]:
    """Return the sections of a module or an object file.

    Raises:
        CompilerError: it is neither.
    """
    if not module.startswith(MODULE_HEADER):
        raise CompilerError("the object file is none of WebAssembly")
    reader, sections = ByteReader(module, len(MODULE_HEADER)), []
    while not reader.at_end:
        sections.append(WasmSection(reader.byte(), reader.bytes()))
    return sections


def join_sections(sections: Mapping[int, bytes]) -> bytes:
    """Return a module of sections by their identifiers."""
    present = [one for one in SectionId if one in sections]
    return MODULE_HEADER + b"".join(
        bytes([one]) + unsigned_number(len(sections[one])) + sections[one] for one in present
    )
