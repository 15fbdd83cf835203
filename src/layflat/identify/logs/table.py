"""Log as its file has it: columns of raw numbers with names, units and stamps; and the parser of headers."""

import re
import unicodedata
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from layflat.arrays import Array
from layflat.description.units import PRESSURE
from layflat.identify.logs.vocabulary import (
    DATE_WORDS,
    GAUGE_WORDS,
    QUALIFIER_WORDS,
    ROLE_WORDS,
    UNIT_BY_SPELLING,
    kind_of_unit,
    parse_unit,
    word_roles,
)

_TOO_SHORT = {"v", "s", "n", "m", "k", "g", "1", "min", "°", "a", "c", "f", "h", "d", "in", "at", "p", "t"}
"""Units that are too short to be recognised at the end of a name, such as the k of "torque_k"."""

_ONE_LETTER_UNITS = {"K": "temperature", "C": "temperature", "F": "temperature", "N": "force"}
"""Role of a name beside which a single letter is a unit, by letter."""

_BRACKETS = re.compile(
    r"\[(?P<square>(?:[^\[\]]|\[[^\]]*\])*)\]|\{(?P<curly>[^{}]*)\}|\((?P<round>(?:[^()]|\([^)]*\))*)\)"
)
_NO_UNIT = re.compile(r"\d+|[AaBb]|.*[A-Za-z]\w* .*")  # index of an array, letter of a hose, or several words
_TRAILING_UNIT = re.compile(
    r"^(?P<stem>.+?)(?:\s*,\s*|\s+/\s*|/| in )(?P<unit>[^,/]+(?:/[^,/]+)?)$"
)  # "p, kPa", "p / kPa", "p in kPa"
_LINKING_WORDS = {"of", "since", "per", "der", "des", "du", "pro", "seit"}
"""Words before one that is no unit: "time of day"."""
_RANGE_LIMIT = r"[-+]?\d+(?:[.,]\d+)?"
_SENSOR_RANGE = re.compile(rf"{_RANGE_LIMIT}\s*(?:-|–|\.\.+|…|to|bis|à)\s*{_RANGE_LIMIT}\s*")  # "0-10 bar"
_ZERO_WORDS = GAUGE_WORDS | dict.fromkeys(("man", "manom", "manométrica", "manométrique"), True)  # only behind a unit
_NUMBER_PATTERN = r"\d+(?:[.,]\d+)?(?:[eE][-+]?\d+|\^[-+]?\d+)?"
_SCALED_UNIT = re.compile(
    rf"[x*×·/]?\s*{_NUMBER_PATTERN}\s*[x*×·]?\s*(?P<unit>[^\d\s/.…-].*)|(?P<unit_first>.*\D)\s*[x*×·/]\s*{_NUMBER_PATTERN}"
)  # "0.1 ms", "x 10 bar"; "kPa*10"
_UNIT_FACTOR = re.compile(rf"[x*×·/]{_NUMBER_PATTERN}|\d+[.,]\d+|{_NUMBER_PATTERN}[x*×·]")
"""Factor before a unit: "p /10 mbar"."""
_PREFIXED_UNIT = re.compile(r"[µμumcdhkMG](?:V|W|Pa|bar|deg|rad|Hz|N|Nm)|[µμumk]A")
"""Units with a prefix, known or not: mA, dV, mdeg."""
_COLUMN_NUMBER = re.compile(r" \(column \d+\)$")  # suffix of names that occur twice
STAMP_UNIT = "datetime"  # in place of a unit: the cells are dates or clock times, which are read as seconds
_HOSE_END = re.compile(r"[a-z\d][AB]$")  # of "pressureAKPa"
_SEPARATORS = re.compile(r"[_\s]+")


@dataclass(frozen=True)
class Header:
    """Name and unit of a column, as the file states them."""

    name: str
    unit: str = ""  # as in descriptions; "" where the file states none, or none that is known
    gauge: bool | None = None  # True: relative to ambient pressure; None where the file doesn't say
    stem: str = ""  # the name without its unit
    unknown: str = ""  # a stated unit that is not known, or two that contradict each other


