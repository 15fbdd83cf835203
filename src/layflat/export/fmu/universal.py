"""Universal libraries of macOS: code for several processors in one file, for FMI 2.0, which has one folder for both."""

import struct
from collections.abc import Sequence

FAT_MAGIC = 0xCAFEBABE
PAGE_BITS = 14  # of each part, as a power of two: a page of Apple's processors


def join_libraries(libraries: Sequence[bytes]) -> bytes:
    """Return Mach-O libraries for several processors as one; a single one as it is."""
    if len(libraries) == 1:
        return libraries[0]
    page = 1 << PAGE_BITS
    offset, table, body = page, struct.pack(">II", FAT_MAGIC, len(libraries)), b""
    for library in libraries:
        processor, kind = struct.unpack_from("<4xII", library)
        table += struct.pack(">IIIII", processor, kind, offset, len(library), PAGE_BITS)
        padded = library + bytes(-len(library) % page)
        body += padded
        offset += len(padded)
    return table + bytes(page - len(table)) + body
