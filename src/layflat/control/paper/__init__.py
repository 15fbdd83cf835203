"""The paper's control law: its tables in a machine's file, and the law's settings that follow from them."""

from collections.abc import Callable
from typing import Any, Literal

from pydantic import Field

from layflat.control.kind import ControlKind, ControllerPart
from layflat.control.paper.law import (
    SIGNALS,
    DescribedLoad,
    FeedbackGains,
    Gains,
    NoLoad,
    Report,
    Settings,
    centre_shift,
    step,
    wake,
)
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
    load_compensation: bool = Field(
        default=False, description="take off the differential pressure that holds the described arm at its demand"
    )


class PhaseGains(Part):
    """Gains of one phase of a move."""

    error: u.ErrorGain
    pressure: u.PressureGain


class Threshold(Part):
    """Error and speed below which a phase holds."""

    error: u.PositiveAngle
    speed: u.PositiveSpeed


class PaperGainsPart(Part):
    """Gains of Eq. (2) for one joint: three phases, their thresholds, and the short-term integral."""

    far: PhaseGains
    near: PhaseGains
    close: PhaseGains
    near_below: Threshold
    close_below: Threshold
    integral: u.IntegralGain
    integral_limit: u.VoltageOrZero


def paper_settings(shared: PaperControllerPart, machine: Any, plant: Callable[[], tuple[Any, Any, Any]]) -> Settings:
    """Return the settings of the law for a machine.

    Args:
        shared: table of the controller.
        machine: the machine that it controls.
        plant: function that returns the parameters of the plant's laws: arm, joints and surroundings.

    Raises:
        MachineError: a joint has no gains.
    """
    load = DescribedLoad(*plant()) if shared.load_compensation else NoLoad()
    return Settings(tuple(_joint_gains(shared, machine, name) for name in machine.joints), load)


def _joint_gains(shared: PaperControllerPart, machine: Any, name: str) -> Gains:
    """Return the settings of the law for a joint: its gains, and the limits that follow from its valve.

    Raises:
        MachineError: the joint has no gains.
    """
    gains, valve = machine.joint[name].gains, machine.valve
    if gains is None:
        raise MachineError(
            "has no controller gains", where=f"{machine.origin}: joint.{name}.gains", right="copy those of paper-arm"
        )
    return Gains(
        FeedbackGains(gains.far.error, gains.far.pressure),
        FeedbackGains(gains.near.error, gains.near.pressure),
        FeedbackGains(gains.close.error, gains.close.pressure),
        gains.near_below.error,
        gains.near_below.speed,
        gains.close_below.error,
        gains.close_below.speed,
        valve.centre_voltage,
        gains.integral,
        gains.integral_limit,
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
    """Return zero gains of a joint that the law only observes, for open-loop runs of machines without gains."""
    no_gains, centre, span = FeedbackGains(0.0, 0.0), valve.centre_voltage, valve.volts_to_full
    thresholds = (1.0, 1.0, 0.1, 0.1)
    drift = (1.0, 0.0, 0.0, 1.0, 1.0, 1.0)
    return Gains(no_gains, no_gains, no_gains, *thresholds, centre, 0.0, 0.0, *drift, centre - span, centre + span, 1.0)


__all__ = ["KIND", "PaperGainsPart", "idle_gains"]

KIND = ControlKind(
    name="paper",
    description=PaperControllerPart,
    gains=PaperGainsPart,
    parameters=paper_settings,
    models_plant=True,
    parameter_types=(Settings,),
    wake=wake,
    step=step,
    report=Report,
    signals=SIGNALS,
    centre_shift=centre_shift,
)
