"""Names and units of columns, as the words of their headers state them."""

import re
import unicodedata
from dataclasses import dataclass, replace

from layflat.description.units import PRESSURE
from layflat.identify.logs.units import ALIASES, DATES, GAUGE_WORDS, kind_of_unit, unit_written
from layflat.identify.logs.vocabulary import QUALIFIERS, ROLE_WORDS, meanings

_TOO_SHORT = {"v", "s", "n", "m", "k", "g", "1", "min", "°", "a", "c", "f", "h", "d", "in", "at", "p", "t"}
"""Units that are none behind a name: the k of "torque_k"."""

_LETTERS = {"K": "temperature", "C": "temperature", "F": "temperature", "N": "force"}
"""Units of one letter, and the role beside which a letter is one."""

_BRACKETS = re.compile(
    r"\[(?P<square>(?:[^\[\]]|\[[^\]]*\])*)\]|\{(?P<curly>[^{}]*)\}|\((?P<round>(?:[^()]|\([^)]*\))*)\)"
)
_INDEX = re.compile(r"\d+|[AaBb]|.*[A-Za-z]\w* .*")  # of an array, of a hose, or several words: no unit
_BEHIND = re.compile(
    r"^(?P<stem>.+?)(?:\s*,\s*|\s+/\s*|/| in )(?P<unit>[^,/]+(?:/[^,/]+)?)$"
)  # "p, kPa", "p / kPa", "p in kPa"
_LINKS = {"of", "since", "per", "der", "des", "du", "pro", "seit"}  # words before one that is no unit: "time of day"
_LIMIT = r"[-+]?\d+(?:[.,]\d+)?"
_RANGE = re.compile(rf"{_LIMIT}\s*(?:-|–|\.\.+|…|to|bis|à)\s*{_LIMIT}\s*")  # of a sensor: "0-10 bar"
_ZERO_WORDS = GAUGE_WORDS | dict.fromkeys(("man", "manom", "manométrica", "manométrique"), True)  # behind a unit alone
_NUMBER = r"\d+(?:[.,]\d+)?(?:[eE][-+]?\d+|\^[-+]?\d+)?"
_SCALED = re.compile(
    rf"[x*×·/]?\s*{_NUMBER}\s*[x*×·]?\s*(?P<unit>[^\d\s/.…-].*)|(?P<unit_first>.*\D)\s*[x*×·/]\s*{_NUMBER}"
)  # "0.1 ms", "x 10 bar"; "kPa*10"
_FACTOR = re.compile(rf"[x*×·/]{_NUMBER}|\d+[.,]\d+|{_NUMBER}[x*×·]")  # beside a unit: "p /10 mbar"
_PREFIXED = re.compile(r"[µμumcdhkMG](?:V|W|Pa|bar|deg|rad|Hz|N|Nm)|[µμumk]A")  # a unit, known or not: mA, dV, mdeg
_NUMBERED = re.compile(r" \(column \d+\)$")  # behind names that stand there twice
STAMPED = "datetime"  # in place of a unit: cells are dates or clock times, which are read as seconds
_HOSE_END = re.compile(r"[a-z\d][AB]$")  # of "pressureAKPa"
_SEPARATORS = re.compile(r"[_\s]+")


@dataclass(frozen=True)
class Header:
    """Name and unit of a column, as the file states them."""

    name: str
    unit: str = ""  # as descriptions write it; empty where the file doesn't say, or not so that it is understood
    gauge: bool | None = None  # whether a pressure counts from ambient; None where the file doesn't say
    stem: str = ""  # the name without its unit
    unknown: str = ""  # a unit that is stated and not understood, or two that contradict each other


def header_of(name: str, stated: str = "") -> Header:
    """Return name and unit of a column.

    Args:
        name: header such as "p_A [kPa (g)]", "theta_deg", "time (ms)" or "p / bar".
        stated: unit that stands elsewhere: in a row of units, in metadata, in the cells.
    """
    full, name = name.strip(), unicodedata.normalize("NFKC", _NUMBERED.sub("", name.strip()))
    header = _bracketed(name) or _behind(name) or _suffixed(name) or Header(name, stem=name)
    header = replace(header, name=full)
    if stated == STAMPED:
        return replace(header, unit="s", gauge=None, unknown="")
    stated = stated.strip().strip("[](){}<>").strip()
    if not stated or stated == "-" or stated.lower() in DATES:
        return header
    found = unit_written(stated)
    if found is None:
        return replace(header, unit="", gauge=None, unknown=stated)
    unit, gauge = found
    if header.unit and header.unit != unit:
        return replace(header, unit="", gauge=None, unknown=f"{header.unit} in its name, {unit} beside it")
    return _with_zero(replace(header, unit=unit, gauge=header.gauge if gauge is None else gauge, unknown=""))


