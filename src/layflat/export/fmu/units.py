"""Units as FMI defines them: exponents of the base units, read from a unit's text or from a field's comment."""

import re
from collections.abc import Mapping

BASE_UNITS = ("kg", "m", "s", "A", "K", "mol", "cd", "rad")

Exponents = Mapping[str, int]

UNIT_SYMBOLS: dict[str, dict[str, int]] = {
    **{name: {name: 1} for name in BASE_UNITS},
    "1": {},
    "Hz": {"s": -1},
    "N": {"kg": 1, "m": 1, "s": -2},
    "Pa": {"kg": 1, "m": -1, "s": -2},
    "J": {"kg": 1, "m": 2, "s": -2},
    "W": {"kg": 1, "m": 2, "s": -3},
    "V": {"kg": 1, "m": 2, "s": -3, "A": -1},
}
"""Symbols that texts of units are made of; a digit behind one is its power."""


def unit_exponents(unit: str) -> Exponents | None:
    """Return the exponents of a unit such as "N m s/(rad Pa)" or "V/rad/s", without zeros; None: it is no unit."""
    if not re.fullmatch(r"[^/()]+(/\([^/()]+\)|/[^/() *]+)*", unit.strip()):
        return None
    numerator, *denominators = re.sub(r"[\^()]", "", unit).replace("*", " ").split("/")
    total: dict[str, int] = {}
    parts = [(symbol, 1) for symbol in numerator.split()]
    parts += [(symbol, -1) for denominator in denominators for symbol in denominator.split()]
    for symbol, sign in parts:
        bare, power = (symbol, "1") if symbol in UNIT_SYMBOLS else (symbol[:-1], symbol[-1])
        if bare not in UNIT_SYMBOLS or power not in "123456789":
            return None
        for base, exponent in UNIT_SYMBOLS[bare].items():
            total[base] = total.get(base, 0) + sign * int(power) * exponent
    return {base: total[base] for base in BASE_UNITS if total.get(base)}


def commented_unit(comment: str) -> str:
    """Return the unit that a field's comment states, behind a comma, or before a colon; empty: none.

    Example:
        `"k_p, V/Pa"` states `V/Pa`, and `"Pa: of hose A"` states `Pa`.
    """
    for part in (comment.rpartition(", ")[2], *re.split(r"[;:,]", comment)):
        unit = part.strip().rstrip(".")
        if unit and unit_exponents(unit) is not None:
            return unit
    return ""
