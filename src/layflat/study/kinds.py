"""What a study may vary: numbers of the machine and settings of its scenarios, each with its unit and its bounds."""

from dataclasses import dataclass
from typing import Annotated, Any

from annotated_types import Ge
from pydantic import ConfigDict, TypeAdapter, ValidationError

from layflat.description import units as u
from layflat.description.change import annotation_at, is_whole, paths, quantity_of
from layflat.description.explain import explained_value
from layflat.description.hints import nearest
from layflat.errors import InputError
from layflat.machine import Machine

SHARED: dict[str, Any] = {"payload": u.Mass, "supply": u.Gauge}  # settings of a scenario that all joints share

BY_JOINT: dict[str, Any] = {"brake": Annotated[float, Ge(0)], "load": Annotated[float, u.TORQUE], "drift": u.Voltage}
"""Settings of a scenario for all joints, or with a joint's name behind for this one."""

ONE_FOR_ALL = "controller.cycle"  # a number of the machine that is the same in all runs: the time between records


@dataclass(frozen=True)
class Kind:
    """How the values of something that varies are written."""

    annotation: Any  # of the number, with its quantity and its bounds, as in a machine's description

    @property
    def quantity(self) -> u.Quantity | None:
        """None for a number without unit."""
        return quantity_of(self.annotation)

    @property
    def unit(self) -> str:
        """SI unit, "1" where there is none."""
        return self.quantity.unit if self.quantity else "1"

    @property
    def whole(self) -> bool:
        """Whether only whole numbers make sense."""
        return is_whole(self.annotation)

    def parse(self, value: object, where: str) -> float:
        """Return the SI float of a value as it stands in the file.

        Raises:
            InputError: naming `where`: it is bare, of another kind, or out of the bounds.
        """
        adapter = TypeAdapter[float](self.annotation, config=ConfigDict(strict=True, allow_inf_nan=False))
        try:
            return float(adapter.validate_python(value))
        except ValidationError as error:
            raise explained_value(error, where, self.quantity) from None

    def difference(self, value: object, where: str) -> float:
        """Return the SI float of a difference of two such values, greater than zero (InputError: naming `where`)."""
        if self.quantity is u.TEMPERATURE and not (isinstance(value, str) and value.strip().endswith("K")):
            raise InputError(f"{value!r} is not a difference of temperatures", where=where, right='give kelvin: "5 K"')
        number = Kind(Annotated[float, self.quantity] if self.quantity else float).parse(value, where)
        if number <= 0.0:
            raise InputError(f"{value!r} is out of range", where=where, right="give more than zero")
        return number

    def written(self, value: float) -> Any:
        """Return a value as it could stand in the file."""
        return f"{value!r} {self.unit}" if self.quantity else value


NUMBER = Kind(Annotated[int, Ge(0)])  # of something in a list
FACTOR = Kind(Annotated[float, Ge(0)])  # of what is given relative to what the machine says


def kind(machine: Machine, path: str, where: str) -> Kind:
    """Return the kind of a path that varies (InputError: naming `where`: nothing of this name can vary)."""
    ends = ("", *(f".{name}" for name in machine.joints))
    settings = {f"scenario.{key}": annotation for key, annotation in SHARED.items()}
    settings |= {f"scenario.{key}{end}": annotation for key, annotation in BY_JOINT.items() for end in ends}
    known = [key for key in paths(machine) if key != ONE_FOR_ALL]
    if path in settings or path in known:
        return Kind(settings[path] if path in settings else annotation_at(machine, path))
    if path == ONE_FOR_ALL:
        raise InputError("is the same in all runs", where=where, right="make a study of its own for each cycle")
    near = nearest(path, [*known, *settings], cutoff=0.5)
    hint = f"nearest is {near!r}" if near else f"`layflat show {machine.origin}` lists the paths"
    raise InputError("no number of this name can vary", where=where, right=hint)
