"""What lies between the controller and the joints: converters, the device's watchdog, and how to talk to it.

The device is what the wires end in: a remote I/O station, or a microcontroller.
"""

from typing import Annotated

from pydantic import AfterValidator, Field

from layflat.description import Part
from layflat.description import units as u

MOST_OUTPUTS = 8  # a command has bits for so many

Register = Annotated[int, Field(ge=0, le=65535)]


def _all_different(names: tuple[str, ...]) -> tuple[str, ...]:
    twice = next((name for name in names if names.count(name) > 1), None)
    if twice is not None:
        raise ValueError(f"{twice!r} is there twice; give each output a name of its own")
    return names


OutputName = Annotated[str, Field(pattern=r"^[A-Za-z][A-Za-z0-9 _-]{0,23}$")]
OutputNames = Annotated[tuple[OutputName, ...], Field(max_length=MOST_OUTPUTS), AfterValidator(_all_different)]


class ModbusLink(Part):
    """Registers of a Modbus station; all are 16 bits wide, in the order that docs/rig-wires.md gives."""

    unit: Annotated[int, Field(ge=0, le=255)] = 1
    commands: Register = Field(default=0, description="first register that is written")
    readings: Register = Field(default=0, description="first register that is read; it may be the same number")
    identity: Register = Field(default=256, description="first of the registers that say what rig it is; read once")
    timeout: u.ShortTime = Field(default=3e-3, description="after which a reply is lost")


class SerialLink(Part):
    """A microcontroller on USB."""

    baud: Annotated[int, Field(ge=9600, le=12_000_000)] = 921_600
    timeout: u.ShortTime = Field(default=3e-3, description="after which a reply is lost")


class Interface(Part):
    """Converters and device; the sensors' own ranges and bits stand with the sensors."""

    voltage_bits: Annotated[int, Field(ge=8, le=16)] = Field(default=16, description="of the voltages to the valves")
    supply_range_gauge: u.PositivePressure = Field(default=10e5, description="of the sensor of the supply's pressure")
    supply_bits: Annotated[int, Field(ge=4, le=16)] = 12
    watchdog_cycles: Annotated[int, Field(ge=2, le=100)] = Field(
        default=4, description="control cycles without a command, after which the device centres the valves"
    )
    dump_after: u.ShortTime = Field(default=0.2, description="without a command, after which it lets out the air")
    outputs: OutputNames = Field(
        default=(), description="digital outputs for tools, by name; off where the device has dumped"
    )
    modbus: ModbusLink = Field(default_factory=ModbusLink)
    serial: SerialLink = Field(default_factory=SerialLink)
