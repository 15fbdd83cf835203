"""Errors of Modbus stations in words: exceptions by name with what helps, and what else than a reply may come."""

import struct

ILLEGAL_FUNCTION, BUSY = 1, 6

EXCEPTIONS = {
    1: ("illegal function", "let the station serve function {function}, or put one before it that does"),
    2: ("illegal data address", "make interface.modbus in the machine's file fit the station's registers"),
    3: ("illegal data value", "make interface and its bits in the machine's file fit the station"),
    4: ("server device failure", "look at the station's own diagnosis"),
    5: ("acknowledge", "the station takes longer than a cycle: let it answer at once"),
    6: ("server device busy", "one loop drives a rig: end the other master first, or lighten the station's load"),
    7: ("negative acknowledge", "look at the station's own diagnosis"),
    8: ("memory parity error", "look at the station's own diagnosis"),
    10: ("gateway path unavailable", "look at the gateway's routes, and at interface.modbus.unit"),
    11: ("gateway target device failed to respond", "look at the device behind it, and at interface.modbus.unit"),
}
"""Name and advice of each exception, by its code (Modbus Application Protocol 1.1b3, section 7)."""

_HEAD = struct.Struct(">HHHB")  # transaction, protocol, length from the unit on, unit


def refusal(function: int, code: int) -> str:
    """Return what a station refused, with the exception by its name."""
    name = EXCEPTIONS[code][0] if code in EXCEPTIONS else "a code of its own"
    return f"function {function} is refused: exception {code}, {name}"


def remedy(function: int, code: int) -> str:
    """Return what helps against an exception."""
    advice = EXCEPTIONS[code][1] if code in EXCEPTIONS else "look it up in the station's manual"
    return advice.format(function=function)


def no_reply(data: bytes, number: int, unit: int) -> str:
    """Return what came in place of a reply, in words.

    Args:
        data: all bytes that came in time.
        number: of the transaction.
        unit: that was asked.
    """
    if not data:
        return "nothing came in time"
    at, reason = 0, ""
    while at + _HEAD.size <= len(data):
        told, protocol, length, other = _HEAD.unpack_from(data, at)
        if protocol:
            return f"what came is no Modbus: {data[at : at + 16]!r}"
        if at + 6 + length > len(data):
            break
        if other != unit:
            reason = f"unit {other} answered in place of unit {unit}"
        elif told not in {0, number}:
            reason = reason or "only replies to earlier requests came: they take longer than a cycle"
        at += 6 + length
    return reason or f"the reply broke off after {len(data)} bytes"
