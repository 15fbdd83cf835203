"""What a study may vary: numbers of the machine and settings of its scenarios, each with its unit and its bounds."""

from __future__ import annotations

from dataclasses import dataclass
from difflib import get_close_matches
from typing import Annotated, Any, get_args

from annotated_types import Ge
from pydantic import ConfigDict, TypeAdapter, ValidationError

from layflat.description import units as u
from layflat.errors import InputError
from layflat.machine import Machine
from layflat.machine.change import paths
from layflat.study.description import explained

SHARED: dict[str, Any] = {"payload": u.Mass, "supply": u.Gauge}
"""Settings of a scenario that all joints share."""

BY_JOINT: dict[str, Any] = {"brake": Annotated[float, Ge(0)], "load": Annotated[float, u.TORQUE], "drift": u.Voltage}
"""Settings of a scenario for all joints, or with a joint's name behind for this one."""

ONE_FOR_ALL = "controller.cycle"
"""A number of the machine that is the same in all runs: the time between records."""


@dataclass(frozen=True)
class Kind:
    """How the values of something that varies are written.

    Args:
        annotation: of the number, with its quantity and its bounds, as in a machine's description.
    """

    annotation: Any

    @property
    def quantity(self) -> u.Quantity | None:
        """None for a number without unit."""
        return next((note for note in get_args(self.annotation)[1:] if isinstance(note, u.Quantity)), None)

    @property
    def unit(self) -> str:
        """SI unit, "1" where there is none."""
        return self.quantity.unit if self.quantity else "1"

    @property
    def whole(self) -> bool:
        """Whether only whole numbers make sense."""
        return int in (self.annotation, *get_args(self.annotation)[:1])

    def parse(self, value: object, where: str) -> float:
        """SI float of a value as it stands in the file.

        Raises:
            InputError: naming `where`: it is bare, of another kind, or out of the bounds.
        """
        adapter = TypeAdapter[float](self.annotation, config=ConfigDict(strict=True, allow_inf_nan=False))
        try:
            return float(adapter.validate_python(value))
        except ValidationError as error:
            raise explained(error.errors()[0], where) from None

    def difference(self, value: object, where: str) -> float:
        """SI float of a difference of two such values, greater than zero.

        Raises:
            InputError: naming `where`.
        """
        if self.quantity is u.TEMPERATURE and not (isinstance(value, str) and value.strip().endswith("K")):
            raise InputError(f"{value!r} is no difference of temperatures", where=where, right='give kelvin: "5 K"')
        kind = Kind(Annotated[float, self.quantity] if self.quantity else float)
        number = kind.parse(value, where)
        if number <= 0.0:
            raise InputError(f"{value!r} is out of range", where=where, right="give more than zero")
        return number

    def written(self, value: float) -> Any:
        """A value as it could stand in the file."""
        return f"{value!r} {self.unit}" if self.quantity else value


FACTOR = Kind(Annotated[float, Ge(0)])
"""Of what is given relative to what the machine says."""


def kind(machine: Machine, path: str, where: str) -> Kind:
    """The kind of a path that varies.

    Raises:
        InputError: naming `where`: nothing of this name can vary.
    """
    settings = _settings(machine)
    known = [key for key in paths(machine) if key != ONE_FOR_ALL]
    if path in settings:
        return Kind(settings[path])
    if path in known:
        return Kind(_annotation(machine, path))
    if path == ONE_FOR_ALL:
        raise InputError("is the same in all runs", where=where, right="make a study of its own for each cycle")
    near = get_close_matches(path, [*known, *settings], n=1, cutoff=0.5)
    hint = f"nearest is {near[0]!r}" if near else f"`layflat show {machine.origin}` lists the paths"
    raise InputError("no number of this name can vary", where=where, right=hint)


def _settings(machine: Machine) -> dict[str, Any]:
    ends = ("", *(f".{name}" for name in machine.joints))
    by_joint = {f"scenario.{key}{end}": annotation for key, annotation in BY_JOINT.items() for end in ends}
    return {f"scenario.{key}": annotation for key, annotation in SHARED.items()} | by_joint


def _annotation(machine: Machine, path: str) -> Any:
    """Of a number of the machine."""
    part: Any = machine
    annotation: Any = None
    for key in path.split("."):
        if isinstance(part, tuple):
            annotation, part = get_args(annotation)[int(key)], part[int(key)]
        elif isinstance(part, dict):
            part = part[key]
        else:
            field = type(part).model_fields[key]
            # Pydantic keeps the notes of a field apart from its type.
            annotation = Annotated[(field.annotation, *field.metadata)] if field.metadata else field.annotation
            part = getattr(part, key)
    return annotation
