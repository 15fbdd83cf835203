"""Field for a value of a description: names, unit, meaning, limits, and the range of its slider."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from math import floor, inf, log10
from typing import Any, Literal, Self, get_args, get_origin

from pydantic import BaseModel

from layflat.description.change import annotation_at, is_whole, quantity_of, value_at
from layflat.description.expression import QuantityError, split_quantity
from layflat.description.quantity import Quantity
from layflat.description.tables import Plain
from layflat.machine.listing import nested_value
from layflat.machine.model import Machine

Shape = Literal["number", "whole", "list", "switch", "choice", "text", "fixed"]
Bounds = tuple[float, bool, float, bool]
"""Minimum, whether it is excluded, maximum, whether it is excluded; SI."""

SLIDER_RATIO = 2.0  # a slider goes from the value over this ratio to the value times it
SLIDER_STEPS = 200  # of a slider, about
READABLE_RANGE = 1e-4, 1e4  # magnitudes that are shown in the value's own unit
LARGE_LIMIT = 1e4  # limits from here on are shown in the SI unit
FIXED_KEYS = {"file", "bodies", "kinds"}  # keys of texts that name files or their format: not editable


@dataclass(frozen=True)
class Field:
    """Field for one value of a description."""

    path: str
    shape: Shape
    unit: str = ""  # in which it is shown; "" if it has none
    quantity: Quantity | None = None
    bounds: Bounds = (-inf, False, inf, False)
    choices: tuple[str, ...] = ()
    meaning: str = ""

    @cached_property
    def section(self) -> str:
        """Path of the part that it is shown with, such as "joint.large.hose" or "supply"."""
        keys = self.path.split(".")
        deep = 3 if self.path.startswith("arm.link.") else 1 if keys[0] != "joint" else 3 if len(keys) > 3 else 2
        return ".".join(keys[:deep]) if len(keys) > 1 else ""

    @cached_property
    def label(self) -> str:
        """Name within the section."""
        keys = self.path.removeprefix(f"{self.section}.").split(".")
        return key_title(" ".join(str(int(key) + 1) if key.isdigit() else key for key in keys))

    @property
    def limits(self) -> str:
        """Limits in words, in the unit of the field."""
        lower, lower_excluded, upper, upper_excluded = self.bounds
        if self.quantity is not None:
            lower, upper = max(lower, -self.quantity.most), min(upper, self.quantity.most)
        if self.shape not in {"number", "whole", "list"} or -lower == upper == inf:
            return ""
        low, high, unit = self._edge(lower), self._edge(upper), self.unit
        if self.quantity is not None and max(abs(low), abs(high)) >= LARGE_LIMIT:
            low, high, unit = lower, upper, self.quantity.unit
        limits = f"at least {low:g}" if upper == inf else f"{low:g} to {'below ' if upper_excluded else ''}{high:g}"
        return f"{'above ' if lower_excluded else ''}{limits} {unit}".rstrip()

    def number(self, value: Any) -> float:
        """Return an SI value in the unit of the field."""
        if self.quantity is None or not self.unit:
            return float(value)
        return split_quantity(self.quantity.text(value, self.unit))[0]

    def readable(self, value: float) -> Self:
        """Return the field, in the SI unit if a value (SI), unless 0, is outside `READABLE_RANGE` in the field's."""
        small, large = READABLE_RANGE
        if self.quantity is None or value == 0.0 or small <= abs(self.number(value)) < large:
            return self
        return replace(self, unit=self.quantity.unit)

    def format_value(self, value: Any) -> str:
        """Return the text of the field for an SI value, without the unit."""
        if self.shape in {"number", "whole"}:
            return f"{self.number(value):.7g}"
        if self.shape == "list":
            return ", ".join(f"{self.number(item):.7g}" for item in value)
        return ", ".join(value) if isinstance(value, tuple) else str(value)

    def read(self, text: str) -> Any:
        """Return typed text as a description holds it: a bare number gets the unit of the field.

        Text that can't be read is returned as it is: the description's checks report it.
        """
        if self.shape == "list":
            return [self._read_number(item.strip()) for item in text.split(",") if item.strip()]
        return self._read_number(text.strip()) if self.shape in {"number", "whole"} else text.strip()

    def _read_number(self, text: str) -> Any:
        """Return a typed number, or a quantity as text in the field's unit; unreadable text is returned unchanged."""
        if self.quantity is None:
            return _parse_number(text, int if self.shape == "whole" else float)
        try:
            _, unit = split_quantity(text)
            if not unit:
                return f"{text} {self.unit}"
            return self.quantity.text(self.quantity.convert(text), self.unit) if unit != self.unit else text
        except QuantityError:
            return text

    def slider(self, value: float) -> tuple[float, float, float] | None:
        """Return min, max and step of a slider about an SI value, in the unit of the field; None if none makes sense.

        It goes from half of the value to twice the value, inside the limits; from minus to plus twice its magnitude
        where there is no lower limit; over all limits of a dimensionless value with limits at most 1 apart. There is
        none for zero otherwise.
        """
        lower, lower_excluded, upper, upper_excluded = self.bounds
        if self.shape not in {"number", "whole"}:
            return None
        number = self.number(value)
        if upper - lower <= 1.0 and self.quantity is None:
            low, high = lower, upper
        elif number == 0.0:
            return None
        else:
            low, high = (
                sorted((number / SLIDER_RATIO, number * SLIDER_RATIO))
                if lower > -inf
                else (-SLIDER_RATIO * abs(number), SLIDER_RATIO * abs(number))
            )
            low, high = max(low, self._edge(lower)), min(high, self._edge(upper))
        if not high > low:
            return None
        step = 1.0 if self.shape == "whole" else _round_step((high - low) / SLIDER_STEPS)
        first, last = round(low / step), round(high / step)
        first += lower_excluded and first * step <= self._edge(lower)
        last -= upper_excluded and last * step >= self._edge(upper)
        return (_tidy(first * step), _tidy(last * step), step) if last > first else None

    def _edge(self, bound: float) -> float:
        """Return an SI bound in the unit of the field; an infinite one as it is."""
        return bound if abs(bound) == inf else self.number(bound)


