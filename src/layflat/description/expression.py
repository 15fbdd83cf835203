"""Text of a quantity: one number and one unit, and nothing that would have to be calculated.

number   "4", "-0.5", "2.5e-3"
unit     "mm", "N m", "dm^3/(s bar)", "kg*m**2", "1/s": names with whole exponents, products and quotients
"""

import re
from collections.abc import Iterator
from difflib import get_close_matches
from functools import lru_cache

from layflat.description.factors import BASE, CELSIUS, DERIVED, PREFIXED, PREFIXES, Product, canonical

_NUMBER = re.compile(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)(?![\d.,])\s*(.*?)\s*", re.DOTALL)
_COMMA = re.compile(r"\s*([-+]?\d+),(\d+)(?![\d.,])\s*(.*?)\s*", re.DOTALL)
_TOKEN = re.compile(
    r"""\s*(?:
    (?:\*\*|\^)\s*(?P<power>[-+]?\d+|\([-+]?\d+\))
    |(?P<raised>[⁻⁺]?[⁰¹²³⁴⁵⁶⁷⁸⁹]+)
    |(?P<sign>[*·/()])
    |(?P<one>1(?![\d.]))
    |(?P<name>[^\W\d⁰¹²³⁴⁵⁶⁷⁸⁹][^\W⁰¹²³⁴⁵⁶⁷⁸⁹]*|%|°C?)
    )""",
    re.VERBOSE,
)
_RAISED = str.maketrans("⁰¹²³⁴⁵⁶⁷⁸⁹⁻⁺", "0123456789-+")

THOUSANDS = 3  # digits behind a comma that may stand between thousands

LONGEST = 100  # characters of a quantity; more is not a quantity

GREATEST_EXPONENT = 9


class QuantityError(ValueError):
    """A text is not a quantity: what is wrong with it, and what would be right where that can be guessed."""

    def __init__(self, what: str, right: str = "") -> None:
        super().__init__(what)
        self.what, self.right = what, right


def split(text: str) -> tuple[float, str]:
    """Part a text into its number, which may be infinite or none, and its unit as text.

    Raises:
        QuantityError: it does not begin with one number.
    """
    if len(text) > LONGEST:
        raise QuantityError("is too long for a quantity")
    found = _NUMBER.fullmatch(text)
    if found:
        return float(found[1]), found[2]
    comma = _COMMA.fullmatch(text)
    if comma:
        number, unit = f"{comma[1]}.{comma[2]}", f" {comma[3]}".rstrip()
        right = f'write "{number}{unit}"'
        if len(comma[2]) == THOUSANDS:
            right += f', or "{comma[1]}{comma[2]}{unit}" if it stands between thousands'
        raise QuantityError("has a comma in its number", right)
    word, _, unit = text.strip().partition(" ")
    if word.lower().lstrip("+-") in {"nan", "inf", "infinity"}:
        return float(word), unit
    raise QuantityError("is not one number with one unit")


@lru_cache(maxsize=1000)
def unit_of(text: str) -> tuple[tuple[str, int], ...]:
    """Return the names of a unit with their exponents, in their order; none of an empty text.

    Raises:
        QuantityError: it is not a unit.
        UnknownUnitError: a name in it is that of no unit.
    """
    tokens = _tokens(text)
    product, rest = _product(tokens, depth=0)
    if rest:
        raise QuantityError(f"has a {rest[0]!r} too many in its unit")
    named: Product = {}
    for name, exponent in product:
        known = canonical(name)
        named[known] = named.get(known, 0) + exponent
    kept = {name: exponent for name, exponent in named.items() if exponent != 0}
    if CELSIUS in kept and kept != {CELSIUS: 1}:
        raise QuantityError("has degC in a product", "write K, which is the same for differences")
    return tuple(kept.items())


def _tokens(text: str) -> list[str]:
    found, at = [], 0
    while at < len(text.rstrip()):
        token = _TOKEN.match(text, at)
        if token is None:
            raise QuantityError("is not one number with one unit")
        power = token["power"] or (token["raised"] or "").translate(_RAISED)
        found.append(f"^{int(power.strip('()'))}" if power else token[0].strip())
        at = token.end()
    return found


def _product(tokens: list[str], depth: int) -> tuple[list[tuple[str, int]], list[str]]:
    """Read products and quotients up to a closing bracket or the end; return also what is left."""
    found: list[tuple[str, int]] = []
    sign, after_operator = 1, True
    while tokens and tokens[0] != ")":
        head, *rest = tokens
        if head in "*·/":
            if after_operator and not found:
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
            inner, rest = _raised(inner, int(rest[0][1:])), rest[1:]
        found += [(name, sign * exponent) for name, exponent in inner]
        sign, after_operator, tokens = 1, False, rest
    if after_operator and (found or depth):
        raise QuantityError("has a unit that is not complete")
    return found, tokens


def _raised(product: list[tuple[str, int]], exponent: int) -> list[tuple[str, int]]:
    if not 1 <= abs(exponent) <= GREATEST_EXPONENT:
        raise QuantityError(
            f"has an exponent of {exponent}", f"write one from -{GREATEST_EXPONENT} to {GREATEST_EXPONENT}"
        )
    return [(name, times * exponent) for name, times in product]


def suggestions(number: str, unit: str) -> Iterator[str]:
    """Yield texts with usual units in place of a name that is none: "25 N m" for "25 Nm", "3 kg" for "3 Kg"."""
    known = [*BASE, *DERIVED, CELSIUS, *(prefix + base for base in PREFIXED for prefix in PREFIXES)]
    for name in re.findall(r"[^\W\d]\w*", unit):
        if name in known:
            continue
        parted = [f"{name[:i]} {name[i:]}" for i in range(1, len(name)) if name[:i] in known and name[i:] in known]
        raised = [f"{name[:-1]}^{name[-1]}"] if name[:-1] in known and name[-1] in "23" else []
        same = sorted(one for one in known if one.lower() == name.lower())  # MPa before mPa
        for near in [*raised, *same, *parted, *get_close_matches(name, known, n=1, cutoff=0.7)]:
            yield f"{number} {unit.replace(name, near)}"
