"""Frames on a serial line: each whole, or not taken.

A frame is COBS(version, kind, sequence number, payload, CRC-32) between two zeros, which COBS keeps out of all else. A
damaged frame thus never takes a neighbour along. `firmware/frames.py` is the same for a microcontroller; both pass the
same tests.
"""

import struct
from typing import NamedTuple
from zlib import crc32

from cobs import cobs

from layflat.rig.wire.content import WireError

VERSION = 1
HEAD = struct.Struct(">BBH")
CHECK = struct.Struct(">I")
LONGEST = 254  # bytes of a frame between its zeros; what grows longer is none

IDENTIFY, COMMAND = 0x01, 0x02
IDENTITY, READING = 0x81, 0x82  # kinds; the device's have the high bit, so that nobody takes an echo for an answer


class Frame(NamedTuple):
    """A whole frame."""

    kind: int
    sequence: int
    payload: bytes


def encode(kind: int, sequence: int, payload: bytes) -> bytes:
    """A frame with its zeros; the payload has up to 240 bytes."""
    body = HEAD.pack(VERSION, kind, sequence) + payload
    stuffed: bytes = cobs.encode(body + CHECK.pack(crc32(body)))
    return b"\0" + stuffed + b"\0"


class Decoder:
    """Finds whole frames in bytes that come in any pieces.

    `bad` counts what was none: damaged, of another version, too long.
    """

    def __init__(self) -> None:
        self.bad = 0
        self._tail = b""
        self._overlong = False

    def feed(self, data: bytes) -> list[Frame]:
        """Take the next bytes; return the frames that end in them."""
        *ended, self._tail = (self._tail + data).split(b"\0")
        found = []
        for piece in ended:
            frame = None if self._overlong else _whole(piece)
            if frame is not None:
                found.append(frame)
            elif piece or self._overlong:
                self.bad += 1
            self._overlong = False
        if len(self._tail) > LONGEST:
            self._tail, self._overlong = b"", True
        return found


def _whole(piece: bytes) -> Frame | None:
    if not HEAD.size + CHECK.size < len(piece) <= LONGEST:
        return None
    try:
        body = cobs.decode(piece)
    except cobs.DecodeError:
        return None
    body, check = body[: -CHECK.size], body[-CHECK.size :]
    if len(body) < HEAD.size or CHECK.pack(crc32(body)) != check:
        return None
    version, kind, sequence = HEAD.unpack_from(body)
    return Frame(kind, sequence, body[HEAD.size :]) if version == VERSION else None


def as_bytes(words: list[int]) -> bytes:
    """Words as a payload, high byte first."""
    return struct.pack(f">{len(words)}H", *words)


def as_words(payload: bytes) -> tuple[int, ...]:
    """Words of a payload; raise WireError if it is half a word too long."""
    if len(payload) % 2:
        raise WireError(f"a payload of {len(payload)} bytes")
    return struct.unpack(f">{len(payload) // 2}H", payload)
