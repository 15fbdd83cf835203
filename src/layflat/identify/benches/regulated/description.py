"""Rotary joint between two air chambers, each with a pressure-regulating valve, on its bench; and its unknowns.

The torque per pressure is held: pressures and angles identify all torques and volumes only in proportion to it; the
supply is known from its gauge.
"""

from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from layflat.description import Part
from layflat.description import units as u
from layflat.identify.benches import BenchDescription
from layflat.identify.model import ParameterSpec, factor_range, fixed_range, symmetric_range, zero_range


class RegulatingValve(Part):
    """Valve that regulates a chamber's pressure to a set-point; both are alike but for their offsets."""

    gain: u.Ratio = Field(description="regulated set-point over the commanded one, both above ambient pressure")
    offset: u.AnyPressure = Field(default=0.0, description="mean offset of both valves' set-points")
    mismatch: u.AnyPressure = Field(default=0.0, description="offset of chamber A's valve less that of B's")
    delay: u.TimeOrZero = Field(description="dead time after a command")
    lag: u.Time = Field(description="of first order, from the command to the regulated set-point")
    conductance_in: u.Conductance = Field(description="ISO 6358 sonic conductance to the supply, fully open")
    conductance_out: u.Conductance = Field(description="the same to the exhaust")
    band_in: u.PositivePressure = Field(description="error below the set-point at which it fills fully open")
    band_out: u.PositivePressure = Field(description="error above it at which it vents fully open")
    critical_ratio: Annotated[u.Share, Field(lt=0.99)] = Field(description="ISO 6358 critical pressure ratio")


class AirChamber(Part):
    """Air chamber that drives the joint; both are alike."""

    torque_per_pressure: u.Volume = Field(description="K: torque per pressure, which is volume gained per radian")
    volume: u.Volume = Field(description="in the middle of the stroke, with fittings and tube")
    wall_conductance: u.HeatConductance = Field(description="heat flow from wall to air per kelvin")


class Load(Part):
    """Inertia that rotates with the joint, and load torques."""

    inertia: u.Inertia
    damping: u.Damping
    torque: u.AnyTorque = Field(
        default=0.0, description="load torque in the middle of the stroke, against forward motion, such as a weight's"
    )
    stiffness: u.AnyStiffness = Field(default=0.0, description="growth of this torque with the angle")


class LaggingFrictionPart(Part):
    """Friction whose level follows the angle with a lag; equal levels at both ends leave Coulomb friction."""

    lower_end: u.PositiveTorque = Field(description="torque at which it slides after a long rest at low angles")
    upper_end: u.PositiveTorque = Field(description="the same at high angles")
    change_angle: u.Angle = Field(default=0.0, description="angle at which it is midway between")
    change_width: u.PositiveAngle = Field(default=0.2, description="76 % of the change lie within twice this angle")
    lag: u.Time = Field(description="time constant of the angle that it follows")
    static_ratio: Annotated[u.Ratio, Field(ge=1.0)] = Field(default=1.0, description="static over sliding friction")


class ReadableStroke(Part):
    """Angles from the middle of the stroke: the sensor's range, at whose ends its reading saturates, and the stops."""

    reading: u.PositiveAngle = Field(description="range of the sensor, half of it to each side of the middle")
    lower_stop: u.Angle
    upper_stop: u.Angle

    @model_validator(mode="after")
    def _check_stops(self) -> Self:
        """Raise ValueError unless the stops lie outside the range of the reading."""
        if not self.lower_stop <= -0.5 * self.reading < 0.5 * self.reading <= self.upper_stop:
            right = 'give them as "-60 deg" and "60 deg" for a reading of "120 deg"'
            raise ValueError(f"stops lie inside the reading; {right}")
        return self


class BenchSupply(Part):
    """Air around the chambers."""

    pressure: u.PositivePressure = Field(description="absolute")
    ambient_pressure: u.PositivePressure
    temperature: u.Temperature = Field(description="of supply, walls and surroundings")


class RegulatedJointBench(BenchDescription):
    """Bench of a regulated joint; chamber A drives it forward, chamber B back."""

    kind: Literal["regulated joint"] = "regulated joint"
    valve: RegulatingValve
    chamber: AirChamber
    load: Load
    friction: LaggingFrictionPart
    stroke: ReadableStroke
    supply: BenchSupply

    @model_validator(mode="after")
    def _check_chamber_volume(self) -> Self:
        """Raise ValueError if the chamber's volume would vanish before the stop."""
        if self.chamber.volume <= min_volume(self):
            raise ValueError(
                f"chamber.volume would vanish before a stop; give more than {1e6 * min_volume(self):.3g} ml"
            )
        return self


def min_volume(bench: RegulatedJointBench) -> float:
    """Return the volume in the middle of the stroke, m3, of a chamber whose volume is zero at the farther stop."""
    return bench.chamber.torque_per_pressure * max(-bench.stroke.lower_stop, bench.stroke.upper_stop)


MAX_GAIN_RATIO, MAX_OFFSET, MAX_DELAY = 1.5, 100e3, 0.15  # of a valve: gain over the described one, Pa either way, s
MAX_MISMATCH = 50e3  # greatest difference of the valves' offsets, Pa, either way
WIDE_RANGE, WIDEST_RANGE = factor_range(20.0), factor_range(50.0)  # of what is known within a factor of 4, and others
MAX_LOAD_PRESSURE = 400e3  # load torques are searched up to this pressure, Pa, times the torque per pressure
MAX_STATIC_RATIO = 3.0  # static over sliding friction
MAX_STOP_MARGIN = 0.3  # stops are searched this far beyond the sensor's range, as a fraction of it

