"""Quantities of descriptions: text with a unit in files, SI floats inside.

Every quantity of a description is an annotated float, for instance `Length`. A bare number, a wrong dimension, an
unknown unit or a magnitude that is not plausible raises an error with advice.

Example:
    >>> import layflat as lf
    >>> lf.units.quantity("40 deg", lf.units.ANGLE, "demand")
    0.698
"""

import math
import re
from typing import Annotated

from annotated_types import Ge, Gt, Le

from layflat.description import expression
from layflat.description import quantity as kinds
from layflat.description.wrong import shown
from layflat.errors import InputError

Quantity = kinds.Quantity
QuantityError = expression.QuantityError

LENGTH = Quantity("length", "m", "160 mm", 1e-9, 100.0)
ANGLE = Quantity("angle", "rad", "120 deg", 1e-9, 4 * math.pi)
SPEED = Quantity("speed", "m/s", "0.5 m/s", 1e-6, 100.0)
ANGULAR_SPEED = Quantity("angular speed", "rad/s", "60 deg/s", 1e-6, 1000.0)
ANGULAR_ACCELERATION = Quantity("angular acceleration", "rad/s^2", "30 rad/s^2", 1e-6, 1e6)
PRESSURE = Quantity("pressure", "Pa", "4 bar", 1e-3, 1e8)
TORQUE = Quantity("torque", "N*m", "25 N m", 1e-9, 1e5)
MASS = Quantity("mass", "kg", "1.5 kg", 1e-9, 1e4)
INERTIA = Quantity("moment of inertia", "kg*m^2", "0.02 kg m^2", 1e-12, 1e5)
TIME = Quantity("time", "s", "5 ms", 1e-9, 1e7)
FREQUENCY = Quantity("frequency", "Hz", "50 Hz", 1e-6, 1e6)
RATE = Quantity("rate", "1/s", "2 1/s", 1e-6, 1e6)
VOLUME = Quantity("volume", "m^3", "120 ml", 1e-12, 1000.0)
AREA = Quantity("area", "m^2", "0.4 m^2", 1e-12, 1e4)
COMPLIANCE = Quantity("volume per pressure", "m^3/Pa", "2 ml/bar", 1e-20, 0.01)
CONDUCTANCE = Quantity("sonic conductance", "m^3/s/Pa", "1.2 dm^3/(s bar)", 1e-16, 0.01)
HEAT_CONDUCTANCE = Quantity("heat flow per temperature", "W/K", "1.2 W/K", 1e-9, 1e6)
HEAT_CAPACITY = Quantity("heat capacity", "J/K", "12 kJ/K", 1e-6, 1e9)
TEMPERATURE = Quantity("temperature", "K", "20 degC", 1.0, 2e3)
STRESS = Quantity("stress", "Pa", "1.8 GPa", 100.0, 1e13)
AREA_PER_LENGTH = Quantity("area per length", "m^2/m", "0.5 mm^2/mm", 1e-12, 1000.0)
AREA_PER_PRESSURE = Quantity("area per pressure", "m^2/Pa", "0.5 mm^2/bar", 1e-22, 1.0)
AREA_SLOPE_PER_PRESSURE = Quantity("area per length and pressure", "m/Pa", "0.1 mm/bar", 1e-20, 1.0)
FORCE = Quantity("force", "N", "10 N", 1e-9, 1e7)
FORCE_PER_PRESSURE = Quantity("force per pressure", "N/Pa", "0.6 N/bar", 1e-15, 100.0)
SPRING_RATE = Quantity("force per length", "N/m", "0.2 N/mm", 1e-9, 1e9)
LINEAR_DAMPING = Quantity("force per speed", "N*s/m", "0.1 N s/mm", 1e-12, 1e7)
DENSITY = Quantity("density", "kg/m^3", "2700 kg/m^3", 1e-3, 3e4)
AREA_DENSITY = Quantity("mass per area", "kg/m^2", "0.9 kg/m^2", 1e-6, 1000.0)
STIFFNESS = Quantity("stiffness", "N*m/rad", "40 N m/deg", 1e-9, 1e10)
DAMPING = Quantity("damping", "N*m*s/rad", "0.05 N m s/rad", 1e-12, 1e6)
VOLTAGE = Quantity("voltage", "V", "5 V", 1e-9, 1e4)
ERROR_GAIN = Quantity("gain of the error", "V/rad", "0.4 V/deg", 1e-9, 1e7)
PRESSURE_GAIN = Quantity("gain of the pressure", "V/Pa", "1.5 V/bar", 1e-15, 100.0)
INTEGRAL_GAIN = Quantity("gain of the integral", "V/rad/s", "2 V/(deg s)", 1e-9, 1e8)
FLOW = Quantity("volume per time", "m^3/s", "30 l/min", 1e-12, 100.0)
ACCELERATION = Quantity("acceleration", "m/s^2", "9.81 m/s^2", 1e-9, 1e4)
JERK = Quantity("jerk", "m/s^3", "50 m/s^3", 1e-6, 1e7)

