"""What a machine's file says of the paper's control law, and the law's settings that follow."""

from collections.abc import Callable
from typing import Any, Literal

from pydantic import Field

from layflat.control.kind import ControllerPart
from layflat.control.paper.gains import DescribedLoad, Gains, NoLoad, Phase, Settings
from layflat.description import Part
from layflat.description import units as u
from layflat.errors import MachineError


class PaperControllerPart(ControllerPart):
    """Settings that the controllers of all joints share."""

    kind: Literal["paper"] = "paper"
    averaged: bool = Field(description="average both signals over four cycles")
    drift_time: u.Time = Field(description="time constant of the long-term integral")
    drift_limit: u.VoltageOrZero = Field(description="greatest correction of the null")
    air_ripple: u.PressureOrZero = Field(description="rule 1: ripple that shows that air is there")
    rest_speed: u.PositiveSpeed = Field(description="rule 2: below it the joint may be at rest")
    rest_time: u.Time = Field(description="rule 2: how long it has to be so slow")
    load_pressure: u.PositivePressure = Field(description="rule 3: below it there is no offset load")
    known_load: bool = Field(
        default=False, description="take off the differential pressure that holds the described arm at its demand"
    )


class PhaseGains(Part):
    """Gains of one phase of a move."""

    error: u.ErrorGain
    pressure: u.PressureGain


class Threshold(Part):
    """A phase holds below this error and this speed."""

    error: u.PositiveAngle
    speed: u.PositiveSpeed


class PaperGainsPart(Part):
    """Eq. (2) for one joint: three phases, where they begin, and the short-term integral."""

    far: PhaseGains
    near: PhaseGains
    close: PhaseGains
    near_below: Threshold
    close_below: Threshold
    integral: u.IntegralGain
    integral_limit: u.VoltageOrZero


def settings(shared: PaperControllerPart, machine: Any, plant: Callable[[], tuple[Any, Any, Any]]) -> Settings:
    """Settings of every joint; raise MachineError if a joint has no gains."""
    load = DescribedLoad(*plant()) if shared.known_load else NoLoad()
    return Settings(tuple(_gains(shared, machine, name) for name in machine.joints), load)


def _gains(shared: PaperControllerPart, machine: Any, name: str) -> Gains:
    own, valve = machine.joint[name].gains, machine.valve
    if own is None:
        raise MachineError(
            "has no controller gains", where=f"{machine.origin}: joint.{name}.gains", right="copy those of paper-arm"
        )
    return Gains(
        Phase(own.far.error, own.far.pressure),
        Phase(own.near.error, own.near.pressure),
        Phase(own.close.error, own.close.pressure),
        own.near_below.error,
        own.near_below.speed,
        own.close_below.error,
        own.close_below.speed,
        valve.centre_voltage,
        own.integral,
        own.integral_limit,
        shared.drift_time,
        shared.drift_limit,
        shared.air_ripple,
        shared.rest_speed,
        shared.rest_time,
        shared.load_pressure,
        valve.centre_voltage - valve.volts_to_full,
        valve.centre_voltage + valve.volts_to_full,
        1.0 if shared.averaged else 0.0,
    )


def idle_gains(valve: Any) -> Gains:
    """Settings of a joint that the law only watches, for open-loop runs of machines without gains."""
    nothing, centre, span = Phase(0.0, 0.0), valve.centre_voltage, valve.volts_to_full
    thresholds = (1.0, 1.0, 0.1, 0.1)
    drift = (1.0, 0.0, 0.0, 1.0, 1.0, 1.0)
    return Gains(nothing, nothing, nothing, *thresholds, centre, 0.0, 0.0, *drift, centre - span, centre + span, 1.0)
