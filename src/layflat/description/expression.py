"""Text of a quantity: one number and one unit, without arithmetic.

number   "4", "-0.5", "2.5e-3"
unit     "mm", "N m", "dm^3/(s bar)", "kg*m**2", "1/s": names with whole exponents, products and quotients
"""

import re
from collections.abc import Iterator
from difflib import get_close_matches
from functools import lru_cache

from layflat.description.factors import BASE_UNITS, CELSIUS, DERIVED_UNITS, PREFIXED_UNITS, PREFIXES, Product, canonical

_NUMBER_PATTERN = re.compile(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)(?![\d.,])\s*(.*?)\s*", re.DOTALL)
_COMMA_PATTERN = re.compile(r"\s*([-+]?\d+),(\d+)(?![\d.,])\s*(.*?)\s*", re.DOTALL)
_TOKEN_PATTERN = re.compile(
    r"""\s*(?:
    (?:\*\*|\^)\s*(?P<power>[-+]?\d+|\([-+]?\d+\))
    |(?P<raised>[⁻⁺]?[⁰¹²³⁴⁵⁶⁷⁸⁹]+)
    |(?P<sign>[*·/()])
    |(?P<one>1(?![\d.]))
    |(?P<name>[^\W\d⁰¹²³⁴⁵⁶⁷⁸⁹][^\W⁰¹²³⁴⁵⁶⁷⁸⁹]*|%|°C?)
    )""",
    re.VERBOSE,
)
_SUPERSCRIPT_DIGITS = str.maketrans("⁰¹²³⁴⁵⁶⁷⁸⁹⁻⁺", "0123456789-+")

THOUSANDS_DIGITS = 3  # digits after a comma that may separate thousands

MAX_CHARACTERS = 100  # of a quantity

MAX_EXPONENT = 9


class QuantityError(ValueError):
    """Error of a text that is not a quantity: the problem `what`, and the advice `right` if there is one."""

    def __init__(self, what: str, right: str = "") -> None:
        super().__init__(what)
        self.what, self.right = what, right


def split_quantity(text: str) -> tuple[float, str]:
    """Split a text into its number, which may be infinite or NaN, and the text of its unit.

    Raises:
        QuantityError: it does not begin with one number, has a comma there, or is longer than `MAX_CHARACTERS`.
    """
    if len(text) > MAX_CHARACTERS:
        raise QuantityError("is too long for a quantity")
    match = _NUMBER_PATTERN.fullmatch(text)
    if match:
        return float(match[1]), match[2]
    comma = _COMMA_PATTERN.fullmatch(text)
    if comma:
        number, unit = f"{comma[1]}.{comma[2]}", f" {comma[3]}".rstrip()
        right = f'write "{number}{unit}"'
        if len(comma[2]) == THOUSANDS_DIGITS:
            right += f', or "{comma[1]}{comma[2]}{unit}" if it stands between thousands'
        raise QuantityError("has a comma in its number", right)
    word, _, unit = text.strip().partition(" ")
    if word.lower().lstrip("+-") in {"nan", "inf", "infinity"}:
        return float(word), unit
    raise QuantityError("is not one number with one unit")


@lru_cache(maxsize=1000)
def unit_of(text: str) -> tuple[tuple[str, int], ...]:
    """Return the canonical names in a unit with their exponents, in order; empty for an empty text.

    Names that cancel are left out.

    Raises:
        QuantityError: the text is not a unit, or has degC in a product.
        UnknownUnitError: a name in it is unknown.
    """
    tokens = _split_tokens(text)
    product, rest = _product(tokens, depth=0)
    if rest:
        raise QuantityError(f"has a {rest[0]!r} too many in its unit")
    named: Product = {}
    for name, exponent in product:
        usual = canonical(name)
        named[usual] = named.get(usual, 0) + exponent
    remaining = {name: exponent for name, exponent in named.items() if exponent != 0}
    if CELSIUS in remaining and remaining != {CELSIUS: 1}:
        raise QuantityError("has degC in a product", "write K, which is the same for differences")
    return tuple(remaining.items())


def _split_tokens(text: str) -> list[str]:
    """Return the tokens of a unit, with powers in any notation (m^2, m**2, m²) as "^2".

    Raises:
        QuantityError: a character belongs to no unit.
    """
    tokens, position = [], 0
    while position < len(text.rstrip()):
        token = _TOKEN_PATTERN.match(text, position)
        if token is None:
            raise QuantityError("is not one number with one unit")
        power = token["power"] or (token["raised"] or "").translate(_SUPERSCRIPT_DIGITS)
        tokens.append(f"^{int(power.strip('()'))}" if power else token[0].strip())
        position = token.end()
    return tokens


def _product(tokens: list[str], depth: int) -> tuple[list[tuple[str, int]], list[str]]:
    """Return the names with exponents up to a closing bracket or the end, and the remaining tokens.

    `depth` is the number of open brackets.

    Raises:
        QuantityError: the tokens are no product.
    """
    factors: list[tuple[str, int]] = []
    sign, after_operator = 1, True
    while tokens and tokens[0] != ")":
        head, *rest = tokens
        if head in "*·/":
            if after_operator and not factors:
                raise QuantityError("is not one number with one unit")
            if after_operator:
                raise QuantityError("has two signs side by side in its unit")
            sign, after_operator, tokens = (-1 if head == "/" else 1), True, rest
            continue
        if head.startswith("^"):
            raise QuantityError("has an exponent without a unit")
        if head == "(":
            inner, rest = _product(rest, depth + 1)
            if not rest:
                raise QuantityError("has a bracket that does not close")
            rest = rest[1:]
        else:
            inner = [] if head == "1" else [(head, 1)]
        if rest and rest[0].startswith("^"):
            inner, rest = _raise_to_power(inner, int(rest[0][1:])), rest[1:]
        factors += [(name, sign * exponent) for name, exponent in inner]
        sign, after_operator, tokens = 1, False, rest
    if after_operator and (factors or depth):
        raise QuantityError("has a unit that is not complete")
    return factors, tokens


def _raise_to_power(product: list[tuple[str, int]], exponent: int) -> list[tuple[str, int]]:
    """Return a product raised to a power; raise QuantityError unless its magnitude is 1 to `MAX_EXPONENT`."""
    if not 1 <= abs(exponent) <= MAX_EXPONENT:
        raise QuantityError(f"has an exponent of {exponent}", f"write one from -{MAX_EXPONENT} to {MAX_EXPONENT}")
    return [(name, times * exponent) for name, times in product]


def suggestions(number: str, unit: str) -> Iterator[str]:
    """Yield texts with known units in place of an unknown name: "25 N m" for "25 Nm", "3 kg" for "3 Kg"."""
    known = [*BASE_UNITS, *DERIVED_UNITS, CELSIUS, *(prefix + base for base in PREFIXED_UNITS for prefix in PREFIXES)]
    for name in re.findall(r"[^\W\d]\w*", unit):
        if name in known:
            continue
        parted = [f"{name[:i]} {name[i:]}" for i in range(1, len(name)) if name[:i] in known and name[i:] in known]
        raised = [f"{name[:-1]}^{name[-1]}"] if name[:-1] in known and name[-1] in "23" else []
        same = sorted(unit_name for unit_name in known if unit_name.lower() == name.lower())  # MPa before mPa
        for near in [*raised, *same, *parted, *get_close_matches(name, known, n=1, cutoff=0.7)]:
            yield f"{number} {unit.replace(name, near)}"
