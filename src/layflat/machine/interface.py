"""What lies between the controller and the joints: converters, the device's watchdog, and how to talk to it.

The device is what the wires end in: a remote I/O station, or a microcontroller.
"""

from typing import Annotated

from pydantic import Field

from layflat.description import Part
from layflat.description import units as u

Register = Annotated[int, Field(ge=0, le=65535)]


class ModbusLink(Part):
    """Registers of a Modbus station; all are 16 bits wide, in the order that docs/rig-wires.md gives."""

    unit: Annotated[int, Field(ge=0, le=255)] = 1
    commands: Register = Field(default=0, description="first register that is written")
    readings: Register = Field(default=0, description="first register that is read; it may be the same number")
    identity: Register = Field(default=256, description="first of the registers that say what rig it is; read once")
    timeout: u.Time = Field(default=3e-3, description="after which a reply is lost")


class SerialLink(Part):
    """A microcontroller on USB."""

    baud: Annotated[int, Field(ge=9600, le=12_000_000)] = 921_600
    timeout: u.Time = Field(default=3e-3, description="after which a reply is lost")


class Interface(Part):
    """Converters and device; the sensors' own ranges and bits stand with the sensors."""

    voltage_bits: Annotated[int, Field(ge=8, le=16)] = Field(default=16, description="of the voltages to the valves")
    supply_range_gauge: u.PositivePressure = Field(default=10e5, description="of the sensor of the supply's pressure")
    supply_bits: Annotated[int, Field(ge=4, le=16)] = 12
    watchdog_cycles: Annotated[int, Field(ge=2, le=100)] = Field(
        default=4, description="control cycles without a command, after which the device centres the valves"
    )
    dump_after: u.Time = Field(default=0.2, description="without a command, after which it lets out the air")
    modbus: ModbusLink = Field(default_factory=ModbusLink)
    serial: SerialLink = Field(default_factory=SerialLink)
