"""A kind of quantity: text with a unit outside, an SI float inside, and the range in which it makes sense."""

import math
import re
import sys
from contextlib import suppress
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

from pydantic import GetCoreSchemaHandler, GetJsonSchemaHandler, ValidationInfo
from pydantic_core import core_schema

from layflat.description.expression import QuantityError, split, suggestions, unit_of
from layflat.description.factors import (
    BASE,
    CELSIUS,
    ZERO_CELSIUS,
    Product,
    UnknownUnitError,
    factor,
    is_own,
    registry,
    roots,
)
from layflat.description.wrong import INPUT, wrong

ROUNDING = 1e-6  # by which a number that is written with seven digits may lie beyond a bound, relative

SI = {"si": True}  # context of a validation in which numbers are taken to be in SI units, since they come from code


@dataclass(frozen=True)
class Quantity:
    """A kind of quantity."""

    name: str  # what it is called
    unit: str  # its SI unit
    example: str  # for those who got it wrong
    least: float = field(default=0.0, compare=False)
    """Magnitude (SI) below which a value other than zero makes no sense."""
    most: float = field(default=math.inf, compare=False)  # magnitude (SI) above which none does

    @property
    def article(self) -> str:
        """The name with its article."""
        return f"{'an' if self.name[0] in 'aeiou' else 'a'} {self.name}"

    @property
    def right(self) -> str:
        """Advice with an example of a value that would be right."""
        return f'give {self.article} such as "{self.example}"'

    @cached_property
    def _target(self) -> Product:
        return dict(unit_of(self.unit))

    @cached_property
    def _told_by_radian(self) -> bool:
        """True where only a radian tells it from another kind: an angle from a share, a rotation from a rate."""
        return _without_radian(roots(self._target)) in ({}, {"s": -1})

    def parse(self, value: object) -> float:
        """Return the SI float of a text such as "160 mm", within the range that makes sense.

        Raises:
            QuantityError: what is wrong with it, and what would be right.
        """
        return self.within(self.convert(value))

    def convert(self, value: object) -> float:
        """Return the SI float of a text, however large or small.

        Raises:
            QuantityError: what is wrong with it, and what would be right.
        """
        if isinstance(value, bool) or not isinstance(value, (str, int, float)):
            raise QuantityError(f"is not {self.article}", self.right)
        if not isinstance(value, str):
            raise QuantityError("is a bare number", self.right)
        try:
            number, unit = split(value)
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
        return self._converted(number, source)

    def within(self, number: float) -> float:
        """Return an SI float if it makes sense; raise QuantityError if its magnitude is too large or too small."""
        if self.finite(number) != 0.0 and not (
            self.least * (1.0 - ROUNDING) <= abs(number) <= self.most * (1.0 + ROUNDING)
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
        """Return an SI float as text in another unit; zero where no other value makes sense.

        `parse` takes what is written with seven digits or more: rounding does not put a value out of range.
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
        """Raise QuantityError if a pressure says in its unit against what it counts, which is not for it to say."""
        found = REFERENCE.fullmatch(text.strip()) if self.unit == "Pa" else None
        if found is not None:
            what = "is a gauge pressure" if found["gauge"] else "is an absolute pressure"
            right = f'write "{found["plain"]}" only if that is meant here: names tell which pressures are gauge'
            raise QuantityError(what, right)

    def _nearest(self, text: str, unit: str) -> str:
        """Explain a text whose unit is none of this kind."""
        for near in suggestions(text.strip().removesuffix(unit).strip(), unit):
            with suppress(ValueError):
                if self._measures(dict(unit_of(near.partition(" ")[2]))):
                    return f'did you mean "{near}"?'
        return self.right

    def _measures(self, source: Product) -> bool:
        """Tell whether a unit measures this kind."""
        if source == {CELSIUS: 1}:
            return self.unit == "K"
        found, wanted = _roots(source), _roots(self._target)
        return found == wanted if self._told_by_radian else _without_radian(found) == _without_radian(wanted)

    def _converted(self, number: float, source: Product) -> float:
        if source == {CELSIUS: 1}:
            return number + ZERO_CELSIUS
        if source == self._target:
            return number
        if is_own(source):
            return number * factor(source, self._target)
        return float(registry().Quantity(number, _pint(source)).to(_pint(self._target)).magnitude)

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> core_schema.CoreSchema:
        """Validate text into an SI float, then check whatever bounds stand beside."""

        def validate(value: object, info: ValidationInfo) -> float:
            try:
                if info.context == SI and isinstance(value, (int, float)) and not isinstance(value, bool):
                    return self.within(float(value) if abs(value) < sys.float_info.max else math.inf)
                return self.parse(value)
            except QuantityError as error:
                raise wrong(error.what, error.right, INPUT) from None

        def written(value: float) -> str:
            return f"{value!r} {self.unit}"

        as_text = core_schema.plain_serializer_function_ser_schema(written, when_used="json")
        return core_schema.with_info_before_validator_function(
            validate, handler(source), serialization=as_text, metadata={"quantity": self}
        )

    def __get_pydantic_json_schema__(self, schema: core_schema.CoreSchema, handler: GetJsonSchemaHandler) -> Any:
        """Describe it to editors as a text with a unit."""
        return {
            "type": "string",
            "title": self.name,
            "examples": [self.example],
            "pattern": r"^\s*[-+.\d].*[^\d\s.].*$",
        }


REFERENCE = re.compile(
    r"(?P<plain>.*?(?:[Pp][Aa]|[Bb][Aa][Rr]|psi|at|atm))\s*\(?(?:(?P<gauge>g|ga|gauge|ü)|(?P<absolute>a|abs|absolute))\.?\)?"
)
"""A pressure whose unit says against what it counts: "4 barg", "60 psi(a)", "5 bar abs"."""


def _roots(product: Product) -> Product:
    """Return a product in base units, with the help of Pint for names that are its alone."""
    if is_own(product):
        return roots(product)
    pint = registry()
    names = {str(pint.get_name(name)): name for name in BASE}
    found: dict[str, Any] = dict(pint.get_root_units(_pint(product))[1]._units)
    return {names.get(name, name): exponent for name, exponent in found.items()}


def _pint(product: Product) -> Any:
    pint = registry()
    return pint.Unit(pint.UnitsContainer({pint.get_name(name): exponent for name, exponent in product.items()}))


def _without_radian(product: Product) -> Product:
    return {name: exponent for name, exponent in product.items() if name != "rad"}