def _round_step(rough: float) -> float:
    """Round a step down to 1, 2 or 5 times a power of ten."""
    power = 10.0 ** floor(log10(rough))
    return float(f"{next(k for k in (5.0, 2.0, 1.0) if k * power <= rough * (1 + 1e-9)) * power:.3g}")


def _tidy(value: float) -> float:
    return float(f"{value:.12g}")


def _parse_number(text: str, kind: type[int] | type[float]) -> Any:
    """Return a text as a number of a kind, or the text itself if it is none."""
    try:
        return kind(text)
    except ValueError:
        return text


def key_title(key: str) -> str:
    """Return a key of a description as a title: "pressure_gauge" is "Pressure (gauge)"."""
    words = key.removesuffix("_gauge").replace("_", " ")
    words += " (gauge)" if key.endswith("_gauge") else ""
    return words[:1].upper() + words[1:]


SOURCE_NOTES = {
    "paper": "from the paper",
    "derived": "follows from other values",
    "assumed": "assumed",
    "calibrated": "found by a calibration",
    "identified": "identified from measurements",
    "given": "the file does not say where it comes from",
    "default": "not in the file: the usual value",
    "edited": "changed here",
}
"""Meaning of each source, for one without a note of its own."""


def section_name(section: str) -> str:
    """Return the name of a section, such as "Joint large, hose"."""
    first, *keys = section.split(".")
    if first == "joint":
        return ", ".join([f"Joint {keys[0]}", *(key_title(key).lower() for key in keys[1:])])
    return ", ".join([key_title(first), *(f"link {key}" for key in keys[1:])])  # "arm.link.base"


def describe_value(meaning: str, limits: str) -> str:
    """Return meaning and limits of a value as one line."""
    meaning = meaning.replace("`", "")
    text = f"{meaning}; {limits}" if meaning and limits else meaning or limits
    return text[:1].upper() + text[1:]


def fields_of(machine: Machine, plain: Plain) -> list[Field]:
    """Return the fields of all values that a machine's arm uses, in the order of a description.

    Shapes of links are left out: they serve pictures only.

    Args:
        machine: present machine.
        plain: its values as they are written, with their units.
    """
    used = {f"joint.{name}" for name in machine.joints}
    return [
        field_at(machine, plain, path)
        for path, _ in _leaves(machine, "")
        if path != "name" and (not path.startswith("joint.") or ".".join(path.split(".")[:2]) in used)
    ]


