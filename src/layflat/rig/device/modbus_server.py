"""Modbus TCP station with a device behind it.

pymodbus decodes frames and requests and encodes replies. Its own server answers after some iterations of its event
loop, which costs a third of a transaction's time, and does not distinguish masters; a station has but one.
"""

import asyncio
import logging
from collections.abc import Sequence
from math import inf
from typing import Any

from pymodbus.constants import ExcCodes
from pymodbus.exceptions import ModbusIOException
from pymodbus.framer import FramerSocket
from pymodbus.pdu import DecodePDU, ExceptionResponse, ModbusPDU

from layflat.machine.model import Machine
from layflat.rig.clock import NS_PER_SECOND
from layflat.rig.device.exchange import DeviceStation
from layflat.rig.device.virtual import ReplyFault, VirtualDevice
from layflat.rig.wire import Registers, WireError

# Without a handler pymodbus would log every byte of noise on the line.
logging.getLogger("pymodbus").addHandler(logging.NullHandler())

READ_FUNCTIONS, WRITE_FUNCTION, READ_WRITE_FUNCTION = (3, 4), 16, 23  # supported functions


class ModbusStation(DeviceStation):
    """Station of one unit with functions 3, 4, 16 and 23; the silence of a master counts by the device's clock."""

    def __init__(self, device: VirtualDevice, machine: Machine) -> None:
        super().__init__(device, machine, machine.interface.modbus.timeout)
        self._registers = Registers.for_machine(machine)
        self._unit, self._silence = machine.interface.modbus.unit, machine.interface.dump_after * NS_PER_SECOND
        self.master: object = None  # commanding connection; another may command once it has ended, or was silent
        self._last_request = -inf
        self._server: asyncio.Server | None = None
        self.transports: set[asyncio.BaseTransport] = set()

    async def listen(self, host: str, port: int) -> int:
        """Start to serve at a port (0: any that is free), and return the port; raise OSError if it can't be used."""
        self._server = await asyncio.get_running_loop().create_server(lambda: _Connection(self), host, port)
        return int(self._server.sockets[0].getsockname()[1])

    def close(self) -> None:
        """Stop serving, and close all connections."""
        if self._server is not None:
            self._server.close()
        for transport in self.transports:
            transport.close()

    def answer(self, connection: "_Connection", request: ModbusPDU) -> None:
        """Reply to a request, with an exception if it is invalid, and with the fault that the link has for this reply.

        A silent link ignores the request.
        """
        link = self.device.link
        if link.silent:
            return
        spoil = link.next()
        try:
            reply = self._reply(connection, request, behind=spoil is ReplyFault.SEQUENCE)
        except WireError:
            reply = _refusal(request, ExcCodes.ILLEGAL_VALUE)
        except LookupError:
            reply = _refusal(request, ExcCodes.ILLEGAL_ADDRESS)
        # TCP delivers no damaged bytes; a faulty station may send some.
        self._send(connection.frame(request, reply), spoil, 7, connection.transport.write)

    def _reply(self, master: object, request: Any, behind: bool) -> ModbusPDU:
        """Return the reply to a request, an exception if it is refused; `behind`: with an older command's number.

        The connection becomes the commanding one; others are refused until it ends, or is silent for `dump_after`.

        Raises:
            LookupError: an address or count that the station does not have.
            WireError: registers that are no command.
        """
        now, function = self.device.clock.now(), request.function_code
        if request.dev_id != self._unit:
            return _refusal(request, ExcCodes.GATEWAY_NO_RESPONSE)
        if self.master not in (None, master) and now - self._last_request < self._silence:
            return _refusal(request, ExcCodes.DEVICE_BUSY)
        self.master, self._last_request = master, now
        if function not in (*READ_FUNCTIONS, WRITE_FUNCTION, READ_WRITE_FUNCTION):
            return _refusal(request, ExcCodes.ILLEGAL_FUNCTION)
        _, response = DecodePDU.pdu_table[function]
        if function == WRITE_FUNCTION:
            self._write_words(request.address, request.registers, request.count)
            return response(address=request.address, count=request.count)
        address, count = request.address, request.count
        if function == READ_WRITE_FUNCTION:
            self._write_words(request.write_address, request.write_registers, request.write_count)
            address, count = request.read_address, request.read_count
        return response(registers=self._read_words(address, count, behind))

    def _write_words(self, address: int, words: Sequence[int], count: int) -> None:
        """Obey a command from its registers; raise LookupError for other registers, WireError if it is invalid."""
        if address != self._registers.commands.start or count != len(self._registers.commands):
            raise LookupError
        if len(words) != count:
            raise WireError(f"{len(words)} registers where the request says {count}")
        self._obey(words[0], words[1:])

    def _read_words(self, address: int, count: int, behind: bool) -> list[int]:
        """Return registers of the readings or the identity; raise LookupError for other addresses.

        `behind` makes the sequence number one too low, as a failure of the link does.
        """
        _, readings, identity = self._registers
        if address in readings and 1 <= count <= readings.stop - address:
            words = [((self._last or 0) - behind) & 0xFFFF, *self._read()]
            return words[address - readings.start :][:count]
        if address in identity and 1 <= count <= identity.stop - address:
            return self._identify()[address - identity.start :][:count]
        raise LookupError


class _Connection(asyncio.Protocol):
    """Connection of one master."""

    def __init__(self, station: ModbusStation) -> None:
        self._station = station
        self._framer = FramerSocket(DecodePDU(True))
        self._tail = b""

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        """Keep the transport, which the station closes at its end."""
        assert isinstance(transport, asyncio.Transport)
        self.transport = transport
        self._station.transports.add(transport)

    def connection_lost(self, exc: Exception | None) -> None:  # noqa: ARG002  (as asyncio calls it)
        """Forget the transport; if this connection commanded, another may command from now on."""
        self._station.transports.discard(self.transport)
        if self._station.master is self:
            self._station.master = None

    def data_received(self, data: bytes) -> None:
        """Answer all whole requests among the received bytes; close the connection once it is out of sync.

        A request that pymodbus can't decode is refused as an illegal function, and the bytes with it are dropped.
        """
        self._tail += data
        try:
            while True:
                used, request = self._framer.handleFrame(self._tail, 0, 0)
                self._tail = self._tail[used:]
                if request is None:
                    break
                self._station.answer(self, request)
        except ModbusIOException as error:
            refused = ModbusPDU(error.dev_id, error.transaction_id)
            refused.function_code = self._tail[7] & 0x7F
            self.transport.write(self.frame(refused, _refusal(refused, ExcCodes.ILLEGAL_FUNCTION)))
            self._tail = b""
        if self._tail[2:4].strip(b"\0") or len(self._tail) > FramerSocket.MAX_SIZE:
            # Out of sync: only a new connection starts at the beginning of a frame.
            self.transport.close()

    def frame(self, request: ModbusPDU, reply: ModbusPDU) -> bytes:
        """Return a reply as a frame, after its number and unit are set to those of the request."""
        reply.transaction_id, reply.dev_id = request.transaction_id, request.dev_id
        return self._framer.buildFrame(reply)


def _refusal(request: ModbusPDU, code: ExcCodes) -> ModbusPDU:
    return ExceptionResponse(request.function_code, code)
