"""Interface between controller and joints of a rig, and the limits that its supervisor enforces.

The interface has converters, the device's watchdog and its communication; the device is a remote I/O station or a
microcontroller. Reasons for the limits are given in docs/rig-faults.md.
"""

from math import radians
from typing import Annotated

from pydantic import AfterValidator, Field

from layflat.description import Part, ordered
from layflat.description import units as u

MAX_OUTPUTS = 8  # digital outputs, for which a command has bits

Register = Annotated[int, Field(ge=0, le=65535)]


def _check_distinct(names: tuple[str, ...]) -> tuple[str, ...]:
    """Return the names of the outputs; raise ValueError if one is there twice."""
    twice = next((name for name in names if names.count(name) > 1), None)
    if twice is not None:
        raise ValueError(f"{twice!r} is there twice; give each output a name of its own")
    return names


OutputName = Annotated[str, Field(pattern=r"^[A-Za-z][A-Za-z0-9 _-]{0,23}$")]
OutputNames = Annotated[tuple[OutputName, ...], Field(max_length=MAX_OUTPUTS), AfterValidator(_check_distinct)]


class ModbusLink(Part):
    """Registers of a Modbus station, 16 bits each, in the order of docs/rig-wires.md."""

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
    """Converters and device; ranges and bits of the sensors are described with the sensors."""

    voltage_bits: Annotated[int, Field(ge=8, le=16)] = Field(default=16, description="of the voltages to the valves")
    supply_range_gauge: u.PositivePressure = Field(default=10e5, description="of the sensor of the supply's pressure")
    supply_bits: Annotated[int, Field(ge=4, le=16)] = 12
    watchdog_cycles: Annotated[int, Field(ge=2, le=100)] = Field(
        default=4, description="control cycles without a command, after which the device centres the valves"
    )
    dump_after: u.ShortTime = Field(default=0.2, description="without a command, after which it vents the hoses")
    outputs: OutputNames = Field(
        default=(), description="digital outputs for tools, by name; off where the device has dumped"
    )
    modbus: ModbusLink = Field(default_factory=ModbusLink)
    serial: SerialLink = Field(default_factory=SerialLink)


class Safety(Part):
    """Limits of a rig; detection times of the faults are in rig/safety/faults.py."""

    supply_low: u.Share = Field(
        default=0.5, description="fraction of the supply's gauge pressure below which the supply is lost"
    )
    supply_ready: u.Share = Field(
        default=0.8, description="fraction of the supply's gauge pressure for which a soft start waits"
    )
    overpressure: Annotated[float, Field(gt=1.0, le=2.0)] = Field(
        default=1.25,
        description="of the supply's gauge pressure, above which supply or differential pressure is too high: a hose "
        "that a moving arm squeezes holds little more than the supply",
    )
    speed: u.PositiveSpeed = Field(
        default=radians(800.0), description="above it a joint runs away; a light arm's elbow reaches 700 deg/s"
    )
    overrun: u.Share = Field(
        default=0.9, description="of the range from the working to the mechanical stroke; past it a joint is outside"
    )
    following_error: u.PositiveAngle = Field(
        default=radians(35.0), description="limit for a slow joint; motion of the base can deflect the elbow by 25 deg"
    )
    following_time: u.TimeOrZero = Field(
        default=0.1, description="growth of that limit with speed: about the time in which a joint stops"
    )
    demand_step: u.PositiveAngle = Field(
        default=radians(45.0), description="maximum step of a demand; the paper's moves are steps of 40 deg"
    )
    demand_margin: Annotated[float, Field(gt=0.0, le=10.0)] = Field(
        default=0.9,
        description="maximum step over the angle left between any joint and its stop: joints accelerate each other",
    )
    demand_speed: u.PositiveSpeed = Field(
        default=radians(60.0), description="of demands beyond that step; all joints without a fault keep up with it"
    )
    setpoint_age: u.ShortTime = Field(default=0.1, description="after which the host's demands are stale")
    air_residual: Annotated[u.Share, Field(gt=0.0)] = Field(
        default=0.25,
        description="air flow of hoses that their valve's command does not explain, as an opening of it; without a "
        "fault it stays below 0.14, and below 0.25 with a centre that is off by 8 % of full opening",
    )
    start_time: u.ShortTime = Field(default=5.0, description="in which a soft start has to reach `supply_ready`")
    hold_time: u.ShortTime = Field(
        default=0.5, description="for which a controlled stop holds the joints before they are vented"
    )
    vent_time: u.ShortTime = Field(
        default=1.5,
        description="in which hoses vent through open valves; an arm that would fall is lowered in five times that",
    )

    _starts = ordered("supply_low", "supply_ready", "supply_ready must be above supply_low, for example 0.8 and 0.5")