def parse_header(name: str, stated: str = "") -> Header:
    """Return name, unit and zero of a column from its header.

    Args:
        name: header such as "p_A [kPa (g)]", "theta_deg", "time (ms)" or "p / bar".
        stated: unit elsewhere in the file: in a row of units, in metadata, in the cells.
    """
    full_name, name = name.strip(), unicodedata.normalize("NFKC", _COLUMN_NUMBER.sub("", name.strip()))
    header = _parse_bracketed(name) or _parse_trailing(name) or _parse_suffix(name) or Header(name, stem=name)
    header = replace(header, name=full_name)
    if stated == STAMP_UNIT:
        return replace(header, unit="s", gauge=None, unknown="")
    stated = stated.strip().strip("[](){}<>").strip()
    if not stated or stated == "-" or stated.lower() in DATE_WORDS:
        return header
    parsed = parse_unit(stated)
    if parsed is None:
        return replace(header, unit="", gauge=None, unknown=stated)
    unit, gauge = parsed
    if header.unit and header.unit != unit:
        return replace(header, unit="", gauge=None, unknown=f"{header.unit} in its name, {unit} beside it")
    return _with_pressure_zero(replace(header, unit=unit, gauge=header.gauge if gauge is None else gauge, unknown=""))


def _parse_bracketed(name: str) -> Header | None:
    """Return a header with a unit in brackets; None without brackets, or where these hold no unit."""
    unknown = ""
    for match in reversed(list(_BRACKETS.finditer(name))):
        text = next(part for part in match.groups() if part is not None).strip()
        stem = f"{name[: match.start()].rstrip()} {name[match.end() :].lstrip()}".strip()
        gauge = GAUGE_WORDS.get(text.lower().rstrip("."))
        if gauge is not None and len(text) == 1 and "pressure" in word_roles(split_words(stem)):
            parsed = None
        else:
            parsed = parse_unit(text) or _unit_among_words(text)
        if parsed is not None:
            suffixed = _parse_suffix(stem)
            if suffixed is not None and suffixed.unit != parsed[0] and match["square"] is None:
                continue
            return _with_pressure_zero(Header(name, *parsed, stem or name))
        if gauge is not None and stem:  # "p_bar (g)", "Pressure A (g)"
            inner = _parse_bracketed(stem) or _parse_trailing(stem) or _parse_suffix(stem)
            if inner is not None and inner.unit:
                return replace(inner, name=name, gauge=gauge)
            if text in "gG" or len(text) > 1:
                return Header(name, "", gauge, stem)
        not_a_unit = not _is_other_unit(text) and (
            _NO_UNIT.fullmatch(text)
            or word_roles(split_words(text))
            or (text.lower() in QUALIFIER_WORDS and match["square"] is None)
        )
        if text and not not_a_unit and text.lower() not in DATE_WORDS and not unknown:
            unknown, rest = text, stem
    return Header(name, stem=rest, unknown=unknown) if unknown else None


def _unit_among_words(text: str) -> tuple[str, bool | None] | None:
    """Return unit and zero among words in brackets, as in "kPa man.", or behind a range, as in "0-10 bar".

    None unless there is exactly one unit, and no number beside it.
    """
    words = _SENSOR_RANGE.sub("", text).split()
    stripped = [word.strip(".,;:") for word in words]
    units = [parsed for word in stripped if (parsed := parse_unit(word, listed=True)) is not None]
    if len(units) != 1 or any(
        character.isdigit() for word in stripped for character in word if word not in UNIT_BY_SPELLING
    ):
        return None
    zeros = {_ZERO_WORDS[word.lower()] for word in stripped if len(word) > 1 and word.lower() in _ZERO_WORDS}
    others = [word for word in stripped if parse_unit(word, listed=True) is None and word.lower() not in _ZERO_WORDS]
    if kind_of_unit(units[0][0]) == PRESSURE and {"difference", "asked"} & word_roles(
        [word.lower() for word in others]
    ):
        return None
    return units[0][0], zeros.pop() if len(zeros) == 1 else units[0][1]


