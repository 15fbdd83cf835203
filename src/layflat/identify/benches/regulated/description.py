"""A rotary joint between two air chambers, each held by a pressure-regulating valve, on its bench."""

from __future__ import annotations

from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field, model_validator

from layflat.description import Part
from layflat.description import units as u
from layflat.identify.benches.contract import BenchDescription


class RegulatingValve(Part):
    """A valve that regulates a chamber's pressure to a set-point; both are alike."""

    gain: u.Ratio = Field(description="set-point that it goes for over the one commanded, both above ambient pressure")
    offset: u.AnyPressure = Field(default=0.0, description="what it adds to that")
    delay: u.TimeOrZero = Field(description="from a command to when anything happens")
    lag: u.Time = Field(description="of first order, from the command to the set-point that it works towards")
    conductance_in: u.Conductance = Field(description="ISO 6358 sonic conductance towards the supply, fully open")
    conductance_out: u.Conductance = Field(description="the same towards the exhaust")
    band_in: u.PositivePressure = Field(
        description="how far below the set-point the pressure is when it fills fully open"
    )
    band_out: u.PositivePressure = Field(description="how far above it the pressure is when it vents fully open")
    critical_ratio: Annotated[u.Share, Field(lt=0.99)] = Field(description="ISO 6358 critical pressure ratio")


class AirChamber(Part):
    """An air chamber that turns the joint; both are alike."""

    torque_per_pressure: u.Volume = Field(description="K: torque per pressure, which is volume gained per radian")
    volume: u.Volume = Field(description="in the middle of the stroke, with fittings and tube")
    wall_conductance: u.HeatConductance = Field(description="heat flow from wall to air per kelvin")


class Load(Part):
    """What turns with the joint, and what pulls at it."""

    inertia: u.Inertia
    damping: u.Damping
    torque: u.AnyTorque = Field(
        default=0.0, description="that pulls back in the middle of the stroke, as a weight does"
    )
    stiffness: u.AnyStiffness = Field(default=0.0, description="by how much this grows with the angle")


class EndFriction(Part):
    """Coulomb friction that settles slowly at a level between those of the two ends of the stroke."""

    lower_end: u.PositiveTorque = Field(description="torque at which it slips after a long rest at the lower end")
    upper_end: u.PositiveTorque = Field(description="the same at the upper end; in between it is exponential")
    lag: u.Time = Field(description="how long it takes to settle")


class Stroke(Part):
    """Angles from the middle of the stroke, over which the sensor reads; beyond it stays at the end of its range."""

    reading: u.PositiveAngle = Field(description="range of the sensor, half of it to each side of the middle")
    lower_stop: u.Angle
    upper_stop: u.Angle

    @model_validator(mode="after")
    def _stops_outside(self) -> Stroke:
        if not self.lower_stop <= -0.5 * self.reading < 0.5 * self.reading <= self.upper_stop:
            raise ValueError(
                'stops lie inside the reading; give them as "-60 deg" and "60 deg" for a reading of "120 deg"'
            )
        return self


class Supply(Part):
    """Air around the chambers."""

    pressure: u.PositivePressure = Field(description="absolute")
    ambient_pressure: u.PositivePressure
    temperature: u.Temperature = Field(description="of supply, walls and surroundings")


class RegulatedJointBench(BenchDescription):
    """A regulated joint; chamber A turns it forward, chamber B back."""

    kind: Literal["regulated joint"] = "regulated joint"
    valve: RegulatingValve
    chamber: AirChamber
    load: Load
    friction: EndFriction
    stroke: Stroke
    supply: Supply

    @model_validator(mode="after")
    def _holds_air(self) -> RegulatedJointBench:
        if self.chamber.volume <= least_volume(self):
            raise ValueError("chamber.volume is less than what it gives off until the stop; give more, such as 30 ml")
        return self


def least_volume(bench: RegulatedJointBench) -> float:
    """Volume in the middle of the stroke that a chamber without any dead volume would have, m3."""
    return bench.chamber.torque_per_pressure * max(-bench.stroke.lower_stop, bench.stroke.upper_stop)


def friction_law(lower_end: Any, upper_end: Any, reading: float) -> tuple[Any, Any]:
    """Torque in the middle (N m), and fade (1/rad), of frictions at both ends of a reading (rad); numbers or arrays."""
    return np.sqrt(lower_end * upper_end), np.log(lower_end / upper_end) / reading


DESCRIPTION = RegulatedJointBench
