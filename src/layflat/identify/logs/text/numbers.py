"""Numbers as people write them: decimal point or comma, thousands, signs that are not ASCII, units behind them."""

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from math import isnan
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from layflat.arrays import Array
from layflat.errors import InputError

Decimal = Literal[".", ","]

_SAME = str.maketrans(
    dict.fromkeys("\u2212\u2012\u2013\u2010\u2011\ufe63\uff0d", "-")  # minus signs and dashes
    | dict.fromkeys("\u00a0\u2007\u2009\u202f", " ")  # spaces that do not break
    | dict.fromkeys("\u2019\u02bc\u00b4`", "'")  # apostrophes
)
_EXPONENT = r"(?:[eEdD][-+]?\d+)?"
_POINT = re.compile(rf"[-+]? ?(?:[1-9]\d{{0,2}}(?:([,' ])\d{{3}})(?:\1\d{{3}})*|\d+)?(?:\.\d*)?{_EXPONENT}")
_COMMA = re.compile(rf"[-+]? ?(?:[1-9]\d{{0,2}}(?:([.' ])\d{{3}})(?:\1\d{{3}})*|\d+)?(?:,\d+)?{_EXPONENT}")
_PLAIN = re.compile(rf"[-+]?\d+{_EXPONENT}")
_NO_NUMBER = re.compile(r"[-+]?nan(?:\(.*\))?|[-+]?1\.#\w+|[-+]?inf(?:inity)?", re.IGNORECASE)
_WRAPPED = re.compile(r'="([^"]*)"|\'([^\']*)\'?|(?:np\.\w+|numpy\.\w+|tensor)\(([^()]*)\)')  # by Excel, by repr()
_SMALL = re.compile(r"[-+]?\d{1,3}")
LEAST_GROUPS = 3  # cells of either kind that tell thousands from fractions
SWITCHES = {"true": 1.0, "false": 0.0, "on": 1.0, "off": 0.0}

MISSING = frozenset({"", "-", "--", "---", "na", "n/a", "#n/a", "null", "none", "ol", "missing", "?", "*"})
"""Texts in place of a sample that is missing, in small letters."""


@dataclass(frozen=True)
class Reading:
    """Numbers of a column's cells, and what decided how they were read."""

    values: Array  # NaN where a cell is empty or no number
    read: NDArray[np.bool_]  # cells that hold a number, "nan" and the like among them
    proven: Decimal | None  # decimal sign that some cell proves; None where all read alike with either
    doubtful: str = ""  # a cell that is another number with the other decimal sign


def plain(cell: str) -> str:
    """Return a cell with ASCII signs, ordinary blanks, and without a spreadsheet's or Python's function around it."""
    text = cell.strip().translate(_SAME).strip()
    wrapped = _WRAPPED.fullmatch(text)
    return next(part for part in wrapped.groups() if part is not None).strip() if wrapped else text


def is_missing(cell: str) -> bool:
    """Return whether a cell is empty or says that its sample is missing."""
    return plain(cell).lower() in MISSING


def number(text: str, decimal: Decimal) -> float | None:
    """Return the number that a plain text is with a decimal sign; None where it is none."""
    if _NO_NUMBER.fullmatch(text):
        return float("nan")
    if text.lower() in SWITCHES:
        return SWITCHES[text.lower()]
    match = (_POINT if decimal == "." else _COMMA).fullmatch(text)
    if match is None or not any(character.isdigit() for character in text):
        return None
    digits = text.replace(" ", "").replace("'", "")
    digits = digits.replace(",", "") if decimal == "." else digits.replace(".", "").replace(",", ".")
    try:
        return float(digits.replace("d", "e").replace("D", "e"))
    except ValueError:
        return None


def is_number(text: str) -> bool:
    """Return whether a plain text is a number with either decimal sign."""
    return number(text, ".") is not None or number(text, ",") is not None


def read_numbers(cells: Sequence[str], usual: Decimal | None, where: str) -> Reading:
    """Read the numbers of a column.

    Args:
        cells: texts of the column.
        usual: decimal sign of the rest of the file; None where nothing proves one.
        where: file and column, for messages.

    Returns:
        Numbers by the decimal sign that some cell proves ("0,5", "1.234,5"), else by the usual one. Without either a
        sign is taken as decimal, and a cell that depends on it is named.

    Raises:
        InputError: some cells prove a decimal point, others a decimal comma.
    """
    values = np.full((2, len(cells)), np.nan)
    grouped: dict[Decimal, set[str]] = {",": set(), ".": set()}  # cells that may have this sign between thousands
    ok = np.zeros((2, len(cells)), dtype=bool)
    seen: dict[str, tuple[float | None, float | None]] = {}
    proof: dict[Decimal, str] = {}
    doubtful = {",": "", ".": ""}
    for i, cell in enumerate(cells):
        if cell not in seen:
            text = plain(cell)
            both = _PLAIN.fullmatch(text) is not None
            point = number(text, ".")
            comma = point if both else number(text, ",")
            seen[cell] = point, comma
            if (point is None) != (comma is None):
                proof.setdefault("," if point is None else ".", cell)
            elif point is not None and not isnan(point) and point != comma:
                doubtful["," if "," in text else "."] = doubtful["," if "," in text else "."] or cell
                grouped["," if "," in text else "."].add(text)
        for row, value in enumerate(seen[cell]):
            if value is not None:
                values[row, i], ok[row, i] = value, True
    if len(proof) == 2:
        what = f"has a decimal comma in {proof[',']!r} and a decimal point in {proof['.']!r}"
        raise InputError(what, where=where, right="write all its numbers with one decimal sign")
    proven: Decimal | None = next(iter(proof), None) or _decimal_of_groups(grouped, seen)
    sign = proven or usual
    if sign is None:
        sign = "," if doubtful[","] else "."
        return Reading(values[int(sign == ",")], ok[int(sign == ",")], None, doubtful[","] or doubtful["."])
    return Reading(values[int(sign == ",")], ok[int(sign == ",")], proven)


def _decimal_of_groups(grouped: dict[Decimal, set[str]], seen: Iterable[str]) -> Decimal | None:
    """Return the decimal sign of numbers whose other sign stands between thousands; None where it may be decimal.

    Fractions with three digits each would have them in all cells: beside "1.250" they would write "980.000".
    """
    for sign, texts in grouped.items():
        bare = {text for cell in seen if _SMALL.fullmatch(text := plain(cell)) and text.strip("+-0")}
        if min(len(texts), len(bare)) >= LEAST_GROUPS and not any(grouped["," if sign == "." else "."]):
            return "," if sign == "." else "."
    return None
