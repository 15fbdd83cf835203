"""A Modbus TCP station with a device behind it.

pymodbus takes frames and requests apart and puts replies together. Its own server answers some turns of its loop later,
which costs a third of a transaction's time, and does not tell one master from another; a station has but one.
"""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Callable, Sequence

from pymodbus.constants import ExcCodes
from pymodbus.exceptions import ModbusIOException
from pymodbus.framer import FramerSocket
from pymodbus.pdu import DecodePDU, ExceptionResponse, ModbusPDU
from pymodbus.pdu.register_message import (
    ReadHoldingRegistersRequest,
    ReadHoldingRegistersResponse,
    ReadInputRegistersRequest,
    ReadInputRegistersResponse,
    ReadWriteMultipleRegistersRequest,
    ReadWriteMultipleRegistersResponse,
    WriteMultipleRegistersRequest,
    WriteMultipleRegistersResponse,
)

from layflat.machine.model import Machine
from layflat.rig.device.exchange import LATE, Device, Exchange
from layflat.rig.device.link import Link, Spoil
from layflat.rig.wire.converter import WireError
from layflat.rig.wire.registers import Registers

# Noise on the line is nothing to tell of, and would be told for every byte where nobody has set up logging.
logging.getLogger("pymodbus").addHandler(logging.NullHandler())


class ModbusStation:
    """Answers functions 3, 4, 16 and 23 of one unit.

    Args:
        device: what is behind it.
        machine: its description.
        now: seconds; by it a master that has fallen silent is told from one that is there.
    """

    def __init__(self, device: Device, machine: Machine, now: Callable[[], float]) -> None:
        self._exchange = Exchange(device, machine)
        self._registers = Registers.of(machine)
        self._own, self._now = machine.interface, now
        self._master: object = None
        self._heard = float("-inf")
        self._server: asyncio.Server | None = None
        self._transports: set[asyncio.BaseTransport] = set()

    async def listen(self, host: str, port: int) -> int:
        """Serve from now on; returns the port, which is found if 0 is asked for."""
        self._server = await asyncio.get_running_loop().create_server(lambda: _Connection(self), host, port)
        return int(self._server.sockets[0].getsockname()[1])

    def close(self) -> None:
        """Serve no more, and hang up."""
        if self._server is not None:
            self._server.close()
        for transport in self._transports:
            transport.close()

    @property
    def patience(self) -> float:
        """How long the host waits for a reply, s."""
        return self._own.modbus.timeout

    def came(self, transport: asyncio.BaseTransport) -> None:
        """There is a connection."""
        self._transports.add(transport)

    def left(self, master: object, transport: asyncio.BaseTransport) -> None:
        """It has ended; if it was the master's, another may come at once."""
        self._transports.discard(transport)
        if self._master is master:
            self._master = None

    @property
    def link(self) -> Link:
        """How well the wires do."""
        return self._exchange.device.link

    def answer(self, master: object, request: ModbusPDU, behind: int) -> ModbusPDU:
        """Reply to a request; `behind` puts an old number into it."""
        if request.dev_id != self._own.modbus.unit:
            return _refusal(request, ExcCodes.GATEWAY_NO_RESPONSE)
        if self._master not in (None, master) and self._now() - self._heard < self._own.dump_after:
            return _refusal(request, ExcCodes.DEVICE_BUSY)
        self._master, self._heard = master, self._now()
        try:
            return self._reply(request, behind)
        except WireError:
            return _refusal(request, ExcCodes.ILLEGAL_VALUE)
        except LookupError:
            return _refusal(request, ExcCodes.ILLEGAL_ADDRESS)

    def _reply(self, request: ModbusPDU, behind: int) -> ModbusPDU:
        match request:
            case ReadWriteMultipleRegistersRequest():
                self._write(request.write_address, request.write_registers, request.write_count)
                words = self._read(request.read_address, request.read_count, behind)
                return ReadWriteMultipleRegistersResponse(registers=words)
            case WriteMultipleRegistersRequest():
                self._write(request.address, request.registers, request.count)
                return WriteMultipleRegistersResponse(address=request.address, count=request.count)
            case ReadInputRegistersRequest():
                return ReadInputRegistersResponse(registers=self._read(request.address, request.count, behind))
            case ReadHoldingRegistersRequest():
                return ReadHoldingRegistersResponse(registers=self._read(request.address, request.count, behind))
        return _refusal(request, ExcCodes.ILLEGAL_FUNCTION)

    def _write(self, address: int, words: Sequence[int], count: int) -> None:
        if address != self._registers.commands.start or count != len(self._registers.commands):
            raise LookupError
        if len(words) != count:
            raise WireError(f"{len(words)} registers where {count} were told")
        self._exchange.obey(words[0], words[1:])

    def _read(self, address: int, count: int, behind: int) -> list[int]:
        _, readings, identity = self._registers
        if address in readings and 1 <= count <= readings.stop - address:
            words = [(self._exchange.last - behind) & 0xFFFF, *self._exchange.reading()]
            return words[address - readings.start :][:count]
        if address in identity and 1 <= count <= identity.stop - address:
            return self._exchange.identity()[address - identity.start :][:count]
        raise LookupError


class _Connection(asyncio.Protocol):
    """One master's connection."""

    def __init__(self, station: ModbusStation) -> None:
        self._station = station
        self._framer = FramerSocket(DecodePDU(True))
        self._tail = b""

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        assert isinstance(transport, asyncio.Transport)
        self._transport = transport
        self._station.came(transport)

    def connection_lost(self, exc: Exception | None) -> None:  # noqa: ARG002  (as asyncio calls it)
        self._station.left(self, self._transport)

    def data_received(self, data: bytes) -> None:
        self._tail += data
        try:
            while True:
                used, request = self._framer.handleFrame(self._tail, 0, 0)
                self._tail = self._tail[used:]
                if request is None:
                    break
                self._answer(request)
        except ModbusIOException as error:
            refused = ModbusPDU(error.dev_id, error.transaction_id)
            refused.function_code = self._tail[7] & 0x7F
            self._send(refused, _refusal(refused, ExcCodes.ILLEGAL_FUNCTION))
            self._tail = b""
        if self._tail[2:4].strip(b"\0") or len(self._tail) > FramerSocket.MAX_SIZE:
            # Out of step; only a new connection begins at a frame's beginning.
            self._transport.close()

    def _answer(self, request: ModbusPDU) -> None:
        if self._station.link.silent:
            return
        spoil = self._station.link.next()
        self._send(request, self._station.answer(self, request, behind=spoil is Spoil.SEQUENCE), spoil)

    def _send(self, request: ModbusPDU, reply: ModbusPDU, spoil: Spoil | None = None) -> None:
        reply.transaction_id, reply.dev_id = request.transaction_id, request.dev_id
        frame = self._framer.buildFrame(reply)
        if spoil is Spoil.CRC:
            # TCP has no damaged bytes; a station that has lost its way sends some all the same.
            frame = frame[:7] + bytes([frame[7] ^ 0x40]) + frame[8:]
        if spoil is Spoil.LATE:
            delay = LATE * self._station.patience
            asyncio.get_running_loop().call_later(delay, self._transport.write, frame)
        elif spoil is not Spoil.LOST:
            self._transport.write(frame)


def _refusal(request: ModbusPDU, code: ExcCodes) -> ModbusPDU:
    return ExceptionResponse(request.function_code, code)
