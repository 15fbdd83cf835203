"""Prices of a user's own file, and what the parts of a parts list cost by them."""

from __future__ import annotations

from dataclasses import dataclass
from fnmatch import fnmatchcase
from math import pi
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple, get_args

from pydantic import Field, GetCoreSchemaHandler, ValidationError
from pydantic_core import core_schema

from layflat.description import Part
from layflat.description.explain import explain_error
from layflat.description.expression import QuantityError
from layflat.description.quantity import Quantity
from layflat.description.tables import parse_toml
from layflat.description.text import read_text
from layflat.description.wrong import INPUT_VALUE, value_error
from layflat.errors import InputError
from layflat.solids.component import Making
from layflat.solids.shapes import Joined, Prism
from layflat.solids.sizes import MM
from layflat.solids.standard.materials import MATERIALS

if TYPE_CHECKING:
    from layflat.solids.parts_list import ListedPart, PartsList
    from layflat.solids.shapes import Shape

PROCESS_NAMES = tuple(name for name in get_args(Making) if name != "bought")
CUT_PROCESS = "laser cutting"  # process that may be paid by the length of the cut
EXAMPLE_LINE = 'aluminium = "12 /kg"'


class Price(NamedTuple):
    """Price in the currency of its file, of a part or of a kilogram or metre."""

    amount: float
    unit: str = ""  # "1/kg", "1/m", or empty for a part


@dataclass(frozen=True)
class PriceForm:
    """Annotation of a price: the unit that it may have."""

    example: str
    quantity: Quantity | None = None  # of a price by something
    plain: bool = False  # whether it may be that of a part

    def read(self, value: Any) -> Price:
        """Return the price of a text such as "12 /kg" or of a bare number; raise ValueError if it is none."""
        right = f"give {self.example}, without a currency"
        if isinstance(value, bool) or not isinstance(value, (str, int, float)):
            raise value_error("is not a price", right, INPUT_VALUE)
        number, slash, unit = str(value).partition("/")
        price = self._parse(number, unit if slash else "")
        if price is None:
            raise value_error("is not a price of this form", right, INPUT_VALUE)
        if not 0.0 <= price.amount < float("inf"):
            raise value_error("is out of range", "give 0 or more", INPUT_VALUE)
        return price

    def _parse(self, number: str, unit: str) -> Price | None:
        """Return the price of a number by a unit, or of a part; None if it may not be that."""
        try:
            if not unit:
                return Price(float(number)) if self.plain else None
            if self.quantity is not None:
                return Price(self.quantity.convert(f"{number} 1/{unit.strip()}"), self.quantity.unit)
        except (QuantityError, ValueError):
            pass
        return None

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> core_schema.CoreSchema:
        """Read texts into prices, and write these as text into JSON."""
        as_text = core_schema.plain_serializer_function_ser_schema(
            lambda price: f"{price.amount!r} {price.unit[1:]}".strip(), when_used="json"
        )
        return core_schema.no_info_plain_validator_function(self.read, serialization=as_text)


BY_MASS = PriceForm('a price such as "12 /kg"', Quantity("price of a mass", "1/kg", "12 /kg"))
BY_PART = PriceForm('a price such as "0.5"', plain=True)
BY_CUT = PriceForm(
    'a price such as "2", or for laser cutting "3 /m"', Quantity("price of a cut", "1/m", "3 /m"), plain=True
)


class Prices(Part):
    """Prices: of stock by material, of making a part by process, of bought parts by patterns of designations."""

    stock: Annotated[dict[str, Annotated[Price, BY_MASS]], Field(default_factory=dict)]
    process: Annotated[dict[str, Annotated[Price, BY_CUT]], Field(default_factory=dict)]
    bought: Annotated[dict[str, Annotated[Price, BY_PART]], Field(default_factory=dict)]

    def price_of(self, part: ListedPart) -> float | None:
        """Return the price of one part: bought by the longest pattern that fits, or made; None without a price.

        A part that is made has the price of its own mass of stock and that of its process.
        """
        if part.bought:
            fitting = [pattern for pattern in self.bought if fnmatchcase(part.material, pattern)]
            return self.bought[max(fitting, key=len)].amount if fitting else None
        one = part.components[0]
        stock, making = self.stock.get(one.material), self.process.get(one.making)
        if stock is None or making is None:
            return None
        return stock.amount * part.mass_each + making.amount * (cut_length(one.shape) / MM if making.unit else 1.0)


@dataclass(frozen=True)
class Cost:
    """Cost of the parts that have a price, in the currency of the prices."""

    each: dict[int, float]  # of one part, by its number
    joints: dict[str, float]  # of all parts, by joint; the empty name is that of the arm
    unpriced: tuple[ListedPart, ...]  # parts without a price, which count as nothing

    @property
    def total(self) -> float:
        """Cost of all parts."""
        return sum(self.joints.values())


def read_prices(path: str | Path) -> Prices:
    """Return the prices of a TOML file.

    Raises:
        InputError: in one line, which file, key and value is wrong and what would be right.
    """
    where = str(path)
    plain = parse_toml(read_text(Path(path), where, "give a TOML file of prices"), where, EXAMPLE_LINE)
    for table, noun, known in (("stock", "material", tuple(MATERIALS)), ("process", "process", PROCESS_NAMES)):
        keys = plain.get(table)
        unknown = [key for key in keys if key not in known] if isinstance(keys, dict) else []
        if unknown:
            what = f"unknown {noun} {unknown[0]!r}"
            raise InputError(what, where=f"{where}: {table}", right=f"known are {', '.join(known)}")
    try:
        prices = Prices.model_validate(plain)
    except ValidationError as error:
        raise explain_error(error, where, Prices) from None
    by_length = [name for name, price in prices.process.items() if price.unit and name != CUT_PROCESS]
    if by_length:
        what = f"only {CUT_PROCESS} has a price by length"
        raise InputError(what, where=f"{where}: process.{by_length[0]}", right=f"give {BY_PART.example}")
    return prices


def cost_of(parts: PartsList, prices: Prices) -> Cost:
    """Return what the parts of a parts list cost."""
    each: dict[int, float] = {}
    joints = dict.fromkeys(parts.masses, 0.0)
    unpriced = []
    for part in parts.parts:
        price = prices.price_of(part)
        if price is None:
            unpriced.append(part)
            continue
        each[part.number] = price
        for name, number in part.joints.items():
            joints[name] += number * price
    return Cost(each, joints, tuple(unpriced))


def cut_length(shape: Shape) -> float:
    """Return the length of the cuts through a plate that make a flat part, mm; 0 for a part that is not flat."""
    match shape:
        case Prism():
            loops = (shape.outline, *shape.openings)
            return sum(loop.perimeter for loop in loops) + pi * sum(one.diameter for one in shape.holes)
        case Joined():
            return sum(cut_length(piece) for piece, _ in shape.placed())
        case _:
            return 0.0
