"""Drivers by address: creates the driver that speaks the protocol of an address."""

from urllib.parse import urlsplit

from layflat import extras
from layflat.machine.model import Machine
from layflat.rig.driver import Driver, DriverError

__all__ = ["PROTOCOL_PACKAGES", "create_driver"]

PROTOCOL_PACKAGES = {"modbus": ("pymodbus",), "serial": ("serial", "cobs")}  # needed by each protocol
MODBUS_PORT = 502  # default port of stations


def create_driver(address: str, machine: Machine) -> Driver:
    """Return a driver for a rig at an address: "modbus://HOST[:PORT]" (default: 502) or "serial:///dev/ttyACM0".

    Raises:
        DriverError: it is no such address.
        MissingExtraError: the packages that it needs are not installed.
        MachineError: the machine's description does not suit a rig.
    """
    try:
        split = urlsplit(address)
        port = split.port if split.scheme == "modbus" else None
    except ValueError:
        right = "give one from 1 to 65535: modbus://HOST:PORT"
        raise DriverError("has no valid port", where=address, right=right) from None
    if split.scheme not in PROTOCOL_PACKAGES:
        right = "give modbus://HOST:PORT or serial:///dev/NAME"
        raise DriverError("is not a driver's address", where=address, right=right)
    extras.require("rig", *PROTOCOL_PACKAGES[split.scheme], where=address)
    if split.scheme == "modbus":
        from layflat.rig.drivers.modbus import ModbusDriver  # noqa: PLC0415  (needs an extra)

        if not split.hostname or split.path.strip("/"):
            raise DriverError("names no station, or a path in it", where=address, right="give modbus://HOST:PORT")
        return ModbusDriver(machine, split.hostname, MODBUS_PORT if port is None else port)
    from layflat.rig.drivers.serial import SerialDriver  # noqa: PLC0415  (needs an extra)

    if split.netloc or not split.path.strip("/"):
        raise DriverError("names no device", where=address, right="give its whole path: serial:///dev/ttyACM0")
    return SerialDriver(machine, split.path)
