"""A rig behind a Modbus TCP station: function 23 writes the command and reads the sensors in one transaction."""

from __future__ import annotations

import logging
import socket
from collections.abc import Sequence

from pymodbus.exceptions import ConnectionException, ModbusIOException
from pymodbus.pdu import ModbusPDU

from layflat.machine.model import Machine
from layflat.rig.driver import DriverError, LinkError
from layflat.rig.drivers.linked import LinkedDriver
from layflat.rig.drivers.modbus_client import PromptClient
from layflat.rig.wire.identity import Identity
from layflat.rig.wire.registers import Registers

CONNECT = 1.0
"""Patience while connecting, s."""
BUSY = 6
"""Exception code of a station that another master drives."""

# A reply that is late is counted by the loop; pymodbus would write a line of its own about each.
logging.getLogger("pymodbus").setLevel(logging.CRITICAL)


class ModbusDriver(LinkedDriver):
    """A rig at a station.

    Args:
        machine: what is driven.
        host: name or number.
        port: of TCP.
    """

    def __init__(self, machine: Machine, host: str, port: int) -> None:
        super().__init__(machine, f"modbus://{host}:{port}")
        self._host, self._port = host, port
        self._registers = Registers.of(machine)
        self._link = machine.interface.modbus
        self._client: PromptClient | None = None

    def _connect(self) -> None:
        try:
            # By number from here on: a cycle must never wait for a name.
            number = socket.getaddrinfo(self._host, self._port, type=socket.SOCK_STREAM)[0][4][0]
            self._client = PromptClient(str(number), self._port, self._link.timeout)
            self._client.open(CONNECT)
        except OSError as error:
            what = "no answer" if isinstance(error, TimeoutError) else error.strerror or str(error)
            raise DriverError(
                f"can't be reached ({what})", where=self.endpoint, right="give host and port of a rig that is on"
            ) from None

    def _identify(self) -> Identity:
        client, at = self._connected(), self._registers.identity
        client.patience = CONNECT
        try:
            reply = client.read_holding_registers(at.start, count=len(at), device_id=self._link.unit)
        except (ConnectionException, ModbusIOException):
            raise DriverError(
                "takes connections but does not answer as a Modbus station", where=self.endpoint, right="try its port"
            ) from None
        finally:
            client.patience = self._link.timeout
        if reply.isError():
            raise self._refused(reply)
        return Identity.from_words(reply.registers)

    def _exchange(self, sequence: int, words: list[int]) -> Sequence[int]:
        commands, readings = self._registers.commands, self._registers.readings
        client = self._connected()
        try:
            reply = client.readwrite_registers(
                read_address=readings.start,
                read_count=len(readings),
                write_address=commands.start,
                values=[sequence, *words],
                device_id=self._link.unit,
            )
        except ModbusIOException:
            raise LinkError("lost" if client.waited_in_vain else "crc") from None
        except (ConnectionException, OSError):
            raise LinkError("lost") from None
        if reply.isError():
            raise LinkError("lost")
        if len(reply.registers) != len(readings):
            raise LinkError("crc")
        if reply.registers[0] != sequence:
            raise LinkError("sequence")
        return reply.registers[1:]

    def _disconnect(self) -> None:
        if self._client is not None:
            self._client.close()

    def _connected(self) -> PromptClient:
        assert self._client is not None
        return self._client

    def _refused(self, reply: ModbusPDU) -> DriverError:
        if reply.exception_code == BUSY:
            return DriverError(
                "is driven by another master", where=self.endpoint, right="one loop drives a rig: end the other first"
            )
        at, unit = self._registers.identity, self._link.unit
        return DriverError(
            f"unit {unit} has no registers {at.start} to {at.stop - 1} (exception {reply.exception_code})",
            where=self.endpoint,
            right="make interface.modbus in the machine's file fit the station",
        )