QUANTITIES = tuple(value for value in list(globals().values()) if isinstance(value, Quantity))

Length = Annotated[float, LENGTH, Gt(0)]
LengthOrZero = Annotated[float, LENGTH, Ge(0)]
Coordinate = Annotated[float, LENGTH]
Angle = Annotated[float, ANGLE]
PositiveAngle = Annotated[float, ANGLE, Gt(0)]
PositiveSpeed = Annotated[float, ANGULAR_SPEED, Gt(0)]
LinearSpeed = Annotated[float, SPEED, Gt(0)]
AnySpeed = Annotated[float, SPEED]
Gauge = Annotated[float, PRESSURE, Gt(-101325)]
PositivePressure = Annotated[float, PRESSURE, Gt(0)]
PressureOrZero = Annotated[float, PRESSURE, Ge(0)]
AnyPressure = Annotated[float, PRESSURE]
Torque = Annotated[float, TORQUE, Ge(0)]
PositiveTorque = Annotated[float, TORQUE, Gt(0)]
AnyTorque = Annotated[float, TORQUE]
Mass = Annotated[float, MASS, Ge(0)]
Inertia = Annotated[float, INERTIA, Gt(0)]
InertiaOrZero = Annotated[float, INERTIA, Ge(0)]
Time = Annotated[float, TIME, Gt(0)]
TimeOrZero = Annotated[float, TIME, Ge(0)]
Frequency = Annotated[float, FREQUENCY, Gt(0)]
Rate = Annotated[float, RATE, Gt(0)]
Volume = Annotated[float, VOLUME, Gt(0)]
Area = Annotated[float, AREA, Gt(0)]
Compliance = Annotated[float, COMPLIANCE, Ge(0)]
Conductance = Annotated[float, CONDUCTANCE, Gt(0)]
ConductanceOrZero = Annotated[float, CONDUCTANCE, Ge(0)]
HeatConductance = Annotated[float, HEAT_CONDUCTANCE, Ge(0)]
HeatCapacity = Annotated[float, HEAT_CAPACITY, Gt(0)]
Temperature = Annotated[float, TEMPERATURE, Gt(150), Le(500)]
Stress = Annotated[float, STRESS, Gt(0)]
Density = Annotated[float, DENSITY, Gt(0)]
AreaDensity = Annotated[float, AREA_DENSITY, Gt(0)]
AreaPerLength = Annotated[float, AREA_PER_LENGTH]
AreaPerPressure = Annotated[float, AREA_PER_PRESSURE]
AreaSlopePerPressure = Annotated[float, AREA_SLOPE_PER_PRESSURE]
Force = Annotated[float, FORCE]
ForceOrZero = Annotated[float, FORCE, Ge(0)]
ForcePerPressure = Annotated[float, FORCE_PER_PRESSURE, Ge(0)]
SpringRate = Annotated[float, SPRING_RATE]
LinearDamping = Annotated[float, LINEAR_DAMPING, Ge(0)]
Stiffness = Annotated[float, STIFFNESS, Ge(0)]
AnyStiffness = Annotated[float, STIFFNESS]
Damping = Annotated[float, DAMPING, Ge(0)]
Voltage = Annotated[float, VOLTAGE]
PositiveVoltage = Annotated[float, VOLTAGE, Gt(0)]
VoltageOrZero = Annotated[float, VOLTAGE, Ge(0)]
ErrorGain = Annotated[float, ERROR_GAIN, Ge(0)]
PressureGain = Annotated[float, PRESSURE_GAIN, Ge(0)]
IntegralGain = Annotated[float, INTEGRAL_GAIN, Ge(0)]
AnyInertia = Annotated[float, INERTIA]
PositiveMass = Annotated[float, MASS, Gt(0)]
AnyAcceleration = Annotated[float, ACCELERATION]
Acceleration = Annotated[float, ACCELERATION, Ge(0)]
PositiveAcceleration = Annotated[float, ACCELERATION, Gt(0)]
Jerk = Annotated[float, JERK, Gt(0)]
Flow = Annotated[float, FLOW, Ge(0)]
Share = Annotated[float, Ge(0), Le(1)]