def _is_other_unit(text: str) -> bool:
    """Return whether a text is a unit that no signal has, or one with a number: "mA", "x 10 bar", "kPa*10"."""
    match = _SCALED_UNIT.fullmatch(text)
    if match is None:
        return _PREFIXED_UNIT.fullmatch(text) is not None
    return parse_unit((match["unit"] or match["unit_first"]).strip()) is not None


def _parse_trailing(name: str) -> Header | None:
    """Return a header with its unit behind a comma, a slash or "in"; None for others."""
    match = _TRAILING_UNIT.match(name)
    slashed = match is not None and name[match.end("stem") :].startswith("/")  # "p/kPa", or a topic such as "/rig/v"
    parsed = parse_unit(match["unit"], listed=slashed) if match else None
    if match is None or parsed is None or (slashed and "/" in match["stem"]):
        return None
    return _with_pressure_zero(Header(name, *parsed, match["stem"].strip()))


def _with_pressure_zero(header: Header) -> Header:
    """Return the header with the zero of a pressure, gauge or absolute, from the words of its name."""
    if header.gauge is not None or kind_of_unit(header.unit) != PRESSURE:
        return header
    gauge, rest = _find_pressure_zero(_SEPARATORS.split(header.stem), -1)
    return replace(header, gauge=gauge, stem=" ".join(rest)) if gauge is not None else header


def _parse_suffix(name: str) -> Header | None:
    """Return a header with a unit among its words, as in "pressure_b_kPa_raw", or in its last letters; else None."""
    parts = [part for part in _SEPARATORS.split(name) if part]
    if len(parts) > 1 and _PREFIXED_UNIT.fullmatch(parts[-1]) and parse_unit(parts[-1], listed=True) is None:
        parsed = parse_unit(parts[-1])
        stem = " ".join(parts[:-1])
        return Header(name, *parsed, stem) if parsed else Header(name, stem=stem, unknown=parts[-1])
    return _parse_unit_word(name, parts) or _parse_last_letters(name)


def _parse_unit_word(name: str, parts: list[str]) -> Header | None:
    """Return a header with a unit among its words; None for others."""
    for end in range(len(parts), 0, -1):
        for first in range(max(end - 2, 0), end):
            tail, rest = parts[first:end], parts[:first] + parts[end:]
            parsed = parse_unit(" ".join(tail), listed=True)
            if len(tail) > 1 and tail[-1].lower() in GAUGE_WORDS:
                continue  # read with the unit before it
            if parsed == ("Pa", None) and first == 0:
                continue  # the pressure of hose A
            if parsed is None or not rest or not _is_unit_word(tail, parts, end):
                continue
            if first and parts[first - 1].lower() in _LINKING_WORDS:
                continue
            if first and _UNIT_FACTOR.fullmatch(parts[first - 1]):
                return Header(name, stem=" ".join(rest), unknown=f"{parts[first - 1]} {tail[0]}")
            unit, gauge = parsed
            if gauge is None and kind_of_unit(unit) == PRESSURE:
                gauge, rest = _find_pressure_zero(rest, first)
            return Header(name, unit, gauge, " ".join(rest))
    return None


def _parse_last_letters(name: str) -> Header | None:
    """Return a header with a unit in the last letters of its name, as in "timeMs"; None for others."""
    for size in (4, 3, 2):
        stem, end_word = name[:-size], name[-size:]
        if not stem:
            continue
        parsed = parse_unit(end_word, listed=True) if end_word.isalpha() else None
        at_border = end_word[0].isupper() if stem[-1:].islower() else end_word[0].islower()
        at_border = at_border or (end_word[0].isupper() and _HOSE_END.search(stem) is not None)
        if parsed is not None and at_border and stem[-1:].isalnum() and end_word.lower() not in _TOO_SHORT:
            return Header(name, *parsed, stem) if split_words(stem)[-1:] != ["of"] else None
    return None


