"""Quantities: text with a unit in files, an SI float inside, and the range of plausible values."""

import math
import re
import sys
from contextlib import suppress
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

from pydantic import GetCoreSchemaHandler, GetJsonSchemaHandler, ValidationInfo
from pydantic_core import core_schema

from layflat.description.expression import QuantityError, split_quantity, suggestions, unit_of
from layflat.description.factors import (
    BASE_UNITS,
    CELSIUS,
    ZERO_CELSIUS,
    Product,
    UnknownUnitError,
    factor,
    is_own,
    registry,
    roots,
)
from layflat.description.wrong import INPUT_VALUE, value_error

ROUNDING_MARGIN = 1e-6  # relative excess of a bound that is accepted, since numbers are written with seven digits

SI = {"si": True}  # context of a validation in which numbers are in SI units, since they come from code


@dataclass(frozen=True)
class Quantity:
    """Kind of quantity: its name, SI unit and range of plausible magnitudes."""

    name: str
    unit: str  # SI
    example: str  # of a text with a unit, for messages
    least: float = field(default=0.0, compare=False)
    """Min magnitude (SI) of a value other than zero."""
    most: float = field(default=math.inf, compare=False)  # max magnitude (SI)

    @property
    def article(self) -> str:
        """Name with its article."""
        return f"{'an' if self.name[0] in 'aeiou' else 'a'} {self.name}"

    @property
    def right(self) -> str:
        """Advice with an example of a valid value."""
        return f'give {self.article} such as "{self.example}"'

    @cached_property
    def _target(self) -> Product:
        return dict(unit_of(self.unit))

    @cached_property
    def _needs_radian(self) -> bool:
        """True if only the radian tells it from another quantity: an angle from a share, a speed from a rate."""
        return _without_radian(roots(self._target)) in ({}, {"s": -1})

    def parse(self, value: object) -> float:
        """Return the SI float of a text such as "160 mm", within the plausible range.

        Raises:
            QuantityError: it is no text of this quantity, or out of range; with advice.
        """
        return self.check_range(self.convert(value))

    def convert(self, value: object) -> float:
        """Return the SI float of a text, of any magnitude.

        Raises:
            QuantityError: it is no text of this quantity; with advice.
        """
        if isinstance(value, bool) or not isinstance(value, (str, int, float)):
            raise QuantityError(f"is not {self.article}", self.right)
        if not isinstance(value, str):
            raise QuantityError("is a bare number", self.right)
        try:
            number, unit = split_quantity(value)
            source = dict(unit_of(unit))
        except UnknownUnitError:
            self._refuse_reference(value)
            raise QuantityError(f"is not a number with a unit of {self.name}", self._nearest(value, unit)) from None
        except QuantityError as error:
            raise QuantityError(error.what, error.right or self.right) from None
        if not source:
            raise QuantityError("is a bare number", self.right)
        if not math.isfinite(number):
            raise QuantityError("is not finite", self.right)
        if not self._measures(source):
            self._refuse_reference(value)
            raise QuantityError(f"is not {self.article}", self._nearest(value, unit))
        return self._convert(number, source)

    def check_range(self, number: float) -> float:
        """Return an SI float; raise QuantityError unless it is 0 or its magnitude is plausible and finite."""
        if self.finite(number) != 0.0 and not (
            self.least * (1.0 - ROUNDING_MARGIN) <= abs(number) <= self.most * (1.0 + ROUNDING_MARGIN)
        ):
            right = f"give {self.article} between {self.least:g} and {self.most:g} {self.unit}"
            raise QuantityError("is out of range", right)
        return number

    def finite(self, number: float) -> float:
        """Return an SI float if it is finite; raise QuantityError if it is not."""
        if not math.isfinite(number):
            raise QuantityError("is not finite", self.right)
        return number

    def text(self, value: float, unit: str, digits: int = 7) -> str:
        """Return an SI float as text in another unit; magnitudes below the plausible range become zero.

        `parse` accepts a text of seven digits or more: rounding does not put a value out of range.

        Args:
            value: SI.
            unit: unit of the text, compatible with the quantity's.
            digits: significant digits.
        """
        value = value if abs(value) >= self.least else 0.0
        source, target = self._target, dict(unit_of(unit))
        if target == {CELSIUS: 1}:
            number = value - ZERO_CELSIUS
        elif source == target:
            number = value
        elif is_own(target):
            number = value * factor(source, target)
        else:
            number = float(registry().Quantity(value, _pint(source)).to(_pint(target)).magnitude)
        return f"{number:.{digits}g} {unit}"

    def _refuse_reference(self, text: str) -> None:
        """Raise QuantityError if the unit of a pressure says gauge or absolute, which the key determines."""
        match = REFERENCE_PATTERN.fullmatch(text.strip()) if self.unit == "Pa" else None
        if match is not None:
            what = "is a gauge pressure" if match["gauge"] else "is an absolute pressure"
            right = f'write "{match["plain"]}" only if that is meant here: names tell which pressures are gauge'
            raise QuantityError(what, right)

    def _nearest(self, text: str, unit: str) -> str:
        """Return advice for a text whose unit is not one of this quantity: the nearest such text, else an example."""
        for near in suggestions(text.strip().removesuffix(unit).strip(), unit):
            with suppress(ValueError):
                if self._measures(dict(unit_of(near.partition(" ")[2]))):
                    return f'did you mean "{near}"?'
        return self.right

    def _measures(self, source: Product) -> bool:
        """Return whether a unit measures this quantity; radians count only where they tell it from another one."""
        if source == {CELSIUS: 1}:
            return self.unit == "K"
        unit, target = _roots(source), _roots(self._target)
        return unit == target if self._needs_radian else _without_radian(unit) == _without_radian(target)

    def _convert(self, number: float, source: Product) -> float:
        """Return a number of the unit `source` in the quantity's own unit."""
        if source == {CELSIUS: 1}:
            return number + ZERO_CELSIUS
        if source == self._target:
            return number
        if is_own(source):
            return number * factor(source, self._target)
        return float(registry().Quantity(number, _pint(source)).to(_pint(self._target)).magnitude)

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> core_schema.CoreSchema:
        """Return the schema that validates text into an SI float, then checks the bounds of the annotation.

        In the context `SI` it accepts numbers too; in JSON a value is text in the SI unit.
        """

        def validate(value: object, info: ValidationInfo) -> float:
            try:
                if info.context == SI and isinstance(value, (int, float)) and not isinstance(value, bool):
                    return self.check_range(float(value) if abs(value) < sys.float_info.max else math.inf)
                return self.parse(value)
            except QuantityError as error:
                raise value_error(error.what, error.right, INPUT_VALUE) from None

        def serialize(value: float) -> str:
            return f"{value!r} {self.unit}"

        as_text = core_schema.plain_serializer_function_ser_schema(serialize, when_used="json")
        return core_schema.with_info_before_validator_function(
            validate, handler(source), serialization=as_text, metadata={"quantity": self}
        )

    def __get_pydantic_json_schema__(self, schema: core_schema.CoreSchema, handler: GetJsonSchemaHandler) -> Any:
        """Return the JSON schema: a text with a unit."""
        return {
            "type": "string",
            "title": self.name,
            "examples": [self.example],
            "pattern": r"^\s*[-+.\d].*[^\d\s.].*$",
        }


REFERENCE_PATTERN = re.compile(
    r"(?P<plain>.*?(?:[Pp][Aa]|[Bb][Aa][Rr]|psi|at|atm))\s*\(?(?:(?P<gauge>g|ga|gauge|ü)|(?P<absolute>a|abs|absolute))\.?\)?"
)
"""Text of a pressure whose unit says gauge or absolute: "4 barg", "60 psi(a)", "5 bar abs"."""


def _roots(product: Product) -> Product:
    """Return a product in base units, by Pint if only Pint knows one of its names."""
    if is_own(product):
        return roots(product)
    pint = registry()
    names = {str(pint.get_name(name)): name for name in BASE_UNITS}
    base_units: dict[str, Any] = dict(pint.get_root_units(_pint(product))[1]._units)
    return {names.get(name, name): exponent for name, exponent in base_units.items()}


def _pint(product: Product) -> Any:
    """Return a product as a unit of Pint."""
    pint = registry()
    return pint.Unit(pint.UnitsContainer({pint.get_name(name): exponent for name, exponent in product.items()}))


def _without_radian(product: Product) -> Product:
    return {name: exponent for name, exponent in product.items() if name != "rad"}
