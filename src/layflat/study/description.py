"""The study file as it is written: tables with known keys, quantities as text with units."""

from __future__ import annotations

import math
from dataclasses import dataclass
from difflib import get_close_matches
from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field, GetCoreSchemaHandler, field_validator
from pydantic_core import ErrorDetails, PydanticCustomError, core_schema

from layflat.description import units as u
from layflat.errors import InputError


@dataclass(frozen=True)
class Signal:
    """Annotation of what acts on a machine: a value, one a joint, a table by joint, or steps [time, value] of these.

    Texts with a unit become SI floats; `kind` is None for numbers without unit. What is not `by_joint` is one for all.
    """

    kind: u.Quantity | None
    by_joint: bool = True

    def read(self, value: Any) -> Any:
        """The SI value, in the form that `Scenario` takes."""
        if isinstance(value, list) and value and all(isinstance(item, list) and len(item) == 2 for item in value):
            return [(_number(time, u.TIME), self._one(item)) for time, item in value]
        return self._one(value)

    def written(self, value: Any) -> Any:
        """The same as text again, in SI units."""
        if isinstance(value, tuple):
            return [f"{value[0]!r} s", self.written(value[1])]
        if isinstance(value, list):
            return [self.written(item) for item in value]
        if isinstance(value, dict):
            return {name: self.written(item) for name, item in value.items()}
        return value if value is None or self.kind is None else f"{value!r} {self.kind.unit}"

    def _one(self, value: Any) -> Any:
        if isinstance(value, dict) and self.by_joint:
            return {name: _number(item, self.kind) for name, item in value.items()}
        if isinstance(value, list) and self.by_joint:
            return [_number(item, self.kind) for item in value]
        return _number(value, self.kind)

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> core_schema.CoreSchema:
        """Read texts into floats, and write floats as text into JSON."""
        as_text = core_schema.plain_serializer_function_ser_schema(self.written, when_used="json")
        return core_schema.no_info_plain_validator_function(self.read, serialization=as_text)


def _number(value: object, kind: u.Quantity | None) -> float:
    if kind is None:
        if isinstance(value, (int, float)) and not isinstance(value, bool) and math.isfinite(value):
            return float(value)
        problem, right = "is not a number", "a number such as 0.5"
    else:
        try:
            return kind.parse(value)
        except ValueError as error:
            problem, right = str(error), f'{kind.article} such as "{kind.example}"'
    message = "{value} {problem}; give {right}"
    raise PydanticCustomError("signal", message, {"value": repr(value), "problem": problem, "right": right})


Angles = Annotated[Any, Signal(u.ANGLE)]
Numbers = Annotated[Any, Signal(None)]
Torques = Annotated[Any, Signal(u.TORQUE)]
Voltages = Annotated[Any, Signal(u.VOLTAGE)]
Pressure = Annotated[Any, Signal(u.PRESSURE, by_joint=False)]
Mass = Annotated[Any, Signal(u.MASS, by_joint=False)]


class Table(BaseModel):
    """Base of the file's tables: frozen, and an unknown key is an error."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)


class ScenarioTable(Table):
    """What happens in a run: the keys of `layflat.sim.Scenario`, and a name for the table's column `scenario`."""

    name: str | None = None
    demand: Angles = 0.0
    duration: u.Time = 2.0
    start: Angles = None
    opening: Numbers = None
    brake: Numbers = 1.0
    load: Torques = 0.0
    drift: Voltages = 0.0
    supply: Pressure = None
    payload: Mass = None
    pressures: tuple[u.PositivePressure, u.PositivePressure] | None = None
    noise: bool = True
    seed: Annotated[int, Field(ge=0)] = 0


class Range(Table):
    """How one thing varies: evenly from low to high, among values, or normally about a mean.

    What is written depends on the path that varies, so the values are read later, by `varied.resolved`. The paths in
    `also` vary along with it. Of what is `relative` the values are factors on what the machine says. A `group` has
    sensitivity indices of its own.
    """

    low: Any = None
    high: Any = None
    points: Annotated[int, Field(ge=2)] | None = None
    scale: Literal["linear", "log"] = "linear"
    values: list[Any] | None = None
    mean: Any = None
    deviation: Any = None
    also: tuple[str, ...] = ()
    relative: bool = False
    group: str | None = None


class VariantTable(Table):
    """A machine of several that a study compares: what differs from the study's own, as in a file that extends it.

    `times` has factors on numbers of the machine, laid out in the same way.
    """

    name: Annotated[str, Field(min_length=1)]
    machine: str | None = None
    set: dict[str, Any] = {}
    times: dict[str, Any] = {}


class StudyFile(Table):
    """A study: a machine, what happens to it, and what varies from sample to sample."""

    name: str
    title: str = ""
    machine: str
    runs: Annotated[int, Field(ge=1)] | None = None
    sampling: Literal["grid", "sobol", "lhs", "saltelli"]
    seed: Annotated[int, Field(ge=0)] = 0
    noise_seeds: Annotated[int, Field(ge=1)] = 1
    metrics: tuple[str, ...] | None = None
    step: u.Time | None = None
    band: u.PositiveAngle | None = None
    tip_band: u.Length | None = None
    scenario: Annotated[tuple[ScenarioTable, ...], Field(min_length=1)]
    vary: dict[str, Range] = {}
    variant: tuple[VariantTable, ...] = ()

    @field_validator("scenario", mode="before")
    @classmethod
    def _one_or_several(cls, value: Any) -> Any:
        return (value,) if isinstance(value, dict) else value


def explained(error: ErrorDetails, where: str) -> InputError:
    """One line for something that pydantic found wrong in a study file."""
    value, message = error["input"], error["msg"].removeprefix("Value error, ")
    steps = [str(step) for step in error["loc"]]
    place = f"{where}: {'.'.join(steps)}" if steps else where
    if error["type"] == "extra_forbidden":
        if steps[0] == "vary" and isinstance(value, dict):
            return InputError(
                "unknown key", where=place, right='quote the whole path: [vary."joint.small.brake.torque"]'
            )
        return InputError("unknown key", where=place, right=_known_keys(steps))
    if error["type"] == "missing":
        whole = "a study has a name, machine, sampling and [scenario]"
        right = whole if steps[0] != "variant" else "give each variant a name"
        return InputError("is missing", where=place, right=right)
    if error["type"] == "signal":
        problem, _, right = message.partition("; ")
        return InputError(problem, where=place, right=right)
    if error["type"] == "quantity":
        problem, _, right = message.partition("; ")
        return InputError(f"{value!r} {problem}", where=place, right=right)
    right = (message[0].lower() + message[1:]).replace("input ", "it ")
    unit = " (in SI units)" if isinstance(value, str) and error["type"].startswith(("greater", "less")) else ""
    return InputError(f"{value!r} is out of range", where=place, right=right + unit)


def _known_keys(steps: list[str]) -> str:
    """The keys that stand beside an unknown one, nearest first."""
    tables: dict[str, type[Table]] = {"scenario": ScenarioTable, "vary": Range, "variant": VariantTable}
    table = tables.get(steps[0], StudyFile) if len(steps) > 1 else StudyFile
    near = get_close_matches(steps[-1], table.model_fields, n=1)
    return f"did you mean {near[0]!r}?" if near else f"known keys are {', '.join(table.model_fields)}"