def _bracketed(name: str) -> Header | None:
    """Return a header whose unit stands in brackets; None without brackets, or where these hold no unit."""
    unknown = ""
    for match in reversed(list(_BRACKETS.finditer(name))):
        text = next(part for part in match.groups() if part is not None).strip()
        stem = f"{name[: match.start()].rstrip()} {name[match.end() :].lstrip()}".strip()
        gauge = GAUGE_WORDS.get(text.lower().rstrip("."))
        if gauge is not None and len(text) == 1 and "pressure" in meanings(words_of(stem)):
            found = None
        else:
            found = unit_written(text) or _unit_among_words(text)
        if found is not None:
            behind = _suffixed(stem)
            if behind is not None and behind.unit != found[0] and match["square"] is None:
                continue
            return _with_zero(Header(name, *found, stem or name))
        if gauge is not None and stem:  # "p_bar (g)", "Pressure A (g)"
            before = _bracketed(stem) or _behind(stem) or _suffixed(stem)
            if before is not None and before.unit:
                return replace(before, name=name, gauge=gauge)
            if text in "gG" or len(text) > 1:
                return Header(name, "", gauge, stem)
        known = not _is_other_unit(text) and (
            _INDEX.fullmatch(text)
            or meanings(words_of(text))
            or (text.lower() in QUALIFIERS and match["square"] is None)
        )
        if text and not known and text.lower() not in DATES and not unknown:
            unknown, rest = text, stem
    return Header(name, stem=rest, unknown=unknown) if unknown else None


def _unit_among_words(text: str) -> tuple[str, bool | None] | None:
    """Return the unit among words in brackets, as in "kPa man.", or behind a range, as in "0-10 bar"."""
    words = _RANGE.sub("", text).split()
    bare = [word.strip(".,;:") for word in words]
    units = [found for word in bare if (found := unit_written(word, listed=True)) is not None]
    if len(units) != 1 or any(character.isdigit() for word in bare for character in word if word not in ALIASES):
        return None
    told = {_ZERO_WORDS[word.lower()] for word in bare if len(word) > 1 and word.lower() in _ZERO_WORDS}
    others = [word for word in bare if unit_written(word, listed=True) is None and word.lower() not in _ZERO_WORDS]
    if kind_of_unit(units[0][0]) == PRESSURE and {"difference", "asked"} & meanings([word.lower() for word in others]):
        return None
    return units[0][0], told.pop() if len(told) == 1 else units[0][1]


def _is_other_unit(text: str) -> bool:
    """Return whether a text is a unit that is none of a log's, or one with a number: "mA", "x 10 bar", "kPa*10"."""
    match = _SCALED.fullmatch(text)
    if match is None:
        return _PREFIXED.fullmatch(text) is not None
    return unit_written((match["unit"] or match["unit_first"]).strip()) is not None


def _behind(name: str) -> Header | None:
    """Return a header whose unit stands behind a comma, a slash or "in"; None without."""
    match = _BEHIND.match(name)
    slashed = match is not None and name[match.end("stem") :].startswith("/")  # "p/kPa", or a topic such as "/rig/v"
    found = unit_written(match["unit"], listed=slashed) if match else None
    if match is None or found is None or (slashed and "/" in match["stem"]):
        return None
    return _with_zero(Header(name, *found, match["stem"].strip()))


def _with_zero(header: Header) -> Header:
    """Return a header with what the words of its name say of a pressure's zero."""
    if header.gauge is not None or kind_of_unit(header.unit) != PRESSURE:
        return header
    gauge, rest = _zero_of(_SEPARATORS.split(header.stem), -1)
    return replace(header, gauge=gauge, stem=" ".join(rest)) if gauge is not None else header


