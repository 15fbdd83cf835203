"""Quantities at the boundary: text with a unit outside, SI floats inside.

Every quantity of a description is an annotated float, for instance `Length`. A bare number, a wrong dimension or an
unknown unit is refused with an example of what is right.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING, Annotated, Any

from annotated_types import Ge, Gt, Le
from pydantic_core import PydanticCustomError, core_schema

from layflat.errors import InputError

if TYPE_CHECKING:
    import pint
    from pydantic import GetCoreSchemaHandler, GetJsonSchemaHandler


@dataclass(frozen=True)
class Quantity:
    """A kind of quantity: what it is called, its SI unit, and an example for those who got it wrong."""

    name: str
    unit: str
    example: str

    @property
    def article(self) -> str:
        """The name with its article."""
        return f"{'an' if self.name[0] in 'aeiou' else 'a'} {self.name}"

    def parse(self, value: object) -> float:
        """SI float of a text such as "160 mm"; a float is taken as it is only where it comes from our own code.

        Raises:
            ValueError: in one clause, what is wrong with the value.
        """
        if isinstance(value, bool) or not isinstance(value, (str, int, float)):
            raise ValueError(f"is not {self.article}")
        if not isinstance(value, str):
            raise ValueError("is a bare number")
        try:
            quantity: Any = _registry().Quantity(value)
        except Exception:  # pint raises errors of many libraries for a text that it can't read
            raise ValueError(f"is not a number with a unit of {self.name}") from None
        if quantity.units == _registry().dimensionless:
            raise ValueError("is a bare number")
        try:
            number = float(quantity.to(self.unit).magnitude)
        except Exception:
            raise ValueError(f"is not {self.article}") from None
        if not math.isfinite(number):
            raise ValueError("is not finite")
        return number

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> core_schema.CoreSchema:
        """Validate text into an SI float, then check whatever bounds stand beside."""

        def validate(value: object) -> float:
            try:
                return self.parse(value)
            except ValueError as error:
                raise PydanticCustomError(
                    "quantity", "{problem}; give {name} such as {example}",
                    {"problem": str(error), "name": self.article, "example": f'"{self.example}"'},
                ) from None  # fmt: skip

        def written(value: float) -> str:
            return f"{value!r} {self.unit}"

        as_text = core_schema.plain_serializer_function_ser_schema(written, when_used="json")
        return core_schema.no_info_before_validator_function(validate, handler(source), serialization=as_text)

    def __get_pydantic_json_schema__(self, schema: core_schema.CoreSchema, handler: GetJsonSchemaHandler) -> Any:
        """Editors are told of a text with a unit."""
        return {
            "type": "string",
            "title": self.name,
            "examples": [self.example],
            "pattern": r"^\s*[-+.\d].*[^\d\s.].*$",
        }


@cache
def _registry() -> pint.UnitRegistry[float]:
    import pint  # noqa: PLC0415  # it takes longer to import than most commands take to run

    return pint.UnitRegistry(autoconvert_offset_to_baseunit=True, cache_folder=":auto:")


LENGTH = Quantity("length", "m", "160 mm")
ANGLE = Quantity("angle", "rad", "120 deg")
SPEED = Quantity("speed", "m/s", "0.5 m/s")
ANGULAR_SPEED = Quantity("angular speed", "rad/s", "60 deg/s")
PRESSURE = Quantity("pressure", "Pa", "4 bar")
TORQUE = Quantity("torque", "N*m", "25 N m")
MASS = Quantity("mass", "kg", "1.5 kg")
INERTIA = Quantity("moment of inertia", "kg*m^2", "0.02 kg m^2")
TIME = Quantity("time", "s", "5 ms")
FREQUENCY = Quantity("frequency", "Hz", "50 Hz")
VOLUME = Quantity("volume", "m^3", "120 ml")
AREA = Quantity("area", "m^2", "0.4 m^2")
COMPLIANCE = Quantity("volume per pressure", "m^3/Pa", "2 ml/bar")
CONDUCTANCE = Quantity("sonic conductance", "m^3/s/Pa", "1.2 dm^3/(s bar)")
HEAT_CONDUCTANCE = Quantity("heat flow per temperature", "W/K", "1.2 W/K")
HEAT_CAPACITY = Quantity("heat capacity", "J/K", "12 kJ/K")
TEMPERATURE = Quantity("temperature", "K", "20 degC")
STRESS = Quantity("stress", "Pa", "1.8 GPa")
AREA_PER_LENGTH = Quantity("area per length", "m^2/m", "0.5 mm^2/mm")
FORCE = Quantity("force", "N", "10 N")
FORCE_PER_PRESSURE = Quantity("force per pressure", "N/Pa", "0.6 N/bar")
SPRING_RATE = Quantity("force per length", "N/m", "0.2 N/mm")
LINEAR_DAMPING = Quantity("force per speed", "N*s/m", "0.1 N s/mm")
DENSITY = Quantity("density", "kg/m^3", "2700 kg/m^3")
AREA_DENSITY = Quantity("mass per area", "kg/m^2", "0.9 kg/m^2")
STIFFNESS = Quantity("stiffness", "N*m/rad", "40 N m/deg")
DAMPING = Quantity("damping", "N*m*s/rad", "0.05 N m s/rad")
VOLTAGE = Quantity("voltage", "V", "5 V")
ERROR_GAIN = Quantity("gain of the error", "V/rad", "0.4 V/deg")
PRESSURE_GAIN = Quantity("gain of the pressure", "V/Pa", "1.5 V/bar")
INTEGRAL_GAIN = Quantity("gain of the integral", "V/rad/s", "2 V/(deg s)")
FLOW = Quantity("volume per time", "m^3/s", "30 l/min")
ACCELERATION = Quantity("acceleration", "m/s^2", "9.81 m/s^2")

Length = Annotated[float, LENGTH, Gt(0)]
LengthOrZero = Annotated[float, LENGTH, Ge(0)]
Coordinate = Annotated[float, LENGTH]
Angle = Annotated[float, ANGLE]
PositiveAngle = Annotated[float, ANGLE, Gt(0)]
PositiveSpeed = Annotated[float, ANGULAR_SPEED, Gt(0)]
LinearSpeed = Annotated[float, SPEED, Gt(0)]
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
Acceleration = Annotated[float, ACCELERATION, Ge(0)]
Flow = Annotated[float, FLOW, Ge(0)]
Share = Annotated[float, Ge(0), Le(1)]
Ratio = Annotated[float, Gt(0)]


def quantity(value: str | float, kind: Quantity, where: str) -> float:
    """SI float of a text with a unit given by a person, or of a float given by code.

    Raises:
        InputError: naming `where` the value was given.
    """
    if isinstance(value, (int, float)) and not isinstance(value, bool):
        if not math.isfinite(value):
            raise InputError(
                f"{value} is not finite", where=where, right=f'give {kind.article} such as "{kind.example}"'
            )
        return float(value)
    try:
        return kind.parse(value)
    except ValueError as error:
        raise InputError(
            f"{value!r} {error}", where=where, right=f'give {kind.article} such as "{kind.example}"'
        ) from None


def alike(example: object, value: float, unit: str) -> str | float:
    """An SI value as it could stand in a file, in the unit of an example from there, or in `unit` without one.

    A value without unit ("1") is a number.
    """
    if unit == "1":
        return float(f"{value:.7g}")
    found = re.match(r"\s*[-+\d.]+(?:[eE][-+]?\d+)?\s*(.*\S)", example) if isinstance(example, str) else None
    own = found[1] if found else unit
    return f"{float(_registry().Quantity(value, unit).to(own).magnitude):.7g} {own}"
