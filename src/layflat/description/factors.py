"""Conversion of common units without Pint, whose import takes half a second, with exactly Pint's results.

A unit is a product of names with exponents, such as {"N": 1, "m": 1}. A name is either a base unit or has a scale and
an equivalent product, as in Pint's definitions: the factor of a conversion is then the same product of the same floats
in the same order. Names that are not listed here are looked up in Pint.
"""

from functools import cache
from math import pi
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import pint

Product = dict[str, int]

BASE_UNITS = ("m", "g", "s", "A", "K", "rad")

DERIVED_UNITS: dict[str, tuple[float, Product]] = {
    "π": (pi, {}),
    "deg": (1 / 180, {"π": 1, "rad": 1}),
    "turn": (2.0, {"π": 1, "rad": 1}),
    "rpm": (1.0, {"turn": 1, "min": -1}),
    "min": (60.0, {"s": 1}),
    "h": (60.0, {"min": 1}),
    "Hz": (1.0, {"s": -1}),
    "N": (1.0, {"kg": 1, "m": 1, "s": -2}),
    "Pa": (1.0, {"N": 1, "m": -2}),
    "hPa": (100.0, {"Pa": 1}),
    "bar": (1e5, {"Pa": 1}),
    "J": (1.0, {"N": 1, "m": 1}),
    "W": (1.0, {"J": 1, "s": -1}),
    "C": (1.0, {"A": 1, "s": 1}),
    "V": (1.0, {"J": 1, "C": -1}),
    "l": (1.0, {"dm": 3}),
    "%": (0.01, {}),
}

PREFIXES = {"n": 1e-9, "u": 1e-6, "m": 1e-3, "c": 1e-2, "d": 0.1, "k": 1e3, "M": 1e6, "G": 1e9}

PREFIXED_UNITS = ("m", "g", "s", "A", "K", "rad", "Hz", "N", "Pa", "bar", "J", "W", "V", "l")

CELSIUS = "degC"  # the only unit with an offset; it is in no product

ZERO_CELSIUS = 273.15

UNIT_ALIASES = {"L": "l", "°C": CELSIUS, "°": "deg", "liter": "l", "rev": "turn"}  # other spellings


class UnknownUnitError(ValueError):
    """Error of a name that no unit has; its argument is the name."""


def canonical(name: str) -> str:
    """Return the canonical name of a unit in any usual spelling.

    Raises:
        UnknownUnitError: neither this module nor Pint knows the name.
    """
    plain = name.replace("µ", "u").replace("μ", "u")
    plain = UNIT_ALIASES.get(plain, plain)
    if plain == CELSIUS or definition(plain) is not None or plain in BASE_UNITS:
        return plain
    if len(plain) == 2 and plain[1] == "L":
        return canonical(f"{plain[0]}l")
    return _pint_name(name)


def definition(name: str) -> tuple[float, Product] | None:
    """Return scale and product of a canonical name; None for a base unit and for one that only Pint knows."""
    if name in DERIVED_UNITS:
        return DERIVED_UNITS[name]
    if name not in BASE_UNITS and name[:1] in PREFIXES and name[1:] in PREFIXED_UNITS:
        return PREFIXES[name[0]], {name[1:]: 1}
    return None


def is_own(product: Product) -> bool:
    """Return whether every name of a product is listed in this module."""
    return all(name in BASE_UNITS or definition(name) is not None for name in product)


def roots(product: Product) -> Product:
    """Return a product in base units, without scales, pi and zero exponents; equal roots mean compatible units."""
    base_units: Product = {}
    for name, exponent in product.items():
        derived = definition(name)
        below = {name: 1} if derived is None else roots(derived[1])
        for base, times in below.items():
            base_units[base] = base_units.get(base, 0) + exponent * times
    return {name: exponent for name, exponent in base_units.items() if exponent != 0 and name != "π"}


def factor(source: Product, target: Product) -> float:
    """Return the factor that converts numbers from one unit into a compatible one.

    The scales of all names, collected from the outside in, are cancelled against each other; the remaining scales of
    the numerator and then those of the denominator are multiplied in this order.
    """
    both = dict(source)
    for name, exponent in target.items():
        both[name] = both.get(name, 0) - exponent
    above: dict[float, int] = {}
    below: dict[float, int] = {}

    def collect(product: Product, power: int) -> None:
        """Add the scales of a product to a power to `above` or `below`, by the sign of their exponents."""
        for name, exponent in product.items():
            derived, total = definition(name), power * exponent
            if derived is None:
                continue
            side = below if total < 0 else above
            side[derived[0]] = side.get(derived[0], 0) + abs(total)
            collect(derived[1], total)

    collect({name: exponent for name, exponent in both.items() if exponent != 0}, 1)
    result: float = 1
    for scale, count in above.items():
        if count > below.get(scale, 0):
            result *= scale ** (count - below.get(scale, 0))
    for scale, count in below.items():
        if count > above.get(scale, 0):
            result *= scale ** -(count - above.get(scale, 0))
    return result


@cache
def registry() -> "pint.UnitRegistry[float]":
    """Return Pint's registry of units, which takes longer to load than most commands to run."""
    import pint  # noqa: PLC0415

    return pint.UnitRegistry(autoconvert_offset_to_baseunit=True)


def _pint_name(name: str) -> str:
    """Return Pint's name of a unit; raise UnknownUnitError if it knows none."""
    if not name.isidentifier():
        raise UnknownUnitError(name)
    import pint  # noqa: PLC0415

    try:
        return str(registry().get_name(name))
    except (pint.errors.PintError, AttributeError, ValueError):
        raise UnknownUnitError(name) from None
