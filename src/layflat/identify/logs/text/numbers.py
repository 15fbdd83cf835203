"""Numbers in text tables: decimal point or comma, grouped thousands, signs that are not ASCII."""

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

_ASCII_SIGNS = str.maketrans(
    dict.fromkeys("\u2212\u2012\u2013\u2010\u2011\ufe63\uff0d", "-")  # minus signs and dashes
    | dict.fromkeys("\u00a0\u2007\u2009\u202f", " ")  # spaces that do not break
    | dict.fromkeys("\u2019\u02bc\u00b4`", "'")  # apostrophes
)
_EXPONENT = r"(?:[eEdD][-+]?\d+)?"
_POINT_NUMBER = re.compile(rf"[-+]? ?(?:[1-9]\d{{0,2}}(?:([,' ])\d{{3}})(?:\1\d{{3}})*|\d+)?(?:\.\d*)?{_EXPONENT}")
_COMMA_NUMBER = re.compile(rf"[-+]? ?(?:[1-9]\d{{0,2}}(?:([.' ])\d{{3}})(?:\1\d{{3}})*|\d+)?(?:,\d+)?{_EXPONENT}")
_WHOLE_NUMBER = re.compile(rf"[-+]?\d+{_EXPONENT}")
_USUAL_NUMBER = re.compile(rf"[-+]?\d+(?:\.\d*)?{_EXPONENT}")
_NO_NUMBER = re.compile(r"[-+]?nan(?:\(.*\))?|[-+]?1\.#\w+|[-+]?inf(?:inity)?", re.IGNORECASE)
_WRAPPED_CELL = re.compile(
    r'="([^"]*)"|\'([^\']*)\'?|(?:np\.\w+|numpy\.\w+|tensor)\(([^()]*)\)'
)  # by Excel, or by repr() in Python
_THREE_DIGITS = re.compile(r"[-+]?\d{1,3}")
MIN_GROUPED_CELLS = 3  # cells with and without groups that tell thousands from fractions
SWITCH_VALUES = {"true": 1.0, "false": 0.0, "on": 1.0, "off": 0.0}

MISSING_TEXTS = frozenset({"", "-", "--", "---", "na", "n/a", "#n/a", "null", "none", "ol", "missing", "?", "*"})
"""Texts for a missing sample, in small letters."""


@dataclass(frozen=True)
class NumberReading:
    """Numbers of a column's cells, and the decimal sign that they prove."""

    values: Array  # NaN where a cell is empty or no number
    read: NDArray[np.bool_]  # cells that hold a number, with "nan" and the like
    proven: Decimal | None  # decimal sign that a cell proves; None where none does
    doubtful: str = ""  # a cell whose number depends on the decimal sign; "" where all is proven


def normalize_cell(cell: str) -> str:
    """Return a cell with ASCII signs and blanks, without a function of a spreadsheet or of Python around it."""
    text = cell.strip().translate(_ASCII_SIGNS).strip()
    wrapped = _WRAPPED_CELL.fullmatch(text)
    return next(part for part in wrapped.groups() if part is not None).strip() if wrapped else text


def is_missing(cell: str) -> bool:
    """Return whether a cell is empty or one of `MISSING_TEXTS`."""
    return normalize_cell(cell).lower() in MISSING_TEXTS


def parse_number(text: str, decimal: Decimal) -> float | None:
    """Return the number of a normalized cell by a decimal sign: NaN of "nan" and "inf", 1 of "on"; None for others."""
    if _NO_NUMBER.fullmatch(text):
        return float("nan")
    if text.lower() in SWITCH_VALUES:
        return SWITCH_VALUES[text.lower()]
    match = (_POINT_NUMBER if decimal == "." else _COMMA_NUMBER).fullmatch(text)
    if match is None or not any(character.isdigit() for character in text):
        return None
    digits = text.replace(" ", "").replace("'", "")
    digits = digits.replace(",", "") if decimal == "." else digits.replace(".", "").replace(",", ".")
    try:
        return float(digits.replace("d", "e").replace("D", "e"))
    except ValueError:
        return None


