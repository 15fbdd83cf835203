"""Layout of a text table: its delimiter, and which lines are titles, names, units and samples."""

import csv
import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

from layflat.identify.logs.headers import header_of, words_of
from layflat.identify.logs.text.cells import Kind, kind_of
from layflat.identify.logs.text.labels import read_block, read_stated_units
from layflat.identify.logs.text.numbers import is_number, plain
from layflat.identify.logs.text.stamps import is_stamp
from layflat.identify.logs.units import unit_written
from layflat.identify.logs.vocabulary import meanings

BLANKS = " "  # one blank or more
WIDE_BLANKS = "  "  # two blanks or more
DELIMITERS = ("\t", ";", ",", "|", WIDE_BLANKS, BLANKS)
COMMENTS = ("#", "%", "//")
HEADING_ROWS = 5  # rows above the samples among which names and units are sought
TYPES = frozenset(
    [
        "string",
        "datetime",
        "bool",
        "double",
        "single",
        "float",
        "float32",
        "float64",
        "real",
        "lreal",
        "int",
        "dint",
        "int16",
        "int32",
        "int64",
    ]
)
"""Words of a row that says how numbers are kept."""
MAX_JOINED = 2000  # characters of a header
MAJORITY = 0.6  # fraction of a column's cells that makes it one of numbers
SPARSE = 0.1  # fraction of filled cells below which a column tells nothing of the layout
_RULE = re.compile(r"[-=_+*\s|]*")
_ARRIVAL = re.compile(r"\[?\d{1,2}:\d{2}:\d{2}[.,]\d+\]? ?-> ?")
_BRACKETED = re.compile(r"\s*(?:\[([^\[\]]*)\]|\(([^()]*)\)|\{([^{}]*)\})[,;]?\s*")  # a row that Python printed
BRACKETS = frozenset("[({")
_STAMPED = re.compile(r"\s*[\[(](?P<time>[^\[\]()]*\d[^\[\]()]*)[\])]\s*[,;:|]?\s*(?P<rest>\S.*)", re.DOTALL)
_COLOURS = re.compile(r"\x1b\[[0-9;]*[A-Za-z]")  # of a terminal
_NEXT_LABEL = re.compile(r"\s+(?=[^\W\d][\w.]*\s?[:=]\s*[-+.\d])")  # before "angle: 12.3" in a row of such
_ABOUT = re.compile(r"(?P<about>units?|einheit|type|interp|format) ?[:=] ?", re.IGNORECASE)  # before each cell of a row


@dataclass(frozen=True)
class Layout:
    """Delimiter of a table, names and units of its columns, and the number of lines above the samples."""

    delimiter: str
    width: int  # fields of a row
    names: list[str] = field(default_factory=list)  # empty where the table has no header
    units: list[str] = field(default_factory=list)  # empty where the table has no row of units
    start: int = 0  # lines above the first sample
    arrivals: bool = False  # lines begin with the time of their arrival and "->", as in a serial monitor
    inner: frozenset[int] = frozenset()  # numbers of the lines below `start` that are headings, from 1
    heads: frozenset[str] = frozenset()  # lines above the samples, which may stand among them again
    step: float = 0.0  # s between samples, where the heading says it and no column is the clock


def split_row(line: str, delimiter: str) -> list[str]:
    """Return the fields of a line, without the blanks around them."""
    if delimiter == BLANKS:
        line, delimiter = " ".join(line.split()), " "
    elif delimiter == WIDE_BLANKS:
        line = re.sub(r"[ \t]{2,}", "\t", line.strip())
        line, delimiter = _NEXT_LABEL.sub("\t", line) if len(_NEXT_LABEL.findall(line)) > 1 else line, "\t"
    try:
        return [cell.strip() for cell in next(csv.reader([line], delimiter=delimiter, skipinitialspace=True), [])]
    except csv.Error:
        return [cell.strip() for cell in line.split(delimiter)]


def joined_lines(lines: Sequence[str]) -> list[str]:
    """Return lines with names that are broken inside quotes in one, and empty lines for their first parts."""
    result, held = list[str](), ""
    for i, line in enumerate(lines):
        text = f"{held} {line}" if held else line
        open_quote = text.count('"') % 2 == 1 and len(text) < MAX_JOINED and i + 1 < len(lines)
        held = text if open_quote else ""
        result.append("" if open_quote else text)
    return result if not held else list(lines)


def is_rule(line: str) -> bool:
    """Return whether a line is empty or drawn: dashes, equals signs."""
    return _RULE.fullmatch(line) is not None


