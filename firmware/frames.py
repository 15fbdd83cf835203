"""Frames on the serial line: each whole, or not taken. The host's are in src/layflat/rig/frames.py.

A frame is COBS(version, kind, sequence number, payload, CRC-32) between two zeros.
"""

import struct

VERSION = 1
MAX_PAYLOAD = 240
HEAD = ">BBH"
HEAD_SIZE = 4
CHECK = ">I"
CHECK_SIZE = 4
LONGEST = 254

IDENTIFY, COMMAND = 0x01, 0x02
IDENTITY, READING = 0x81, 0x82


def _remainder(nibble):
    for _ in range(4):
        nibble = (nibble >> 1) ^ (0xEDB88320 if nibble & 1 else 0)
    return nibble


NIBBLES = tuple(_remainder(nibble) for nibble in range(16))


def own_crc32(data):
    """CRC-32 as in zlib, four bits at a time."""
    crc = 0xFFFFFFFF
    for byte in data:
        crc ^= byte
        crc = (crc >> 4) ^ NIBBLES[crc & 15]
        crc = (crc >> 4) ^ NIBBLES[crc & 15]
    return crc ^ 0xFFFFFFFF


try:
    from binascii import crc32
except ImportError:  # some builds leave it out
    crc32 = own_crc32


def whole(value, low, high, name):
    """Return a whole number that is within its range; raise ValueError if it is not.

    MicroPython's struct, array and bytearray take the lowest bits of what does not fit, without a word: 70000 would go
    out as 4464.
    """
    if not isinstance(value, int) or not low <= value <= high:
        raise ValueError(f"{name} is {value}; it goes from {low} to {high}")
    return value


def encode(kind, sequence, payload):
    """Return a frame with its zeros; raise ValueError if a number or the payload does not fit into one."""
    whole(len(payload), 0, MAX_PAYLOAD, "payload's length")
    body = struct.pack(HEAD, VERSION, whole(kind, 0, 0xFF, "kind"), whole(sequence, 0, 0xFFFF, "number")) + payload
    return b"\0" + stuffed(body + struct.pack(CHECK, crc32(body))) + b"\0"


def stuffed(data):
    """COBS of up to 253 bytes: each zero becomes the distance to the next."""
    out = bytearray(1)
    last = 0
    for byte in data:
        if byte:
            out.append(byte)
        else:
            out[last] = len(out) - last
            last = len(out)
            out.append(0)
    out[last] = len(out) - last
    return bytes(out)


def unstuffed(data):
    """What COBS was made of, or None if it is none."""
    out = bytearray()
    at = 0
    while at < len(data):
        end = at + data[at]
        if end > len(data):
            return None
        out.extend(data[at + 1 : end])
        if end < len(data):
            out.append(0)
        at = end
    return bytes(out)


class Decoder:
    """Finds whole frames in bytes that come in any pieces; `bad` counts what was none."""

    def __init__(self):
        self.bad = 0
        self._tail = b""
        self._overlong = False

    def feed(self, data):
        """Take the next bytes; return the frames that end in them: (kind, sequence number, payload)."""
        pieces = (self._tail + data).split(b"\0")
        self._tail = pieces.pop()
        found = []
        for piece in pieces:
            frame = None if self._overlong else _whole(piece)
            if frame is not None:
                found.append(frame)
            elif piece or self._overlong:
                self.bad += 1
            self._overlong = False
        if len(self._tail) > LONGEST:
            self._tail, self._overlong = b"", True
        return found


def _whole(piece):
    if not HEAD_SIZE + CHECK_SIZE < len(piece) <= LONGEST:
        return None
    body = unstuffed(piece)
    if body is None or len(body) < HEAD_SIZE + CHECK_SIZE:
        return None
    body, check = body[:-CHECK_SIZE], body[-CHECK_SIZE:]
    if struct.pack(CHECK, crc32(body)) != check:
        return None
    version, kind, sequence = struct.unpack(HEAD, body[:HEAD_SIZE])
    return (kind, sequence, body[HEAD_SIZE:]) if version == VERSION else None
