"""A rig behind a Modbus TCP station: function 23 writes the command and reads the sensors in one transaction.

pymodbus makes and reads the frames. Its own client waits anew for every piece of a reply; here a whole reply has one
deadline. After it the connection stays, and what comes late is dropped.
"""

import logging
import socket
from collections.abc import Sequence

from pymodbus.exceptions import ModbusIOException
from pymodbus.framer import FramerSocket
from pymodbus.pdu import DecodePDU, ModbusPDU
from pymodbus.pdu.register_message import ReadHoldingRegistersRequest, ReadWriteMultipleRegistersRequest

from layflat.machine.model import Machine
from layflat.rig.driver import LinkError
from layflat.rig.drivers.linked import LinkedDriver, pieces
from layflat.rig.wire.identity import Identity, Registers

CONNECT = 1.0  # patience while connecting, s
BUSY = 6  # exception code of a station that another master drives

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
        try:
            reply = self._ask(self._sequence, ReadHoldingRegistersRequest(address=at.start, count=len(at)), CONNECT)
        except LinkError:
            raise self._error("takes connections but does not answer as a Modbus station", "try its port") from None
        if not reply.isError():
            return Identity.from_words(reply.registers)
        if reply.exception_code == BUSY:
            raise self._error("is driven by another master", "one loop drives a rig: end the other first")
        raise self._error(
            f"unit {unit} has no registers {at.start} to {at.stop - 1} (exception {reply.exception_code})",
            "make interface.modbus in the machine's file fit the station",
        )

    def _exchange(self, sequence: int, words: list[int]) -> Sequence[int]:
        commands, readings, _ = self._registers
        request = ReadWriteMultipleRegistersRequest(
            read_address=readings.start, read_count=len(readings), write_address=commands.start,
            write_registers=[sequence, *words],
        )  # fmt: skip
        reply = self._ask(sequence, request, self._link.timeout)
        if reply.isError():
            raise LinkError("lost")
        if len(reply.registers) != len(readings):
            raise LinkError("crc")
        if reply.registers[0] != sequence:
            raise LinkError("sequence")
        return reply.registers[1:]

    def _ask(self, number: int, request: ModbusPDU, patience: float) -> ModbusPDU:
        """Send a request, and take the reply that has its number; connect anew if the device has hung up."""
        request.transaction_id, request.dev_id, tail = number, self._link.unit, b""
        try:
            line = self._line = self._line or self._open(patience)
            for _ in pieces(line.fileno(), line.recv, 0.0):
                pass  # What came before the request is stale.
            line.send(self._framer.buildFrame(request))
            for piece in pieces(line.fileno(), line.recv, patience):
                used, reply = self._framer.handleFrame(tail + piece, self._link.unit, number)
                if reply is not None:
                    return reply
                tail = (tail + piece)[used:]
        except ModbusIOException:
            raise LinkError("crc") from None
        except OSError:
            self._disconnect()
        raise LinkError("lost")

    def _disconnect(self) -> None:
        if self._line is not None:
            self._line.close()
            self._line = None