def find_layout(lines: Sequence[str], delimiter: str = "") -> Layout:
    """Find the layout of a table from its first lines.

    Args:
        lines: of the file, without line ends.
        delimiter: where the file says it; else the one that leaves the most numbers and the fewest words.
    """
    arrivals = sum(_ARRIVAL.match(line) is not None for line in lines) > MAJORITY * len(lines)
    candidates = []
    for order, sign in enumerate((delimiter,) if delimiter else DELIMITERS):
        rows = [
            [] if is_rule(line) or is_comment(line) else split_row(parted(line, sign, arrivals), sign) for line in lines
        ]
        kinds = [[kind_of(cell) for cell in row] for row in rows]
        width, score = _width(kinds)
        layout = _heading(lines, rows, kinds, Layout(sign, width, arrivals=arrivals))
        fits = not layout.names or len(layout.names) == width
        words = [line.strip() for line, row in zip(lines[: layout.start], kinds, strict=False) if _is_wordy(row)]
        candidates.append((score, fits, width, -order, replace(layout, heads=frozenset(words))))
    return max(candidates, key=lambda candidate: candidate[:4])[4]


def parted(line: str, delimiter: str, arrivals: bool) -> str:
    """Return a line without colours and brackets around it, whose time of arrival is a field of its own."""
    if "\x1b" in line:
        line = _COLOURS.sub("", line)
    if line.lstrip()[:1] in BRACKETS:
        line = _without_brackets(line, delimiter)
    return line.replace("->", delimiter.strip(" ") or " ", 1) if arrivals else line


def _without_brackets(line: str, delimiter: str) -> str:
    """Return a line without brackets around all of it, or around the time at its start."""
    bracketed = _BRACKETED.fullmatch(line)
    if bracketed:
        return next(part for part in bracketed.groups() if part is not None)
    stamped = _STAMPED.match(line)
    if stamped and (is_number(stamped["time"].strip()) or is_stamp(stamped["time"].strip())):
        return f"{stamped['time'].strip()}{delimiter}{stamped['rest']}"
    return line


def is_comment(line: str) -> bool:
    """Return whether a line is a comment."""
    return line.lstrip().startswith(COMMENTS)


def _is_wordy(row: Sequence[Kind]) -> bool:
    return 2 * row.count("text") > len(row)


def _width(kinds: Sequence[list[Kind]]) -> tuple[int, float]:
    """Return the usual number of fields of rows of samples, and a score of how well the lines are parted."""
    counts: Counter[int] = Counter()
    scores: Counter[int] = Counter()
    for row in kinds:
        if _holds_numbers(row):
            counts[len(row)] += 1
            scores[len(row)] += len(row) - row.count("missing") - 3 * row.count("text")
    if not counts:
        widths = Counter(len(row) for row in kinds if row)
        return max(widths, key=lambda width: (widths[width], width), default=1), -1e9
    width = max(counts, key=lambda width: (counts[width], width))
    return width, scores[width]


def _holds_numbers(row: Sequence[Kind]) -> bool:
    """Return whether at least half of a row's filled cells are numbers or stamps."""
    return len(row) - row.count("missing") >= max(2 * row.count("text"), 1)


