"""From an address to the driver that speaks its protocol."""

from __future__ import annotations

from urllib.parse import urlsplit

from layflat import extras
from layflat.machine.model import Machine
from layflat.rig.driver import Driver, DriverError

MODBUS_PORT = 502
"""Where stations listen unless told otherwise."""


def driver_of(address: str, machine: Machine) -> Driver:
    """Driver for a rig at an address: "modbus://127.0.0.1:5020" or "serial:///dev/ttyACM0".

    Raises:
        DriverError: it is no such address.
        MissingExtraError: the packages that it takes are not installed.
        MachineError: the machine's description does not suit a rig.
    """
    split = urlsplit(address)
    try:
        if split.scheme == "modbus":
            extras.require("rig", "pymodbus", where=address)
            return _modbus(address, split.hostname, split.port, split.path, machine)
        if split.scheme == "serial":
            extras.require("rig", "serial", "cobs", where=address)
            return _serial(address, split.netloc, split.path, machine)
    except ValueError:
        raise DriverError("has no port", where=address, right="give one from 1 to 65535: modbus://HOST:PORT") from None
    raise DriverError("is no driver's address", where=address, right="give modbus://HOST:PORT or serial:///dev/NAME")


def _modbus(address: str, host: str | None, port: int | None, path: str, machine: Machine) -> Driver:
    from layflat.rig.drivers.modbus import ModbusDriver  # noqa: PLC0415  (needs an extra)

    if not host or path.strip("/"):
        raise DriverError("names no station", where=address, right="give modbus://HOST:PORT")
    return ModbusDriver(machine, host, MODBUS_PORT if port is None else port)


def _serial(address: str, netloc: str, path: str, machine: Machine) -> Driver:
    from layflat.rig.drivers.serial import SerialDriver  # noqa: PLC0415  (needs an extra)

    if netloc or not path.strip("/"):
        raise DriverError("names no device", where=address, right="give its whole path: serial:///dev/ttyACM0")
    return SerialDriver(machine, path)