def _is_unit_word(tail: list[str], parts: list[str], end: int) -> bool:
    """Return whether words that may be a unit are one: long enough, or the last one behind a clock or a voltage."""
    word = tail[0].lower()
    if len(tail) > 1 or (word not in _TOO_SHORT and not (end < len(parts) and word in ROLE_WORDS)):
        return len(tail) == 1 or tail[0].lower() not in GAUGE_WORDS
    clock = parts[0].lower() in {"t", "time", "zeit", "temps", "elapsed"} and word in {"s", "h", "min", "d"}
    roles = word_roles(split_words(" ".join(parts[:-1])))
    single_letter = tail[0] == "V" or _ONE_LETTER_UNITS.get(tail[0]) in roles
    return end == len(parts) > 1 and (clock or single_letter)


def _find_pressure_zero(rest: list[str], first: int) -> tuple[bool | None, list[str]]:
    """Return the zero that a word of `rest` states, True for gauge, None for no such word, and the other words.

    A single letter counts only at index `first`, next to the unit; "a" there only beside a hose's letter.
    """
    has_hose = any({"a", "b"} & word_roles(split_words(part)) for i, part in enumerate(rest) if i != first)
    for i, word in enumerate(rest):
        if word.lower() in GAUGE_WORDS and (len(word) > 1 or (i == first and (has_hose or word.lower() != "a"))):
            return GAUGE_WORDS[word.lower()], rest[:i] + rest[i + 1 :]
    return None, rest


def split_words(name: str) -> list[str]:
    """Return the words of a name in small letters without units: "/rig.pA_2" has rig, p, a, 2."""
    words = []
    for token in re.split(r"[^\w]|_", name):
        parsed = parse_unit(token, listed=True)
        if parsed is None or token.lower() in _TOO_SHORT or token.lower() in ROLE_WORDS or token == name:
            words += re.findall(r"[^\W\d_A-Z]+|[A-Z][^\W\d_A-Z]+|[A-Z]+(?![a-z])|\d+", token)
    return [word.lower() for word in words]


Cells = Array | list[str]  # of a column: numbers, or words


@dataclass(frozen=True)
class LogColumn:
    """Column of raw numbers, (samples,), NaN where there is none, with its header."""

    values: Array
    header: Header
    stamps: Array | None = None  # its own stamps, (samples,); None where a column of the table is the clock
    notes: tuple[str, ...] = ()  # on decisions in reading it, and on cells without number
    topic: str = ""  # of the messages; "" for other files
    messages: NDArray[np.intp] | None = None  # number of each sample's message among those of its topic


class FileContent(NamedTuple):
    """Content of a file from its reader."""

    columns: dict[str, LogColumn]
    clock: Header | None = None  # of the stamps where columns have their own; None where a column is the clock
    words: Mapping[str, str] = {}  # reasons, by name, for content that makes no column
    notes: tuple[str, ...] = ()  # on the file


@dataclass(frozen=True)
class LogTable:
    """Log of a file: columns by name."""

    path: Path
    sha256: str
    columns: dict[str, LogColumn]
    clock: Header | None = None  # of the stamps where columns have their own; None where a column is the clock
    notes: tuple[str, ...] = ()  # on the file
    words: dict[str, str] = field(default_factory=dict)  # reasons, by name, for content that makes no column

    def stamps_of(self, column: LogColumn, clock: str) -> Array | None:
        """Return the stamps of a column from a clock in its messages, such as "header.stamp"; None without one.

        Args:
            column: column of recorded messages.
            clock: field of its messages, or of those of one topic, with the topic's name before it.
        """
        name = clock if clock.startswith(f"{column.topic}.") else f"{column.topic}.{clock}"
        clock_column = self.columns.get(name)
        if clock_column is None or clock_column.messages is None or column.messages is None:
            return None
        by_message = np.full(max(clock_column.messages.max(), column.messages.max()) + 1, np.nan)
        by_message[clock_column.messages] = clock_column.values
        return by_message[column.messages]