def _heading(lines: Sequence[str], rows: Sequence[list[str]], kinds: Sequence[list[Kind]], layout: Layout) -> Layout:
    """Add names, units and the first line of samples to a layout."""
    width = layout.width
    samples = [row for row in kinds if len(row) == width and _holds_numbers(row)]
    filled = [not samples or any(row[i] != "missing" for row in samples) for i in range(width)]  # columns
    used = sum(filled)
    numeric = [_is_numeric([row[i] for row in samples]) for i in range(width)]  # columns

    def is_sample(row: Sequence[Kind]) -> bool:
        mine = [kind for kind, number in zip(row, numeric, strict=False) if number]
        if row[:1] == ["text"] and not filled[0]:  # a label
            return False
        return len(row) == width and "text" not in mine and any(kind != "missing" for kind in mine)

    def is_head(i: int) -> bool:
        """Tell whether a row has as many words as names would be, and no number where samples have theirs."""
        row = kinds[i][1:] if layout.arrivals else kinds[i]
        if not 1 <= len(row) <= width + 1 or abs(len(row) - width) > 1 + layout.arrivals + row.count("missing"):
            return False
        filled = [kind for kind in row if kind != "missing"]
        words = [kind for kind in filled if kind == "text"]
        kinds_of_numbers = sum(cell.lower() in TYPES or _about(cell) != "" for cell in rows[i])
        return 2 * len(filled) > used and len(words) == len(filled) > 2 * kinds_of_numbers

    first = next((i for i, row in enumerate(kinds) if is_sample(row)), None)
    if first is None:  # words alone
        first = 1 if rows and rows[0] else 0
    block = read_block(rows[:first], filled)
    if block is not None:
        return replace(layout, names=block.names, units=block.units, start=first, step=block.step)
    above = [i for i in range(first) if rows[i]][-HEADING_ROWS:]
    heads = [i for i in above if is_head(i) or (is_units(rows[i]) and len(rows[i]) == width)]
    unit_row = next((i for i in reversed(heads) if i != above[0] and is_units(rows[i])), None)
    named = [i for i in heads if unit_row is None or i < unit_row]
    odd = [i for i in above if i != unit_row and kinds[i][0] == "text" and _may_name(kinds[i], width)]
    odd = [i for i in odd if 2 * sum(cell.lower() in TYPES or _about(cell) != "" for cell in rows[i]) < len(rows[i])]
    if not named and odd and odd[-1] == (above[-1] if unit_row is None else unit_row - 1):
        named = odd[-1:]  # names of which some are numbers, or more or fewer than there are columns
    if named:
        head, last = named[-1], unit_row if unit_row is not None else named[-1]
        start = next((i for i in range(last + 1, first) if _has_number(kinds[i], numeric)), first)
        units = [_ABOUT.sub("", plain(cell)) for cell in rows[unit_row]] if unit_row is not None else (
            read_stated_units(rows[:head], width)
        )  # fmt: skip
        names = _padded(rows[head], layout.arrivals)
        if len(named) > 1 and named[-2] == head - 1 and len(rows[head - 1]) == len(names):
            names = [_with_upper(name, upper) for name, upper in zip(names, rows[head - 1], strict=True)]
        if len(names) == width - 1 and samples and all(row[-1] == "missing" for row in samples):
            names.append("")  # rows end with a delimiter, and the header does not
        elif len(names) == width - 1 and _are_counted([row[0] for row in rows[start:] if len(row) == width]):
            names.insert(0, "")  # names of rows, as R writes them
        return replace(layout, names=names, units=units, start=start)
    start = next((i for i in range(first) if len(rows[i]) == width and _has_number(kinds[i], numeric)), first)
    for i in reversed(range(start)):
        text = lines[i].lstrip()
        sign = next((sign for sign in COMMENTS if text.startswith(sign)), "")
        names = split_row(parted(text.removeprefix(sign), layout.delimiter, layout.arrivals), layout.delimiter)
        if sign and len(names) == width > 1 and all(kind_of(name) in {"text", "missing"} for name in names):
            return replace(layout, names=names, start=start)
    return replace(layout, start=start)


def _with_upper(name: str, upper: str) -> str:
    """Return a name, with the one above it where it says nothing by itself: "Angle CH1 [deg]"."""
    said, above = (meanings(words_of(header_of(cell).stem)) for cell in (name, upper))
    return f"{upper} {name}" if above and not said else name


def _are_counted(cells: Sequence[str]) -> bool:
    """Return whether cells are the numbers of their rows."""
    numbers = [int(cell) for cell in cells if cell.isdecimal()]
    return len(cells) == len(numbers) > 1 and numbers == list(range(numbers[0], numbers[0] + len(numbers)))


def _about(cell: str) -> str:
    """Return what a cell such as "Units: kPa" or "Type: double" is about; empty for all others."""
    match = _ABOUT.match(cell)
    return match["about"].lower() if match else ""


def _may_name(row: Sequence[Kind], width: int) -> bool:
    return len(row) == width or (len(row) > 1 and all(kind == "text" for kind in row))


def _padded(names: list[str], arrivals: bool) -> list[str]:
    first = "arrival" if arrivals else names[0].lstrip("#").strip()
    return [first, *names[1:]]


def _has_number(row: Sequence[Kind], numeric: Sequence[bool]) -> bool:
    mine = [kind for kind, number in zip(row, numeric, strict=False) if number and kind != "missing"]
    return len(row) == len(numeric) and len(mine) > 2 * mine.count("text")


def _is_numeric(kinds: Sequence[Kind]) -> bool:
    filled = [kind for kind in kinds if kind != "missing"]
    return len(filled) > SPARSE * len(kinds) and sum(kind != "text" for kind in filled) >= MAJORITY * len(filled)


def is_units(row: Sequence[str]) -> bool:
    """Return whether most cells of a row are units and none is a number."""
    cells = [_ABOUT.sub("", plain(cell)).strip("[](){}<> ") for cell in row]
    filled = [cell for cell in cells if cell and cell not in {"-", "1"}]
    units = sum(unit_written(cell) is not None for cell in filled)
    return (
        bool(filled) and 2 * units >= len(filled) and not any(kind_of(cell) in {"number", "stamp"} for cell in filled)
    )