def _leaves(part: Any, path: str) -> Iterator[tuple[str, Any]]:
    """Yield path and value of all leaves of a part; a list of numbers or texts is one leaf.

    None, empty lists, and shapes of links are left out.
    """
    below: list[tuple[str, Any]]
    if isinstance(part, BaseModel):
        below = [(key, getattr(part, key)) for key in type(part).model_fields if key != "shapes"]
    elif isinstance(part, dict):
        below = list(part.items())
    elif isinstance(part, tuple) and part and isinstance(part[0], (BaseModel, tuple)):
        below = [(str(i), item) for i, item in enumerate(part)]
    else:
        if part is not None and part != ():
            yield path, part
        return
    for key, value in below:
        yield from _leaves(value, f"{path}.{key}" if path else key)


def field_at(machine: Machine, plain: Plain, path: str) -> Field:
    """Return the field of a machine's value.

    Args:
        machine: present machine.
        plain: its values as they are written, with their units; a missing value gets the usual unit of its quantity.
        path: dotted path of the value.
    """
    value = value_at(machine, path)
    annotation = annotation_at(machine, path)
    meaning = _meaning(machine, path)
    choices = _choices(annotation)
    if isinstance(value, bool):
        return Field(path, "switch", meaning=meaning)
    if choices:
        return Field(path, "choice" if len(choices) > 1 else "fixed", choices=choices, meaning=meaning)
    written = nested_value(plain, path.split("."))
    shape: Shape = "whole" if is_whole(annotation) else "number"
    if isinstance(value, tuple) and not isinstance(value[0], str):
        shape, annotation = "list", annotation_at(machine, f"{path}.0")
        written = written[0] if written else None
    elif not isinstance(value, (int, float)):
        fixed = isinstance(value, tuple) or path.rpartition(".")[2] in FIXED_KEYS
        return Field(path, "fixed" if fixed else "text", meaning=meaning)
    quantity = quantity_of(annotation)
    return Field(path, shape, _unit(written, quantity), quantity, _annotated_bounds(annotation), meaning=meaning)


def _choices(annotation: Any) -> tuple[str, ...]:
    """Return the values of a Literal, annotated or not, as texts; () for any other type."""
    while get_origin(annotation) is not Literal and get_args(annotation) and hasattr(annotation, "__metadata__"):
        annotation = get_args(annotation)[0]
    return tuple(map(str, get_args(annotation))) if get_origin(annotation) is Literal else ()


def _unit(written: Any, quantity: Quantity | None) -> str:
    """Return the unit in which a value is written, else the usual one of its quantity; "" without a quantity."""
    if quantity is None:
        return ""
    try:
        return split_quantity(written)[1] if isinstance(written, str) else split_quantity(quantity.example)[1]
    except QuantityError:
        return split_quantity(quantity.example)[1]


def _annotated_bounds(annotation: Any) -> Bounds:
    """Return the tightest bounds of an annotated number, infinite where it has none; see `Bounds`."""
    lower, lower_excluded, upper, upper_excluded = -inf, False, inf, False
    for note in get_args(annotation)[1:]:
        for name, excluded in (("ge", False), ("gt", True)):
            if getattr(note, name, None) is not None and float(getattr(note, name)) >= lower:
                lower, lower_excluded = float(getattr(note, name)), excluded
        for name, excluded in (("le", False), ("lt", True)):
            if getattr(note, name, None) is not None and float(getattr(note, name)) <= upper:
                upper, upper_excluded = float(getattr(note, name)), excluded
    return lower, lower_excluded, upper, upper_excluded


def _meaning(machine: Machine, path: str) -> str:
    """Return the description of a value by its model class, "" if there is none; an item of a list has the list's."""
    part: Any = machine
    meaning = ""
    for key in path.split("."):
        if isinstance(part, BaseModel):
            meaning = type(part).model_fields[key].description or ""
            part = getattr(part, key)
        else:
            part = part[int(key)] if isinstance(part, tuple) else part[key]
            meaning = meaning if key.isdigit() else ""
    return meaning