SETPOINT_CHANGES = "changes of the set-point, up and down"
LARGE_STEPS = "large steps of the set-point"
VARIED_MOVES = "moves of different size and speed"
MOVES_FROM_REST = "moves that begin from rest at several angles, both ways"
SETPOINT_RESTS = "rests at several set-points"
VARIED_RESTS = "rests of different length, followed by moves"
MOVES_FROM_STOP = "moves that leave the end of the reading"

CONDUCTANCE_UNIT = "m^3/s/Pa"


def _max_load_torque(bench: RegulatedJointBench) -> float:
    return MAX_LOAD_PRESSURE * bench.chamber.torque_per_pressure


def _volume_range(bench: RegulatedJointBench, volume: float) -> tuple[float, float, bool]:
    """Return lower and upper bound of the volume, m3, and that it is searched logarithmically.

    The lower one leaves air in a chamber wherever the stops are searched, unless less volume is described.
    """
    reach = (0.5 + MAX_STOP_MARGIN) * bench.stroke.reading
    lower = max(min_volume(bench), bench.chamber.torque_per_pressure * reach)
    low, high, log = WIDE_RANGE(bench, volume)
    return min(volume, max(low, 1.02 * lower)), high, log


def _angle_range(bench: RegulatedJointBench, angle: float) -> tuple[float, float, bool]:
    """Return the range of an angle, searched linearly: that of the sensor, extended to the described angle."""
    half = 0.5 * bench.stroke.reading
    return min(-half, angle), max(half, angle), False


def _stop_range(bench: RegulatedJointBench, stop: float) -> tuple[float, float, bool]:
    """Return the range of a stop, searched linearly: from the end of the reading out, past the described stop."""
    half = 0.5 * bench.stroke.reading
    far = half + 2.0 * MAX_STOP_MARGIN * half
    return (min(-far, stop), -half, False) if stop < 0.0 else (half, max(far, stop), False)


REGULATED_BLOCKS = {
    "valve": (
        ParameterSpec("valve.gain", "1", factor_range(MAX_GAIN_RATIO), SETPOINT_RESTS),
        ParameterSpec("valve.offset", "Pa", symmetric_range(lambda _: MAX_OFFSET), SETPOINT_RESTS),
        ParameterSpec("valve.mismatch", "Pa", symmetric_range(lambda _: MAX_MISMATCH), SETPOINT_RESTS),
        ParameterSpec("valve.delay", "s", zero_range(lambda _, delay: max(MAX_DELAY, 2.0 * delay)), SETPOINT_CHANGES),
        ParameterSpec("valve.lag", "s", WIDE_RANGE, SETPOINT_CHANGES),
        ParameterSpec("valve.conductance_in", CONDUCTANCE_UNIT, WIDEST_RANGE, f"{LARGE_STEPS}, upwards"),
        ParameterSpec("valve.conductance_out", CONDUCTANCE_UNIT, WIDEST_RANGE, f"{LARGE_STEPS}, downwards"),
        ParameterSpec("valve.band_in", "Pa", WIDE_RANGE, f"{SETPOINT_CHANGES}, of different size"),
        ParameterSpec("valve.band_out", "Pa", WIDE_RANGE, f"{SETPOINT_CHANGES}, of different size"),
    ),
    "gas": (
        ParameterSpec("chamber.volume", "m^3", _volume_range, "fast moves"),
        ParameterSpec("chamber.wall_conductance", "W/K", WIDEST_RANGE, LARGE_STEPS),
    ),
    "motion": (
        ParameterSpec("load.inertia", "kg*m^2", WIDEST_RANGE, "moves that start and stop fast"),
        ParameterSpec("load.damping", "N*m*s/rad", WIDEST_RANGE, VARIED_MOVES),
        ParameterSpec("load.torque", "N*m", symmetric_range(_max_load_torque), MOVES_FROM_REST),
        ParameterSpec(
            "load.stiffness",
            "N*m/rad",
            symmetric_range(lambda b: _max_load_torque(b) / (0.5 * b.stroke.reading)),
            MOVES_FROM_REST,
        ),
        ParameterSpec("friction.lower_end", "N*m", WIDEST_RANGE, MOVES_FROM_REST),
        ParameterSpec("friction.upper_end", "N*m", WIDEST_RANGE, MOVES_FROM_REST),
        ParameterSpec("friction.change_angle", "rad", _angle_range, MOVES_FROM_REST),
        ParameterSpec("friction.change_width", "rad", WIDE_RANGE, MOVES_FROM_REST),
        ParameterSpec("friction.lag", "s", WIDE_RANGE, VARIED_RESTS),
        ParameterSpec("friction.static_ratio", "1", fixed_range(1.0, MAX_STATIC_RATIO), MOVES_FROM_REST, floor=True),
        ParameterSpec("stroke.lower_stop", "rad", _stop_range, MOVES_FROM_STOP, floor=True),
        ParameterSpec("stroke.upper_stop", "rad", _stop_range, MOVES_FROM_STOP, floor=True),
    ),
}
"""Unknowns by block; a stop is only fitted where a reading reaches the end of the sensor's range."""