def is_number(text: str) -> bool:
    """Return whether a normalized cell is a number with either decimal sign."""
    return is_usual_number(text) or parse_number(text, ".") is not None or parse_number(text, ",") is not None


def is_usual_number(text: str) -> bool:
    """Return whether a text is a number of digits with at most a point and an exponent: a fast test for most cells."""
    return _USUAL_NUMBER.fullmatch(text) is not None


def find_decimal_sign(cells: Iterable[str]) -> Decimal | None:
    """Return the decimal sign that cells prove; None where none or both are proven."""
    signs: set[Decimal] = set()
    for cell in cells:
        # With one point at most and no comma a cell proves a point alone, and likewise the other way round.
        if any(sign in signs and other not in cell and cell.count(sign) < 2 for sign, other in (".,", ",.")):
            continue
        text = normalize_cell(cell)
        point, comma = parse_number(text, "."), parse_number(text, ",")
        if (point is None) != (comma is None):
            signs.add("," if point is None else ".")
            if len(signs) == 2:
                return None
    return next(iter(signs), None)


def read_numbers(cells: Sequence[str], usual: Decimal | None, where: str) -> NumberReading:
    """Read the numbers of a column.

    Args:
        cells: texts of the column.
        usual: decimal sign of the rest of the file; None where none is proven.
        where: file and column, for messages.

    Returns:
        Numbers by the decimal sign that a cell proves ("0,5", "1.234,5"), else by the usual one. Without either, signs
        are read as decimal, and a cell that depends on it is named.

    Raises:
        InputError: some cells prove a decimal point, others a decimal comma.
    """
    values = np.full((2, len(cells)), np.nan)
    grouped: dict[Decimal, set[str]] = {",": set(), ".": set()}  # cells that may have this sign between thousands
    is_read = np.zeros((2, len(cells)), dtype=bool)
    numbers_by_cell: dict[str, tuple[float | None, float | None]] = {}
    proof: dict[Decimal, str] = {}
    doubtful = {",": "", ".": ""}
    for i, cell in enumerate(cells):
        if cell not in numbers_by_cell:
            text = normalize_cell(cell)
            sign_free = _WHOLE_NUMBER.fullmatch(text) is not None
            point = parse_number(text, ".")
            comma = point if sign_free else parse_number(text, ",")
            numbers_by_cell[cell] = point, comma
            if (point is None) != (comma is None):
                proof.setdefault("," if point is None else ".", cell)
            elif point is not None and not isnan(point) and point != comma:
                doubtful["," if "," in text else "."] = doubtful["," if "," in text else "."] or cell
                grouped["," if "," in text else "."].add(text)
        for row, value in enumerate(numbers_by_cell[cell]):
            if value is not None:
                values[row, i], is_read[row, i] = value, True
    if len(proof) == 2:
        problem = f"has a decimal comma in {proof[',']!r} and a decimal point in {proof['.']!r}"
        raise InputError(problem, where=where, right="write all its numbers with one decimal sign")
    proven: Decimal | None = next(iter(proof), None) or _decimal_of_groups(grouped, numbers_by_cell)
    sign = proven or usual
    if sign is None:
        sign = "," if doubtful[","] else "."
        return NumberReading(values[int(sign == ",")], is_read[int(sign == ",")], None, doubtful[","] or doubtful["."])
    return NumberReading(values[int(sign == ",")], is_read[int(sign == ",")], proven)


def _decimal_of_groups(grouped: dict[Decimal, set[str]], cells: Iterable[str]) -> Decimal | None:
    """Return the decimal sign of numbers whose other sign groups thousands; None where that may be decimal.

    Fractions of three digits would have them in all cells: beside "1.250" stands "980.000".
    """
    for sign, texts in grouped.items():
        bare = {text for cell in cells if _THREE_DIGITS.fullmatch(text := normalize_cell(cell)) and text.strip("+-0")}
        if min(len(texts), len(bare)) >= MIN_GROUPED_CELLS and not any(grouped["," if sign == "." else "."]):
            return "," if sign == "." else "."
    return None
