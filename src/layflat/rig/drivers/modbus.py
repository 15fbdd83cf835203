"""A rig behind a Modbus TCP station: function 23 writes the command and reads the sensors in one transaction.

A station that refuses function 23 gets functions 16 and 3 instead, one after the other in the same cycle: the reading
still carries the number of the command, so that it is never mistaken for an older one.

pymodbus encodes and decodes the frames. Its own client waits anew for every piece of a reply; here a whole reply has
one deadline. After it the connection stays open, and late replies are dropped.
"""

import logging
import socket
import struct
import time
from collections.abc import Sequence

from pymodbus.exceptions import ModbusIOException
from pymodbus.framer import FramerSocket
from pymodbus.pdu import DecodePDU, ModbusPDU
from pymodbus.pdu.register_message import (
    ReadHoldingRegistersRequest,
    ReadWriteMultipleRegistersRequest,
    WriteMultipleRegistersRequest,
)

from layflat.machine.model import Machine
from layflat.rig.driver import LinkError
from layflat.rig.drivers.linked import LinkedDriver, read_pieces
from layflat.rig.wire import Identity, Registers

ILLEGAL_FUNCTION, SERVER_BUSY = 1, 6

EXCEPTION_TEXTS = {
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

_MBAP_HEADER = struct.Struct(">HHHB")  # transaction, protocol, length from the unit on, unit
CONNECT_TIMEOUT = 1.0  # patience while connecting, s


def describe_refusal(function: int, code: int) -> str:
    """Return a message for an exception that refuses a function, with the exception's name."""
    name = EXCEPTION_TEXTS[code][0] if code in EXCEPTION_TEXTS else "a code of its own"
    return f"function {function} is refused: exception {code}, {name}"


def exception_advice(function: int, code: int) -> str:
    """Return the advice for an exception that refuses a function."""
    advice = EXCEPTION_TEXTS[code][1] if code in EXCEPTION_TEXTS else "look it up in the station's manual"
    return advice.format(function=function)


def describe_missing_reply(data: bytes, number: int, unit: int) -> str:
    """Return a message about what came in place of a reply.

    Args:
        data: all bytes that came in time.
        number: number of the transaction.
        unit: unit of the request.
    """
    if not data:
        return "nothing came in time"
    at, reason = 0, ""
    while at + _MBAP_HEADER.size <= len(data):
        transaction, protocol, length, other = _MBAP_HEADER.unpack_from(data, at)
        if protocol:
            return f"what came is no Modbus: {data[at : at + 16]!r}"
        if at + 6 + length > len(data):
            break
        if other != unit:
            reason = f"unit {other} answered in place of unit {unit}"
        elif transaction not in {0, number}:
            reason = reason or "only replies to earlier requests came: they take longer than a cycle"
        at += 6 + length
    return reason or f"the reply broke off after {len(data)} bytes"


# A reply that is late is counted by the loop; pymodbus would write a line of its own about each.
logging.getLogger("pymodbus").setLevel(logging.CRITICAL)


class ModbusDriver(LinkedDriver):
    """Driver of a rig behind a Modbus TCP station."""

    def __init__(self, machine: Machine, host: str, port: int) -> None:
        super().__init__(machine, f"modbus://{host}:{port}")
        self._host, self._port = host, port
        self._registers = Registers.for_machine(machine)
        self._link = machine.interface.modbus
        self._framer = FramerSocket(DecodePDU(False))
        self._line: socket.socket | None = None

    def _connect(self) -> None:
        """Resolve the host's name and connect within `CONNECT_TIMEOUT`; raise DriverError if it can't be reached."""
        try:
            # By number from here on: a cycle must never wait for a name.
            self._host = str(socket.getaddrinfo(self._host, self._port, type=socket.SOCK_STREAM)[0][4][0])
            self._line = self._open(CONNECT_TIMEOUT)
        except OSError as error:
            what = "no answer" if isinstance(error, TimeoutError) else error.strerror or str(error)
            raise self._error(f"can't be reached ({what})", "give host and port of a rig that is on") from None

    def _open(self, patience: float) -> socket.socket:
        """Return a non-blocking socket to the station without Nagle's delay, connected within `patience` seconds.

        Raises:
            OSError: the station did not take the connection in time.
        """
        line = socket.create_connection((self._host, self._port), timeout=patience)
        line.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        line.setblocking(False)
        return line

    def _identify(self) -> Identity:
        """Return the identity that the station's registers hold; raise DriverError with advice if it refuses."""
        at, unit = self._registers.identity, self._link.unit
        request = ReadHoldingRegistersRequest(address=at.start, count=len(at))
        try:
            reply = self._request(self._sequence, request, CONNECT_TIMEOUT)
        except LinkError as error:
            what = f"takes connections but does not answer as a Modbus station ({error.reason})"
            raise self._error(what, "try its port, and interface.modbus.unit") from None
        code = reply.exception_code
        if code == SERVER_BUSY:
            raise self._error("is driven by another master (exception 6)", exception_advice(3, SERVER_BUSY))
        if code:
            what = f"unit {unit} does not report registers {at.start} to {at.stop - 1}: {describe_refusal(3, code)}"
            raise self._error(what, exception_advice(3, code))
        if len(reply.registers) != len(at):
            what = f"unit {unit} reports {len(reply.registers)} registers where {len(at)} were requested"
            raise self._error(what, "let the station serve as many at once")
        return Identity.from_words(reply.registers)

    def _exchange(self, sequence: int, words: list[int]) -> Sequence[int]:
        """Write the command's words and return those of the reading, without the echo of the sequence number.

        Once a station has refused function 23, functions 16 and 3 are used, in the same timeout, and `remark` says so.

        Raises:
            LinkError: refused, timed out, or a reply to another command.
        """
        commands, readings, _ = self._registers
        began = time.monotonic()
        if not self.remark:
            both = ReadWriteMultipleRegistersRequest(
                read_address=readings.start, read_count=len(readings), write_address=commands.start,
                write_registers=[sequence, *words],
            )  # fmt: skip
            reply = self._request(sequence, both, self._link.timeout)
            if reply.exception_code == ILLEGAL_FUNCTION:
                self.remark = "by functions 16 and 3, as the station refuses 23"
        if self.remark:
            write = WriteMultipleRegistersRequest(address=commands.start, registers=[sequence, *words])
            reply = self._request(sequence, write, self._link.timeout - (time.monotonic() - began))
            if not reply.exception_code:
                read = ReadHoldingRegistersRequest(address=readings.start, count=len(readings))
                reply = self._request(sequence, read, self._link.timeout - (time.monotonic() - began))
        if code := reply.exception_code:
            function = reply.function_code & 0x7F
            raise LinkError("refused", describe_refusal(function, code), exception_advice(function, code))
        if len(reply.registers) != len(readings):
            raise LinkError("crc", f"{len(reply.registers)} registers came where {len(readings)} were requested")
        if reply.registers[0] != sequence:
            what = f"register {readings.start} holds {reply.registers[0]} in place of the command's number {sequence}"
            raise LinkError("sequence", what, f"let the station copy register {commands.start} there")
        return reply.registers[1:]

    def _request(self, number: int, request: ModbusPDU, patience: float) -> ModbusPDU:
        """Send a request and return the reply with its number, which may be an exception; stale bytes are dropped.

        It reconnects first if the device has hung up; `patience` is the timeout, s.

        Raises:
            LinkError: no reply in time, an invalid one, or the device hung up.
        """
        request.transaction_id, request.dev_id, tail, seen = number, self._link.unit, b"", b""
        try:
            line = self._line = self._line or self._open(max(patience, 1e-3))
            for _ in read_pieces(line.fileno(), line.recv, 0.0):
                pass  # What came before the request is stale.
            line.send(self._framer.buildFrame(request))
            for piece in read_pieces(line.fileno(), line.recv, max(patience, 0.0)):
                seen += piece
                used, reply = self._framer.handleFrame(tail + piece, self._link.unit, number)
                if reply is not None:
                    return self._require_function(request, reply)
                tail = (tail + piece)[used:]
        except ModbusIOException:
            raise LinkError("crc", describe_missing_reply(seen, number, self._link.unit)) from None
        except OSError as error:
            self._disconnect()
            raise LinkError("lost", f"the station hung up ({error.strerror or type(error).__name__})") from None
        raise LinkError("lost", describe_missing_reply(seen, number, self._link.unit))

    def _require_function(self, request: ModbusPDU, reply: ModbusPDU) -> ModbusPDU:
        """Return a reply to this request's function, or its exception; raise LinkError for another function's."""
        if reply.function_code & 0x7F != request.function_code:
            what = f"function {request.function_code} is answered as function {reply.function_code & 0x7F}"
            raise LinkError("crc", what)
        return reply

    def _disconnect(self) -> None:
        if self._line is not None:
            self._line.close()
            self._line = None
