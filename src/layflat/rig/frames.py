"""Frames on a serial line: each is received whole, or rejected.

A frame is COBS(version, kind, sequence number, payload, CRC-32) between two zeros, which COBS keeps out of all else. A
damaged frame thus never takes a neighbour along. `firmware/frames.py` is the same for a microcontroller; both pass the
same tests.
"""

import struct
from typing import NamedTuple
from zlib import crc32

from cobs import cobs

from layflat.rig.wire import WireError

VERSION = 1
FRAME_HEADER = struct.Struct(">BBH")
FRAME_CHECKSUM = struct.Struct(">I")
MAX_FRAME_BYTES = 254  # bytes of a frame between its zeros; what grows longer is none

# Kinds; the device's have the high bit, so that nobody takes an echo for an answer.
IDENTIFY_FRAME, COMMAND_FRAME, REQUEST_FRAME = 0x01, 0x02, 0x03
IDENTITY_FRAME, READING_FRAME, STATUS_FRAME, SIGNALS_FRAME = 0x81, 0x82, 0x83, 0x84


class SerialFrame(NamedTuple):
    """Decoded frame."""

    kind: int
    sequence: int
    payload: bytes


def encode(kind: int, sequence: int, payload: bytes) -> bytes:
    """Return a frame with its two zeros.

    Args:
        kind: one of the constants `..._FRAME`, 0..255.
        sequence: number of the transaction, 0..65535.
        payload: up to 240 bytes.
    """
    body = FRAME_HEADER.pack(VERSION, kind, sequence) + payload
    stuffed: bytes = cobs.encode(body + FRAME_CHECKSUM.pack(crc32(body)))
    return b"\0" + stuffed + b"\0"


class Decoder:
    """Decoder of frames from bytes that come in any pieces.

    `bad` counts rejected frames: damaged, of another version, or too long.
    """

    def __init__(self) -> None:
        self.bad = 0
        self._tail = b""
        self._overlong = False

    def feed(self, data: bytes) -> list[SerialFrame]:
        """Consume the next bytes; return the frames that end in them, in order; count rejected ones in `bad`."""
        *ended, self._tail = (self._tail + data).split(b"\0")
        decoded = []
        for piece in ended:
            frame = None if self._overlong else _decode_frame(piece)
            if frame is not None:
                decoded.append(frame)
            elif piece or self._overlong:
                self.bad += 1
            self._overlong = False
        if len(self._tail) > MAX_FRAME_BYTES:
            self._tail, self._overlong = b"", True
        return decoded


def _decode_frame(piece: bytes) -> SerialFrame | None:
    """Return the frame in the bytes between two zeros; None if of a wrong length or version, or damaged."""
    if not FRAME_HEADER.size + FRAME_CHECKSUM.size < len(piece) <= MAX_FRAME_BYTES:
        return None
    try:
        body = cobs.decode(piece)
    except cobs.DecodeError:
        return None
    body, check = body[: -FRAME_CHECKSUM.size], body[-FRAME_CHECKSUM.size :]
    if len(body) < FRAME_HEADER.size or FRAME_CHECKSUM.pack(crc32(body)) != check:
        return None
    version, kind, sequence = FRAME_HEADER.unpack_from(body)
    return SerialFrame(kind, sequence, body[FRAME_HEADER.size :]) if version == VERSION else None


def pack_words(words: list[int]) -> bytes:
    """Return words as a payload, high byte first."""
    return struct.pack(f">{len(words)}H", *words)


def unpack_words(payload: bytes) -> tuple[int, ...]:
    """Return the words of a payload; raise WireError if it has an odd number of bytes."""
    if len(payload) % 2:
        raise WireError(f"a payload of {len(payload)} bytes, which are not whole words of 2 bytes")
    return struct.unpack(f">{len(payload) // 2}H", payload)