# Narrower than the quantity's own range: values of machines that can be built.
SupplyPressure = Annotated[float, PRESSURE, Ge(1e4), Le(1e7)]
AmbientPressure = Annotated[float, PRESSURE, Ge(2e4), Le(1e6)]
ControlCycle = Annotated[float, TIME, Ge(1e-4), Le(0.1)]
Size = Annotated[float, LENGTH, Ge(1e-3), Le(20.0)]
Gravity = Annotated[float, ACCELERATION, Ge(0), Le(100.0)]
AnyGravity = Annotated[float, ACCELERATION, Ge(-100.0), Le(100.0)]
Thickness = Annotated[float, LENGTH, Ge(1e-6), Le(0.5)]
Clearance = Annotated[float, LENGTH, Ge(5e-4), Le(0.01)]
PartVolume = Annotated[float, VOLUME, Ge(1e-10), Le(1.0)]
ValveConductance = Annotated[float, CONDUCTANCE, Ge(1e-12), Le(1e-6)]
ValveFrequency = Annotated[float, FREQUENCY, Ge(0.1), Le(1e5)]
FullVoltage = Annotated[float, VOLTAGE, Ge(1e-3), Le(1e3)]
ShortTime = Annotated[float, TIME, Ge(1e-5), Le(60.0)]
LinkMass = Annotated[float, MASS, Ge(0), Le(2e3)]
Payload = Annotated[float, MASS, Ge(0), Le(500.0)]
Ratio = Annotated[float, Ge(1e-6), Le(1e6)]


def quantity(value: str | float, kind: Quantity, where: str) -> float:
    """Return the SI float of a user's text with a unit, in the plausible range, or of a finite SI number from code.

    Args:
        value: text or number.
        kind: its quantity.
        where: place of the value in messages.

    Raises:
        InputError: naming `where`: it is not valid.
    """
    try:
        if isinstance(value, (int, float)) and not isinstance(value, bool):
            return kind.finite(float(value))
        return kind.parse(value)
    except QuantityError as error:
        raise InputError(f"{shown(value)} {error.what}", where=where, right=error.right) from None


def quantity_text(example: object, value: float, unit: str, digits: int = 7) -> str | float:
    """Return an SI value as it is written in a file; a number if its unit is "1".

    Args:
        example: text of a value there, whose unit is used.
        value: SI.
        unit: SI unit of the value, used if the example is no text with a unit.
        digits: significant digits.
    """
    if unit == "1":
        return float(f"{value:.{digits}g}")
    match = re.match(r"\s*[-+\d.]+(?:[eE][-+]?\d+)?\s*(.*\S)", example) if isinstance(example, str) else None
    return Quantity("", unit, "").text(value, match[1] if match else unit, digits)
