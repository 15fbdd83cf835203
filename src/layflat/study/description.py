"""Data model of study files, and the numbers that they can vary, each with its unit and its bounds."""

from dataclasses import dataclass
from typing import Annotated, Any, Literal

from annotated_types import Ge
from pydantic import (
    ConfigDict,
    Field,
    GetCoreSchemaHandler,
    TypeAdapter,
    ValidationError,
    create_model,
    field_validator,
)
from pydantic_core import core_schema

from layflat.description import Part
from layflat.description import units as u
from layflat.description.change import annotation_at, is_whole, paths, quantity_of
from layflat.description.explain import explain_error, explain_value_error
from layflat.description.names import Name
from layflat.description.wrong import nearest, value_error
from layflat.errors import InputError
from layflat.machine import Machine
from layflat.motion.scenario import SIGNALS, Scenario

SHARED_PATH = "controller.cycle"  # a number of the machine that is the same in all runs: the time between records


@dataclass(frozen=True)
class VariedQuantity:
    """Quantity of a varied number: its unit, its bounds and its form in files."""

    annotation: Any  # of the number, with its quantity and its bounds, as in a machine's description

    @property
    def quantity(self) -> u.Quantity | None:
        """Quantity; None for a number without unit."""
        return quantity_of(self.annotation)

    @property
    def unit(self) -> str:
        """SI unit, "1" for a number without unit."""
        return self.quantity.unit if self.quantity else "1"

    @property
    def whole(self) -> bool:
        """True if only whole numbers are valid."""
        return is_whole(self.annotation)

    def parse(self, value: object, where: str) -> float:
        """Return the SI float of a value as it stands in the file: with its unit, or bare if it has none.

        Raises:
            InputError: naming `where`: its unit is missing or of another kind, it is not whole but has to be, or it is
                out of the bounds.
        """
        adapter = TypeAdapter[float](self.annotation, config=ConfigDict(strict=True, allow_inf_nan=False))
        try:
            return float(adapter.validate_python(value))
        except ValidationError as error:
            raise explain_value_error(error, where, self.quantity) from None

    def difference(self, value: object, where: str) -> float:
        """Return the SI float of a difference of two such values.

        Raises:
            InputError: naming `where`: as `parse` but for the bounds, it is not greater than zero, or one of
                temperatures is not in kelvin.
        """
        if self.quantity is u.TEMPERATURE and not (isinstance(value, str) and value.strip().endswith("K")):
            raise InputError(f"{value!r} is not a difference of temperatures", where=where, right='give kelvin: "5 K"')
        number = VariedQuantity(Annotated[float, self.quantity] if self.quantity else float).parse(value, where)
        if number <= 0.0:
            raise InputError(f"{value!r} is out of range", where=where, right="give more than zero")
        return number

    def format(self, value: float) -> Any:
        """Return an SI value as it is written in a file: a text with its SI unit, or a plain number without a unit."""
        return f"{value!r} {self.unit}" if self.quantity else value


INDEX_QUANTITY = VariedQuantity(Annotated[int, Ge(0)])  # of indices
FACTOR_QUANTITY = VariedQuantity(Annotated[float, Ge(0)])  # of factors on the machine's value


def varied_quantity(machine: Machine, path: str, where: str) -> VariedQuantity:
    """Return the quantity of a varied path.

    Args:
        machine: machine of the study.
        path: path of a number of the machine, or of a signal of the scenario.
        where: the key, for messages.

    Raises:
        InputError: naming `where`: no number of this name can vary.
    """
    ends = ("", *(f".{name}" for name in machine.joints))
    settings = {
        f"scenario.{name}{end}": row.annotation
        for name, row in SIGNALS.items() if row.varies
        for end in (ends if row.by_joint else ends[:1])
    }  # fmt: skip
    numbers = [key for key in paths(machine) if key != SHARED_PATH]
    if path in settings or path in numbers:
        return VariedQuantity(settings[path] if path in settings else annotation_at(machine, path))
    if path == SHARED_PATH:
        raise InputError("is the same in all runs", where=where, right="make a study of its own for each cycle")
    near = nearest(path, [*numbers, *settings], cutoff=0.5)
    hint = f"nearest is {near!r}" if near else f"`layflat machine show {machine.origin}` lists the paths"
    raise InputError("no number of this name can vary", where=where, right=hint)


COMPLETE_STUDY = "a study has a name, a machine and [scenario], and each of its variants a name"

MAX_PLAIN_NUMBER = 1e6  # of a number without unit


@dataclass(frozen=True)
class SignalAnnotation:
    """Annotation of a signal: a value, one per joint, a table by joint, or steps [time, value] of these.

    Texts with a unit become SI floats.
    """

    kind: u.Quantity | None  # None for numbers without unit
    by_joint: bool = True  # False: one value for all joints

    def read(self, value: Any) -> Any:
        """Return the SI value in the form that `Scenario` takes: steps as pairs of time (s) and values.

        Raise ValueError if a text, or a number, does not fit the quantity.
        """
        if isinstance(value, list) and value and all(isinstance(item, list) and len(item) == 2 for item in value):
            return [(_parse_number(time, u.TIME), self._read_values(item)) for time, item in value]
        return self._read_values(value)

    def format(self, value: Any) -> Any:
        """Return an SI value as it is written in a file, in SI units."""
        if isinstance(value, tuple):
            return [f"{value[0]!r} s", self.format(value[1])]
        if isinstance(value, list):
            return [self.format(item) for item in value]
        if isinstance(value, dict):
            return {name: self.format(item) for name, item in value.items()}
        return value if value is None or self.kind is None else f"{value!r} {self.kind.unit}"

    def _read_values(self, value: Any) -> Any:
        """Return a number, or for signals of joints numbers by name or in order, in SI units; or raise ValueError."""
        if isinstance(value, dict) and self.by_joint:
            return {name: _parse_number(item, self.kind) for name, item in value.items()}
        if isinstance(value, list) and self.by_joint:
            return [_parse_number(item, self.kind) for item in value]
        return _parse_number(value, self.kind)

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> core_schema.CoreSchema:
        """Read texts into floats, and write floats as text into JSON."""
        as_text = core_schema.plain_serializer_function_ser_schema(self.format, when_used="json")
        return core_schema.no_info_plain_validator_function(self.read, serialization=as_text)


