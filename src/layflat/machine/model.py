"""The whole machine: joints in an arm, with valve, supply, sensors and controller."""

from __future__ import annotations

from typing import Annotated, Literal, Self

from pydantic import Discriminator, Field, PrivateAttr, Tag, model_validator

from layflat.description import Part
from layflat.description import units as u
from layflat.description.names import Key, Name
from layflat.description.provenance import Provenance
from layflat.machine.interface import Interface
from layflat.machine.parts import Joint
from layflat.machine.safety import Safety
from layflat.physics.delay import LONGEST

CYCLE = 0.005
"""Cycle of a machine without a controller, s: the paper's."""


class Supply(Part):
    """Air supply and surroundings."""

    pressure_gauge: u.PositivePressure
    temperature: u.Temperature
    ambient_pressure: u.PositivePressure = Field(description="absolute")
    ambient_temperature: u.Temperature

    @property
    def pressure(self) -> float:
        """Absolute supply pressure, Pa."""
        return self.pressure_gauge + self.ambient_pressure


class Dither(Part):
    """What the driver adds to keep the spool moving."""

    amplitude: u.Share = Field(description="share of full opening")
    frequency: u.Frequency


class Valve(Part):
    """What every valve has, with its driver; there is one per joint."""

    conductance: u.Conductance = Field(description="ISO 6358 sonic conductance of a fully open path")
    critical_ratio: Annotated[u.Share, Field(lt=0.99)] = Field(description="ISO 6358 critical pressure ratio")
    leakage: u.ConductanceOrZero = Field(description="sonic conductance of a closed path")
    centre_voltage: u.Voltage
    volts_to_full: u.PositiveVoltage = Field(description="from the centre to full opening")
    delay: u.TimeOrZero = Field(default=0.0, description="from the command to the driver, at most three control cycles")

    @model_validator(mode="after")
    def _closes(self) -> Self:
        if self.leakage >= self.conductance:
            raise ValueError("leakage must be smaller than conductance")
        return self


class SpoolValve(Valve):
    """A 5/3 proportional spool valve."""

    kind: Literal["spool"] = "spool"
    overlap: Annotated[u.Share, Field(lt=0.9)] = Field(
        description="share of the stroke in which a land covers its port"
    )
    natural_frequency: u.Frequency
    damping_ratio: u.Ratio
    friction: u.Share = Field(description="change of command that the spool's friction can hide, share of full opening")
    dither: Dither


class SwitchingValves(Valve):
    """Two on/off valves under pulse-width modulation: one fills hose A and vents hose B, the other the reverse."""

    kind: Literal["switching"]
    frequency: u.Frequency = Field(description="of the pulses")
    dead_band: Annotated[u.Share, Field(lt=0.9)] = Field(description="command up to which no pulse is given")
    least_pulse: u.TimeOrZero = Field(description="length of the pulse at the edge of the dead band")
    opening_delay: u.Time = Field(description="from voltage on to the plunger's first motion")
    opening_time: u.Time = Field(description="of the plunger's whole way")
    closing_delay: u.Time = Field(description="from voltage off to the plunger's first motion")
    closing_time: u.Time

    @model_validator(mode="after")
    def _pulses_fit(self) -> Self:
        if self.least_pulse * self.frequency >= 1.0:
            raise ValueError("least_pulse must be shorter than the pulses' period, 1 / frequency")
        return self


def _kind_of_valve(described: object) -> object:
    if isinstance(described, dict):
        return described.get("kind", "spool")
    return getattr(described, "kind", None)


AnyValve = Annotated[
    Annotated[SpoolValve, Tag("spool")] | Annotated[SwitchingValves, Tag("switching")],
    Discriminator(_kind_of_valve),
]
"""One of the kinds of valve; a spool valve where the description does not say."""


class AngleSensor(Part):
    """Potentiometer and converter; its range is centred on the joint's mid-stroke."""

    range: u.PositiveAngle
    bits: Annotated[int, Field(ge=4, le=24)]
    noise: Annotated[float, u.ANGLE, Field(ge=0)]
    offset: u.Angle


class PressureSensor(Part):
    """Differential pressure transducer and converter, centred on zero."""

    range: u.PositivePressure
    bits: Annotated[int, Field(ge=4, le=24)]
    noise: u.PressureOrZero
    offset: u.AnyPressure


class Controller(Part):
    """What the controllers of all joints share."""

    cycle: u.Time
    averaged: bool = Field(description="average both signals over four cycles")
    drift_time: u.Time = Field(description="time constant of the long-term integral")
    drift_limit: u.VoltageOrZero = Field(description="greatest correction of the null")
    air_ripple: u.PressureOrZero = Field(description="rule 1: ripple that shows that air is there")
    rest_speed: u.PositiveSpeed = Field(description="rule 2: below it the joint may be at rest")
    rest_time: u.Time = Field(description="rule 2: how long it has to be so slow")
    load_pressure: u.PositivePressure = Field(description="rule 3: below it there is no offset load")


class Arm(Part):
    """How joints make an arm in a plane, from the base to the tip."""

    joints: Annotated[tuple[str, ...], Field(min_length=1, max_length=2)]
    elbow: u.Angle = Field(description="angle between the links when the second joint is in mid-stroke")
    payload: u.Mass
    gravity: u.Acceleration = Field(description="in the arm's plane; zero for an arm that moves horizontally")
    gravity_direction: u.Angle = Field(description="from link 1 at mid-stroke")

    @model_validator(mode="after")
    def _each_once(self) -> Self:
        if len(set(self.joints)) < len(self.joints):
            raise ValueError(f"joints names {self.joints[0]!r} twice; name each joint once")
        return self


class Machine(Part):
    """A validated description. `provenance` gives the source of each value by its dotted path."""

    name: Name
    title: str
    supply: Supply
    joint: dict[Key, Joint]
    arm: Arm
    valve: AnyValve | None = None
    angle_sensor: AngleSensor | None = None
    pressure_sensor: PressureSensor | None = None
    controller: Controller | None = None
    interface: Interface = Interface()
    safety: Safety = Safety()
    _provenance: dict[str, Provenance] = PrivateAttr(default_factory=dict)
    _origin: str = PrivateAttr(default="")

    @model_validator(mode="after")
    def _joined(self) -> Machine:
        missing = [name for name in self.arm.joints if name not in self.joint]
        if missing:
            raise ValueError(f"arm.joints names the unknown joint {missing[0]!r}; joints are {sorted(self.joint)}")
        if self.valve is not None and self.controller is not None:
            longest = LONGEST * self.cycle
            if self.valve.delay > longest:
                raise ValueError(f"valve.delay is longer than three control cycles, {1000 * longest:g} ms")
        return self

    def __eq__(self, other: object) -> bool:
        """Machines are equal if their values are, wherever these come from."""
        return isinstance(other, Machine) and self.__dict__ == other.__dict__

    __hash__ = None  # type: ignore[assignment]  # joints are a table

    @property
    def provenance(self) -> dict[str, Provenance]:
        """Source of each value by its dotted path; "given" where the file does not say."""
        return self._provenance

    @property
    def origin(self) -> str:
        """The file or built-in name that it was loaded from, its own name where there is none: for messages."""
        return self._origin or self.name

    @property
    def cycle(self) -> float:
        """Control cycle, s; without a controller, the time between changes of the valves' voltages."""
        return self.controller.cycle if self.controller is not None else CYCLE

    @property
    def joints(self) -> dict[str, Joint]:
        """The joints that the arm uses, by name, from the base to the tip."""
        return {name: self.joint[name] for name in self.arm.joints}
