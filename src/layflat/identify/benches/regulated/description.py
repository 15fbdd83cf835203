"""A rotary joint between two air chambers, each held by a pressure-regulating valve, on its bench; and what is fitted.

The torque per pressure is held: pressures and angles identify all torques and volumes only in proportion to it; the
supply is known from its gauge.
"""

from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from layflat.description import Part
from layflat.description import units as u
from layflat.identify.benches.contract import BenchDescription
from layflat.identify.unknown import ParameterSpec, around, factor_range, fixed_range, from_zero


class RegulatingValve(Part):
    """A valve that regulates a chamber's pressure to a set-point; both are alike but for their offsets."""

    gain: u.Ratio = Field(description="set-point that it goes for over the one commanded, both above ambient pressure")
    offset: u.AnyPressure = Field(default=0.0, description="what they add to that, on average")
    mismatch: u.AnyPressure = Field(default=0.0, description="how much more that of chamber A adds than that of B")
    delay: u.TimeOrZero = Field(description="from a command to when anything happens")
    lag: u.Time = Field(description="of first order, from the command to the set-point that it works towards")
    conductance_in: u.Conductance = Field(description="ISO 6358 sonic conductance towards the supply, fully open")
    conductance_out: u.Conductance = Field(description="the same towards the exhaust")
    band_in: u.PositivePressure = Field(description="how far below the set-point a pressure is filled fully open")
    band_out: u.PositivePressure = Field(description="how far above it a pressure is vented fully open")
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
    torque: u.AnyTorque = Field(default=0.0, description="that pulls back in the middle of the stroke, as a weight")
    stiffness: u.AnyStiffness = Field(default=0.0, description="by how much this grows with the angle")


class LaggingFriction(Part):
    """Friction whose level follows the angle with a lag; equal levels at both ends leave Coulomb friction."""

    lower_end: u.PositiveTorque = Field(description="torque at which it slides after a long rest at low angles")
    upper_end: u.PositiveTorque = Field(description="the same at high angles")
    change_angle: u.Angle = Field(default=0.0, description="where it is midway between")
    change_width: u.PositiveAngle = Field(
        default=0.2, description="three quarters of this change lie within twice that"
    )
    lag: u.Time = Field(description="with which it forgets where it was")
    static_ratio: Annotated[u.Ratio, Field(ge=1.0)] = Field(default=1.0, description="static over sliding friction")


class Stroke(Part):
    """Angles from the middle of the stroke, over which the sensor reads; beyond it stays at the end of its range."""

    reading: u.PositiveAngle = Field(description="range of the sensor, half of it to each side of the middle")
    lower_stop: u.Angle
    upper_stop: u.Angle

    @model_validator(mode="after")
    def _stops_outside(self) -> Self:
        if not self.lower_stop <= -0.5 * self.reading < 0.5 * self.reading <= self.upper_stop:
            right = 'give them as "-60 deg" and "60 deg" for a reading of "120 deg"'
            raise ValueError(f"stops lie inside the reading; {right}")
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
    friction: LaggingFriction
    stroke: Stroke
    supply: Supply

    @model_validator(mode="after")
    def _holds_air(self) -> Self:
        if self.chamber.volume <= least_volume(self):
            raise ValueError("chamber.volume is less than what it gives off until the stop; give more, such as 30 ml")
        return self


def least_volume(bench: RegulatedJointBench) -> float:
    """Volume in the middle of the stroke that a chamber without any dead volume would have, m3."""
    return bench.chamber.torque_per_pressure * max(-bench.stroke.lower_stop, bench.stroke.upper_stop)


GAIN, OFFSET, DELAY = 1.5, 100e3, 0.15  # farthest gain (either way), offset (Pa) and delay (s) of a valve
MISMATCH = 50e3  # greatest difference of the valves' offsets, Pa, either way
FAR, FARTHER = factor_range(20.0), factor_range(50.0)  # what a person knows within about a factor of four, and all else
LOADS = 400e3  # load torques are searched up to this pressure, Pa, on the torque per pressure
STATIC = 3.0  # greatest static over sliding friction
BEYOND = 0.3  # stops are searched this far beyond the reading, as a share of it

