"""A Modbus TCP station with a device behind it.

pymodbus takes frames and requests apart and puts replies together. Its own server answers some turns of its loop later,
which costs a third of a transaction's time, and does not tell one master from another; a station has but one.
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
from layflat.rig.clock import SECOND
from layflat.rig.device.exchange import Station
from layflat.rig.device.link import Spoil
from layflat.rig.device.virtual import VirtualDevice
from layflat.rig.wire.content import WireError
from layflat.rig.wire.identity import Registers

# Noise on the line is nothing to tell of, and would be told for every byte where nobody has set up logging.
logging.getLogger("pymodbus").addHandler(logging.NullHandler())

READ, WRITE, BOTH = (3, 4), 16, 23  # functions that there are


class ModbusStation(Station):
    """Answers functions 3, 4, 16 and 23 of one unit; a master that has fallen silent is told by the device's clock."""

    def __init__(self, device: VirtualDevice, machine: Machine) -> None:
        super().__init__(device, machine, machine.interface.modbus.timeout)
        self._registers = Registers.of(machine)
        self._unit, self._silence = machine.interface.modbus.unit, machine.interface.dump_after * SECOND
        self.master: object = None  # the connection that commands; another may once it has ended, or has been silent
        self._heard = -inf
        self._server: asyncio.Server | None = None
        self.transports: set[asyncio.BaseTransport] = set()

    async def listen(self, host: str, port: int) -> int:
        """Serve from now on; returns the port, which is found if 0 is asked for."""
        self._server = await asyncio.get_running_loop().create_server(lambda: _Connection(self), host, port)
        return int(self._server.sockets[0].getsockname()[1])

    def close(self) -> None:
        """Serve no more, and hang up."""
        if self._server is not None:
            self._server.close()
        for transport in self.transports:
            transport.close()

    def answer(self, connection: "_Connection", request: ModbusPDU) -> None:
        """Reply to a request, unless nothing is heard."""
        link = self.device.link
        if link.silent:
            return
        spoil = link.next()
        try:
            reply = self._reply(connection, request, behind=spoil is Spoil.SEQUENCE)
        except WireError:
            reply = _refusal(request, ExcCodes.ILLEGAL_VALUE)
        except LookupError:
            reply = _refusal(request, ExcCodes.ILLEGAL_ADDRESS)
        # TCP has no damaged bytes; a station that has lost its way sends some all the same.
        self._send(connection.frame(request, reply), spoil, 7, connection.transport.write)

    def _reply(self, master: object, request: Any, behind: bool) -> ModbusPDU:
        """The reply; `behind` puts an old number into it."""
        now, function = self.device.clock.now(), request.function_code
        if request.dev_id != self._unit:
            return _refusal(request, ExcCodes.GATEWAY_NO_RESPONSE)
        if self.master not in (None, master) and now - self._heard < self._silence:
            return _refusal(request, ExcCodes.DEVICE_BUSY)
        self.master, self._heard = master, now
        if function not in (*READ, WRITE, BOTH):
            return _refusal(request, ExcCodes.ILLEGAL_FUNCTION)
        _, response = DecodePDU.pdu_table[function]
        if function == WRITE:
            self._take(request.address, request.registers, request.count)
            return response(address=request.address, count=request.count)
        address, count = request.address, request.count
        if function == BOTH:
            self._take(request.write_address, request.write_registers, request.write_count)
            address, count = request.read_address, request.read_count
        return response(registers=self._tell(address, count, behind))

    def _take(self, address: int, words: Sequence[int], count: int) -> None:
        if address != self._registers.commands.start or count != len(self._registers.commands):
            raise LookupError
        if len(words) != count:
            raise WireError(f"{len(words)} registers where {count} were told")
        self._obey(words[0], words[1:])

    def _tell(self, address: int, count: int, behind: bool) -> list[int]:
        _, readings, identity = self._registers
        if address in readings and 1 <= count <= readings.stop - address:
            words = [((self._last or 0) - behind) & 0xFFFF, *self._read()]
            return words[address - readings.start :][:count]
        if address in identity and 1 <= count <= identity.stop - address:
            return self._identify()[address - identity.start :][:count]
        raise LookupError


class _Connection(asyncio.Protocol):
    """One master's connection."""

    def __init__(self, station: ModbusStation) -> None:
        self._station = station
        self._framer = FramerSocket(DecodePDU(True))
        self._tail = b""

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        assert isinstance(transport, asyncio.Transport)
        self.transport = transport
        self._station.transports.add(transport)

    def connection_lost(self, exc: Exception | None) -> None:  # noqa: ARG002  (as asyncio calls it)
        self._station.transports.discard(self.transport)
        if self._station.master is self:
            self._station.master = None

    def data_received(self, data: bytes) -> None:
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
            # Out of step; only a new connection begins at a frame's beginning.
            self.transport.close()

    def frame(self, request: ModbusPDU, reply: ModbusPDU) -> bytes:
        """A reply to a request as it is sent."""
        reply.transaction_id, reply.dev_id = request.transaction_id, request.dev_id
        return self._framer.buildFrame(reply)


def _refusal(request: ModbusPDU, code: ExcCodes) -> ModbusPDU:
    return ExceptionResponse(request.function_code, code)
