"""All whole records of an MCAP file, be it whole, cut short anywhere, or still growing."""

from __future__ import annotations

import mmap
import struct
import zlib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from layflat.errors import InputError

MAGIC = b"\x89MCAP0\r\n"

HEADER, SCHEMA, CHANNEL, MESSAGE, CHUNK, ATTACHMENT, METADATA, DATA_END = 1, 3, 4, 5, 6, 9, 12, 15
"""Kinds of records that hold data; all others can be made from these."""

_RECORD = struct.Struct("<BQ")
_CHUNK_HEAD = struct.Struct("<QQQII")
_LENGTH = struct.Struct("<Q")


@dataclass
class Scanned:
    """How far a scan has come.

    Attributes:
        place: bytes that are done.
        size: bytes there are.
        lost: bytes that made no whole record: at the end, or in chunks that are damaged.
        ended: whether the end of the data was found where it belongs, so that nothing is missing behind it.
    """

    place: int = 0
    size: int = 0
    lost: int = 0
    ended: bool = False


def check_magic(path: Path) -> bool:
    """Whether a file ends as an MCAP file does.

    Raises:
        InputError: it can't be read, or does not even begin as one.
    """
    right = "give an MCAP file, as `layflat rig` records it"
    try:
        with path.open("rb") as file:
            head = file.read(len(MAGIC))
            size = file.seek(0, 2)
            file.seek(max(0, size - len(MAGIC)))
            tail = file.read()
    except OSError as error:
        raise InputError(f"can't be read ({error.strerror})", where=str(path), right=right) from None
    if not head:
        raise InputError("is empty", where=str(path), right=right)
    if head != MAGIC:
        raise InputError("is no MCAP file", where=str(path), right=right)
    return size >= 2 * len(MAGIC) and tail == MAGIC


def records(path: Path, scanned: Scanned) -> Iterator[tuple[int, bytes]]:
    """Kind and content of the records outside and inside of chunks, in the file's order, up to the end of its data.

    A machine that loses power may leave zeros in place of what was written last: a record that runs into zeros, which
    go on behind it to the end of the file, is not whole.

    Args:
        path: of a file that begins as MCAP does.
        scanned: told how far it is.
    """
    with path.open("rb") as file, mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as data:
        scanned.size, place = len(data), len(MAGIC)
        solid = _solid(data)
        while place + _RECORD.size <= scanned.size:
            kind, length = _RECORD.unpack_from(data, place)
            start, end = place + _RECORD.size, place + _RECORD.size + length
            if kind == DATA_END and end <= scanned.size:
                scanned.ended = True
                return
            if kind == CHUNK:
                yield from _in_chunk(data[start : min(end, scanned.size)], end <= scanned.size, scanned)
                end = min(end, scanned.size)
            elif kind == 0 or end > scanned.size or solid < end < scanned.size:
                break
            else:
                yield kind, data[start:end]
            place = scanned.place = end
        scanned.lost += scanned.size - place


def _solid(data: mmap.mmap, step: int = 65536) -> int:
    """Bytes up to the last that is not zero."""
    end = len(data)
    while end and not (block := data[max(0, end - step) : end].rstrip(b"\0")):
        end = max(0, end - step)
    return max(0, end - step) + len(block) if end else 0


def _in_chunk(body: bytes, whole: bool, scanned: Scanned) -> Iterator[tuple[int, bytes]]:
    """Records of a chunk; of one that is cut short, as many as can be unpacked."""
    if len(body) < _CHUNK_HEAD.size:
        scanned.lost += len(body)
        return
    _, _, _, checksum, length = _CHUNK_HEAD.unpack_from(body)
    start = _CHUNK_HEAD.size + length + _LENGTH.size
    inside = _unpacked(body[_CHUNK_HEAD.size : _CHUNK_HEAD.size + length], body[start:])
    if whole and checksum and zlib.crc32(inside) != checksum:
        scanned.lost += len(body)
        return
    place = 0
    while place + _RECORD.size <= len(inside):
        kind, length = _RECORD.unpack_from(inside, place)
        end = place + _RECORD.size + length
        if end > len(inside):
            break
        yield kind, inside[place + _RECORD.size : end]
        place = end
    scanned.lost += len(inside) - place


def _unpacked(compression: bytes, data: bytes) -> bytes:
    """What is in a chunk, or in the first part of one; empty where it can't be told."""
    import lz4.frame  # noqa: PLC0415
    import zstandard  # noqa: PLC0415

    try:
        if compression == b"zstd":
            return zstandard.ZstdDecompressor().decompressobj().decompress(data)
        if compression == b"lz4":
            return bytes(lz4.frame.LZ4FrameDecompressor().decompress(data))
    except (zstandard.ZstdError, RuntimeError):
        return b""
    return data if compression == b"" else b""