STEPS = "changes of the set-point, up and down"
LARGE = "large steps of the set-point"
MOVES = "moves of different size and speed"
HOLDS = "moves that begin from rest at several angles, both ways"
RESTS = "rests at several set-points"
PAUSES = "rests of different length, followed by moves"
AT_STOP = "moves that leave the end of the reading"

C = "m^3/s/Pa"


def _load(bench: RegulatedJointBench) -> float:
    return LOADS * bench.chamber.torque_per_pressure


def _volumes(bench: RegulatedJointBench, volume: float) -> tuple[float, float, bool]:
    """At least what leaves some air in a chamber wherever the stops are searched."""
    reach = (0.5 + BEYOND) * bench.stroke.reading
    least = max(least_volume(bench), bench.chamber.torque_per_pressure * reach)
    low, high, log = FAR(bench, volume)
    return min(volume, max(low, 1.02 * least)), high, log


def _inside(bench: RegulatedJointBench, angle: float) -> tuple[float, float, bool]:
    half = 0.5 * bench.stroke.reading
    return min(-half, angle), max(half, angle), False


def _stops(bench: RegulatedJointBench, stop: float) -> tuple[float, float, bool]:
    half = 0.5 * bench.stroke.reading
    far = half + 2.0 * BEYOND * half
    return (min(-far, stop), -half, False) if stop < 0.0 else (half, max(far, stop), False)


BLOCKS = {
    "valve": (
        ParameterSpec("valve.gain", "1", factor_range(GAIN), RESTS),
        ParameterSpec("valve.offset", "Pa", around(lambda _: OFFSET), RESTS),
        ParameterSpec("valve.mismatch", "Pa", around(lambda _: MISMATCH), RESTS),
        ParameterSpec("valve.delay", "s", from_zero(lambda _, delay: max(DELAY, 2.0 * delay)), STEPS),
        ParameterSpec("valve.lag", "s", FAR, STEPS),
        ParameterSpec("valve.conductance_in", C, FARTHER, f"{LARGE}, upwards"),
        ParameterSpec("valve.conductance_out", C, FARTHER, f"{LARGE}, downwards"),
        ParameterSpec("valve.band_in", "Pa", FAR, f"{STEPS}, of different size"),
        ParameterSpec("valve.band_out", "Pa", FAR, f"{STEPS}, of different size"),
    ),
    "gas": (
        ParameterSpec("chamber.volume", "m^3", _volumes, "fast moves"),
        ParameterSpec("chamber.wall_conductance", "W/K", FARTHER, LARGE),
    ),
    "motion": (
        ParameterSpec("load.inertia", "kg*m^2", FARTHER, "moves that start and stop fast"),
        ParameterSpec("load.damping", "N*m*s/rad", FARTHER, MOVES),
        ParameterSpec("load.torque", "N*m", around(_load), HOLDS),
        ParameterSpec("load.stiffness", "N*m/rad", around(lambda b: _load(b) / (0.5 * b.stroke.reading)), HOLDS),
        ParameterSpec("friction.lower_end", "N*m", FARTHER, HOLDS),
        ParameterSpec("friction.upper_end", "N*m", FARTHER, HOLDS),
        ParameterSpec("friction.change_angle", "rad", _inside, HOLDS),
        ParameterSpec("friction.change_width", "rad", FAR, HOLDS),
        ParameterSpec("friction.lag", "s", FAR, PAUSES),
        ParameterSpec("friction.static_ratio", "1", fixed_range(1.0, STATIC), HOLDS, floor=True),
        ParameterSpec("stroke.lower_stop", "rad", _stops, AT_STOP, floor=True),
        ParameterSpec("stroke.upper_stop", "rad", _stops, AT_STOP, floor=True),
    ),
}
"""By block; a stop is only fitted where a reading comes to its end."""

DESCRIPTION = RegulatedJointBench