def _suffixed(name: str) -> Header | None:
    """Return a header with a unit among its words, as in "pressure_b_kPa_raw", or in its last letters."""
    parts = [part for part in _SEPARATORS.split(name) if part]
    if len(parts) > 1 and _PREFIXED.fullmatch(parts[-1]) and unit_written(parts[-1], listed=True) is None:
        found = unit_written(parts[-1])
        stem = " ".join(parts[:-1])
        return Header(name, *found, stem) if found else Header(name, stem=stem, unknown=parts[-1])
    return _among(name, parts) or _in_last_letters(name)


def _among(name: str, parts: list[str]) -> Header | None:
    """Return a header with a unit among its words."""
    for end in range(len(parts), 0, -1):
        for first in range(max(end - 2, 0), end):
            tail, rest = parts[first:end], parts[:first] + parts[end:]
            found = unit_written(" ".join(tail), listed=True)
            if len(tail) > 1 and tail[-1].lower() in GAUGE_WORDS:
                continue  # read with the unit before it
            if found == ("Pa", None) and first == 0:
                continue  # the pressure of hose A
            if found is None or not rest or not _is_unit_word(tail, parts, end):
                continue
            if first and parts[first - 1].lower() in _LINKS:
                continue
            if first and _FACTOR.fullmatch(parts[first - 1]):
                return Header(name, stem=" ".join(rest), unknown=f"{parts[first - 1]} {tail[0]}")
            unit, gauge = found
            if gauge is None and kind_of_unit(unit) == PRESSURE:
                gauge, rest = _zero_of(rest, first)
            return Header(name, unit, gauge, " ".join(rest))
    return None


def _in_last_letters(name: str) -> Header | None:
    """Return a header with a unit in the last letters of its name, as in "timeMs"."""
    for size in (4, 3, 2):
        stem, end_word = name[:-size], name[-size:]
        if not stem:
            continue
        found = unit_written(end_word, listed=True) if end_word.isalpha() else None
        border = end_word[0].isupper() if stem[-1:].islower() else end_word[0].islower()
        border = border or (end_word[0].isupper() and _HOSE_END.search(stem) is not None)
        if found is not None and border and stem[-1:].isalnum() and end_word.lower() not in _TOO_SHORT:
            return Header(name, *found, stem) if words_of(stem)[-1:] != ["of"] else None
    return None


def _is_unit_word(tail: list[str], parts: list[str], end: int) -> bool:
    """Tell whether words that may be a unit are one: long enough, or the last one behind a clock or a voltage."""
    word = tail[0].lower()
    if len(tail) > 1 or (word not in _TOO_SHORT and not (end < len(parts) and word in ROLE_WORDS)):
        return len(tail) == 1 or tail[0].lower() not in GAUGE_WORDS
    clock = parts[0].lower() in {"t", "time", "zeit", "temps", "elapsed"} and word in {"s", "h", "min", "d"}
    meant = meanings(words_of(" ".join(parts[:-1])))
    letter = tail[0] == "V" or _LETTERS.get(tail[0]) in meant
    return end == len(parts) > 1 and (clock or letter)


def _zero_of(rest: list[str], first: int) -> tuple[bool | None, list[str]]:
    """Return what a word beside a unit says of a pressure's zero, and the other words; "a" may be a hose's."""
    hosed = any({"a", "b"} & meanings(words_of(part)) for i, part in enumerate(rest) if i != first)
    for i, word in enumerate(rest):
        if word.lower() in GAUGE_WORDS and (len(word) > 1 or (i == first and (hosed or word.lower() != "a"))):
            return GAUGE_WORDS[word.lower()], rest[:i] + rest[i + 1 :]
    return None, rest


def words_of(name: str) -> list[str]:
    """Return the words of a name in small letters: "/rig.pA_2" has rig, p, a, 2; digits stand alone, units go."""
    words = []
    for token in re.split(r"[^\w]|_", name):
        found = unit_written(token, listed=True)
        if found is None or token.lower() in _TOO_SHORT or token.lower() in ROLE_WORDS or token == name:
            words += re.findall(r"[^\W\d_A-Z]+|[A-Z][^\W\d_A-Z]+|[A-Z]+(?![a-z])|\d+", token)
    return [word.lower() for word in words]