def _parse_number(value: object, kind: u.Quantity | None) -> float:
    """Return the number of a text with a unit in SI; without a quantity, of a plain number up to `MAX_PLAIN_NUMBER`.

    Raises:
        ValueError: anything else.
    """
    if kind is None:
        if isinstance(value, (int, float)) and not isinstance(value, bool) and abs(value) <= MAX_PLAIN_NUMBER:
            return float(value)
        raise value_error("is not a number", "give a number such as 0.5", value)
    try:
        return kind.parse(value)
    except u.QuantityError as error:
        raise value_error(error.what, error.right, value) from None


MAX_STUDY_SEED = 10**15  # the seeds of an ensemble are floating-point numbers, which hold whole numbers up to 9e15

Whole = Annotated[int, Field(ge=0, le=MAX_STUDY_SEED)]
_SIGNAL_FIELDS: dict[str, Any] = {
    name: (Annotated[Any, SignalAnnotation(row.quantity, row.by_joint)], getattr(Scenario, name))
    for name, row in SIGNALS.items()
}
_Signals = create_model("_Signals", __base__=Part, **_SIGNAL_FIELDS)


class ScenarioTable(_Signals):
    """Scenario of a study: the keys of `Scenario`, and a name for the column `scenario` of the results."""

    name: str | None = None
    tip: Annotated[Any, SignalAnnotation(u.LENGTH)] = None
    duration: u.Time = 2.0
    start: Annotated[Any, SignalAnnotation(u.ANGLE)] = None
    pressures: tuple[u.PositivePressure, u.PositivePressure] | None = None
    noise: Annotated[bool, Field(strict=True)] = True
    seed: Whole = 0


class VaryTable(Part):
    """Range of one thing that varies: evenly from low to high, among values, or normally about a mean.

    Values are in the unit of the path that varies, so they are read later, by `varied.resolve_axis`. The paths in
    `also` vary along with it. With `relative` the values are factors on the machine's own. A `group` has sensitivity
    indices of its own.
    """

    low: Any = None
    high: Any = None
    points: Annotated[int, Field(ge=2)] | None = None
    scale: Literal["linear", "log"] = "linear"
    values: list[Any] | None = None
    mean: Any = None
    std: Any = None
    also: tuple[str, ...] = ()
    relative: bool = False
    group: str | None = None


class VariantTable(Part):
    """A machine of several that a study compares: what differs from the study's own, as in a file that extends it.

    `factors` has factors on numbers of the machine, laid out in the same way.
    """

    name: Annotated[str, Field(min_length=1)]
    machine: str | None = None
    set: dict[str, Any] = Field(default_factory=dict)
    factors: dict[str, Any] = Field(default_factory=dict)


def _default_sampling(fields: dict[str, Any]) -> str:
    """Return the default sampling of a file: Sobol points with a number of runs, else a grid."""
    return "grid" if fields.get("runs") is None else "sobol"


class StudyFile(Part):
    """A study: a machine, what happens to it, and what varies from sample to sample."""

    name: Name
    title: str = ""
    machine: str
    runs: Annotated[int, Field(ge=1)] | None = None
    sampling: Annotated[Literal["grid", "sobol", "lhs", "saltelli"], Field(default_factory=_default_sampling)]
    seed: Whole = 0
    noise_seeds: Annotated[int, Field(ge=1)] = 1
    metrics: tuple[str, ...] | None = None
    prices: str | None = None
    step: u.Time | None = None
    precision: Literal["double", "single"] | None = None
    band: u.PositiveAngle | None = None
    tip_band: u.Length | None = None
    scenario: Annotated[tuple[ScenarioTable, ...], Field(min_length=1)]
    vary: dict[str, VaryTable] = Field(default_factory=dict)
    variant: tuple[VariantTable, ...] = ()

    @field_validator("scenario", mode="before")
    @classmethod
    def _wrap_single_scenario(cls, value: Any) -> Any:
        """Return a single table as a tuple of one; any other value is returned as it is."""
        return (value,) if isinstance(value, dict) else value


def check_rules(where: str, *rules: tuple[bool, str, str]) -> None:
    """Raise InputError for the first broken rule: whether it is, its key below `where`, "what is wrong; right"."""
    for broken, key, said in rules:
        if broken:
            what, _, right = said.partition("; ")
            raise InputError(what, where=f"{where}{key}", right=right)


def explain_study_error(error: ValidationError, where: str) -> InputError:
    """Return the InputError, of one line, for the first mistake in a study file; `where` is the file."""
    explanation = explain_error(error, where, StudyFile, complete=COMPLETE_STUDY)
    first = error.errors(include_url=False)[0]
    if first["type"] == "extra_forbidden" and first["loc"][0] == "vary" and isinstance(first["input"], dict):
        right = 'quote the whole path: [vary."joint.small.brake.torque"]'
        return InputError(explanation.what, where=explanation.where, right=right)
    return explanation
