"""A rig behind a Modbus TCP station: function 23 writes the command and reads the sensors in one transaction.

A station that refuses function 23 gets functions 16 and 3 in its place, one after the other in the same cycle: what is
read still carries the number of the command, so that it is never taken for an older one.

pymodbus makes and reads the frames. Its own client waits anew for every piece of a reply; here a whole reply has one
deadline. After it the connection stays, and what comes late is dropped.
"""

import logging
import socket
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
from layflat.rig.drivers.linked import LinkedDriver, pieces
from layflat.rig.drivers.station_errors import BUSY, ILLEGAL_FUNCTION, no_reply, refusal, remedy
from layflat.rig.wire.identity import Identity, Registers

CONNECT = 1.0  # patience while connecting, s

# A reply that is late is counted by the loop; pymodbus would write a line of its own about each.
logging.getLogger("pymodbus").setLevel(logging.CRITICAL)


class ModbusDriver(LinkedDriver):
    """A rig at a station."""

    def __init__(self, machine: Machine, host: str, port: int) -> None:
        super().__init__(machine, f"modbus://{host}:{port}")
        self._host, self._port = host, port
        self._registers = Registers.of(machine)
        self._link = machine.interface.modbus
        self._framer = FramerSocket(DecodePDU(False))
        self._line: socket.socket | None = None

    def _connect(self) -> None:
        try:
            # By number from here on: a cycle must never wait for a name.
            self._host = str(socket.getaddrinfo(self._host, self._port, type=socket.SOCK_STREAM)[0][4][0])
            self._line = self._open(CONNECT)
        except OSError as error:
            what = "no answer" if isinstance(error, TimeoutError) else error.strerror or str(error)
            raise self._error(f"can't be reached ({what})", "give host and port of a rig that is on") from None

    def _open(self, patience: float) -> socket.socket:
        line = socket.create_connection((self._host, self._port), timeout=patience)
        line.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        line.setblocking(False)
        return line

    def _identify(self) -> Identity:
        at, unit = self._registers.identity, self._link.unit
        request = ReadHoldingRegistersRequest(address=at.start, count=len(at))
        try:
            reply = self._ask(self._sequence, request, CONNECT)
        except LinkError as error:
            what = f"takes connections but does not answer as a Modbus station ({error.reason})"
            raise self._error(what, "try its port, and interface.modbus.unit") from None
        code = reply.exception_code
        if code == BUSY:
            raise self._error("is driven by another master (exception 6)", remedy(3, BUSY))
        if code:
            what = f"unit {unit} does not tell registers {at.start} to {at.stop - 1}: {refusal(3, code)}"
            raise self._error(what, remedy(3, code))
        if len(reply.registers) != len(at):
            what = f"unit {unit} tells {len(reply.registers)} registers where {len(at)} were asked"
            raise self._error(what, "let the station serve as many at once")
        return Identity.from_words(reply.registers)

    def _exchange(self, sequence: int, words: list[int]) -> Sequence[int]:
        commands, readings, _ = self._registers
        began = time.monotonic()
        if not self.remark:
            both = ReadWriteMultipleRegistersRequest(
                read_address=readings.start, read_count=len(readings), write_address=commands.start,
                write_registers=[sequence, *words],
            )  # fmt: skip
            reply = self._ask(sequence, both, self._link.timeout)
            if reply.exception_code == ILLEGAL_FUNCTION:
                self.remark = "by functions 16 and 3, as the station refuses 23"
        if self.remark:
            write = WriteMultipleRegistersRequest(address=commands.start, registers=[sequence, *words])
            reply = self._ask(sequence, write, self._link.timeout - (time.monotonic() - began))
            if not reply.exception_code:
                read = ReadHoldingRegistersRequest(address=readings.start, count=len(readings))
                reply = self._ask(sequence, read, self._link.timeout - (time.monotonic() - began))
        if code := reply.exception_code:
            function = reply.function_code & 0x7F
            raise LinkError("refused", refusal(function, code), remedy(function, code))
        if len(reply.registers) != len(readings):
            raise LinkError("crc", f"{len(reply.registers)} registers came where {len(readings)} were asked")
        if reply.registers[0] != sequence:
            what = f"register {readings.start} holds {reply.registers[0]} in place of the command's number {sequence}"
            raise LinkError("sequence", what, f"let the station copy register {commands.start} there")
        return reply.registers[1:]

    def _ask(self, number: int, request: ModbusPDU, patience: float) -> ModbusPDU:
        """Send a request, and take the reply that has its number; connect anew if the device has hung up."""
        request.transaction_id, request.dev_id, tail, seen = number, self._link.unit, b"", b""
        try:
            line = self._line = self._line or self._open(max(patience, 1e-3))
            for _ in pieces(line.fileno(), line.recv, 0.0):
                pass  # What came before the request is stale.
            line.send(self._framer.buildFrame(request))
            for piece in pieces(line.fileno(), line.recv, max(patience, 0.0)):
                seen += piece
                used, reply = self._framer.handleFrame(tail + piece, self._link.unit, number)
                if reply is not None:
                    return self._of(request, reply)
                tail = (tail + piece)[used:]
        except ModbusIOException:
            raise LinkError("crc", no_reply(seen, number, self._link.unit)) from None
        except OSError as error:
            self._disconnect()
            raise LinkError("lost", f"the station hung up ({error.strerror or type(error).__name__})") from None
        raise LinkError("lost", no_reply(seen, number, self._link.unit))

    def _of(self, request: ModbusPDU, reply: ModbusPDU) -> ModbusPDU:
        """Return a reply, if it is one to this request's function."""
        if reply.function_code & 0x7F != request.function_code:
            what = f"function {request.function_code} is answered as function {reply.function_code & 0x7F}"
            raise LinkError("crc", what)
        return reply

    def _disconnect(self) -> None:
        if self._line is not None:
            self._line.close()
            self._line = None
