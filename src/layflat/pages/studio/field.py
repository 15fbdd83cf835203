"""A value of a description as something to edit: its names, unit, meaning and limits, and the range of its slider."""

from dataclasses import dataclass, replace
from functools import cached_property
from math import floor, inf, log10
from typing import Any, Literal, Self

from layflat.description.expression import QuantityError, split
from layflat.description.quantity import Quantity

Shape = Literal["number", "whole", "list", "switch", "choice", "text", "fixed"]
Bounds = tuple[float, bool, float, bool]
"""Least, whether it is itself excluded, most, whether it is itself excluded; SI."""

SPAN = 2.0  # a slider goes from the value over this to the value times this
STEPS = 200  # of a slider, about
READABLE = 1e-4, 1e4  # numbers that are shown in their unit
MANY = 1e4  # limits above this are said in the SI unit


@dataclass(frozen=True)
class Field:
    """One value of a description."""

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
        return titled(" ".join(str(int(key) + 1) if key.isdigit() else key for key in keys))

    @property
    def limits(self) -> str:
        """Return what may stand there, in words, in the unit in which it is shown."""
        least, above, most, below = self.bounds
        if self.quantity is not None:
            least, most = max(least, -self.quantity.most), min(most, self.quantity.most)
        if self.shape not in {"number", "whole", "list"} or -least == most == inf:
            return ""
        low, high, unit = self._edge(least), self._edge(most), self.unit
        if self.quantity is not None and max(abs(low), abs(high)) >= MANY:
            low, high, unit = least, most, self.quantity.unit
        within = f"at least {low:g}" if most == inf else f"{low:g} to {'below ' if below else ''}{high:g}"
        return f"{'above ' if above else ''}{within} {unit}".rstrip()

    def number(self, value: Any) -> float:
        """Return the number that is shown for an SI value."""
        if self.quantity is None or not self.unit:
            return float(value)
        return split(self.quantity.text(value, self.unit))[0]

    def readable(self, value: float) -> Self:
        """Return the same in the SI unit, where its number in its own would be very large or small."""
        small, large = READABLE
        if self.quantity is None or value == 0.0 or small <= abs(self.number(value)) < large:
            return self
        return replace(self, unit=self.quantity.unit)

    def shown(self, value: Any) -> str:
        """Return what stands in the field for an SI value, without the unit."""
        if self.shape in {"number", "whole"}:
            return f"{self.number(value):.7g}"
        if self.shape == "list":
            return ", ".join(f"{self.number(item):.7g}" for item in value)
        return ", ".join(value) if isinstance(value, tuple) else str(value)

    def read(self, text: str) -> Any:
        """Return what a description says for what was typed: a bare number has the unit of the field.

        What can't be read is returned as it is: the description's checks say what is wrong with it.
        """
        if self.shape == "list":
            return [self._read_number(item.strip()) for item in text.split(",") if item.strip()]
        return self._read_number(text.strip()) if self.shape in {"number", "whole"} else text.strip()

    def _read_number(self, text: str) -> Any:
        if self.quantity is None:
            return _number(text, int if self.shape == "whole" else float)
        try:
            _, unit = split(text)
            if not unit:
                return f"{text} {self.unit}"
            return self.quantity.text(self.quantity.convert(text), self.unit) if unit != self.unit else text
        except QuantityError:
            return text

    def slider(self, value: float) -> tuple[float, float, float] | None:
        """Return least, most and step of a slider about an SI value, as numbers that are shown; None if it makes none.

        It goes from half of the value to twice the value, or where the limits are.
        """
        least, above, most, below = self.bounds
        if self.shape not in {"number", "whole"}:
            return None
        here = self.number(value)
        if most - least <= 1.0 and self.quantity is None:
            low, high = least, most
        elif here == 0.0:
            return None
        else:
            low, high = sorted((here / SPAN, here * SPAN)) if least > -inf else (-SPAN * abs(here), SPAN * abs(here))
            low, high = max(low, self._edge(least)), min(high, self._edge(most))
        if not high > low:
            return None
        step = 1.0 if self.shape == "whole" else _round_step((high - low) / STEPS)
        first, last = round(low / step), round(high / step)
        first += above and first * step <= self._edge(least)
        last -= below and last * step >= self._edge(most)
        return (_tidy(first * step), _tidy(last * step), step) if last > first else None

    def _edge(self, bound: float) -> float:
        return bound if abs(bound) == inf else self.number(bound)


def _round_step(rough: float) -> float:
    """Return 1, 2 or 5 times a power of ten, not above a step."""
    power = 10.0 ** floor(log10(rough))
    return float(f"{next(k for k in (5.0, 2.0, 1.0) if k * power <= rough * (1 + 1e-9)) * power:.3g}")


def _tidy(value: float) -> float:
    return float(f"{value:.12g}")


def _number(text: str, kind: type[int] | type[float]) -> Any:
    try:
        return kind(text)
    except ValueError:
        return text


def titled(key: str) -> str:
    """Return a key of a description as people write it: "pressure_gauge" is "Pressure (gauge)"."""
    words = key.removesuffix("_gauge").replace("_", " ")
    words += " (gauge)" if key.endswith("_gauge") else ""
    return words[:1].upper() + words[1:]


NOTES = {
    "paper": "from the paper",
    "derived": "follows from other values",
    "assumed": "assumed",
    "calibrated": "found by a calibration",
    "identified": "identified from measurements",
    "given": "the file does not say where it comes from",
    "default": "not in the file: the usual value",
    "edited": "changed here",
}
"""What a source means, where it has no note of its own."""


def place_of(section: str) -> str:
    """Return the name of a section, such as "Joint large, hose"."""
    first, *keys = section.split(".")
    if first == "joint":
        return ", ".join([f"Joint {keys[0]}", *(titled(key).lower() for key in keys[1:])])
    return ", ".join([titled(first), *(f"link {key}" for key in keys[1:])])  # "arm.link.base"


def sentence(meaning: str, limits: str) -> str:
    """Return meaning and limits of a value as one line."""
    meaning = meaning.replace("`", "")
    text = f"{meaning}; {limits}" if meaning and limits else meaning or limits
    return text[:1].upper() + text[1:]
