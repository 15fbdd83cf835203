"""Layout of a text table: its delimiter, and which lines are titles, names, units and samples."""

import csv
import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

from layflat.identify.logs.table import parse_header, split_words
from layflat.identify.logs.text.cells import CellKind, classify_cell
from layflat.identify.logs.text.labels import read_block, read_stated_units
from layflat.identify.logs.text.numbers import is_number, normalize_cell
from layflat.identify.logs.text.stamps import is_stamp
from layflat.identify.logs.vocabulary import parse_unit, word_roles

ANY_BLANKS = " "  # one blank or more
WIDE_BLANKS = "  "  # two blanks or more
DELIMITERS = ("\t", ";", ",", "|", WIDE_BLANKS, ANY_BLANKS)
COMMENT_SIGNS = ("#", "%", "//")
HEADING_ROWS = 5  # above the samples, searched for names and units
TYPE_WORDS = frozenset([
    "string", "datetime", "bool", "double", "single", "float", "float32", "float64", "real", "lreal", "int", "dint",
    "int16", "int32", "int64",
])  # fmt: skip
"""Words of a row of data types."""
MAX_JOINED = 2000  # characters of a header
MIN_NUMERIC_FRACTION = 0.6  # of numbers and stamps among the cells of a numeric column
MIN_FILLED_FRACTION = 0.1  # of filled cells; a column with fewer does not count for the layout
_RULE_LINE = re.compile(r"[-=_+*\s|]*")
_ARRIVAL_TIME = re.compile(r"\[?\d{1,2}:\d{2}:\d{2}[.,]\d+\]? ?-> ?")
_BRACKETED_ROW = re.compile(r"\s*(?:\[([^\[\]]*)\]|\(([^()]*)\)|\{([^{}]*)\})[,;]?\s*")  # a row printed by Python
BRACKETS = frozenset("[({")
_STAMPED_ROW = re.compile(r"\s*[\[(](?P<time>[^\[\]()]*\d[^\[\]()]*)[\])]\s*[,;:|]?\s*(?P<rest>\S.*)", re.DOTALL)
_COLOURS = re.compile(r"\x1b\[[0-9;]*[A-Za-z]")  # of a terminal
_NEXT_LABEL = re.compile(r"\s+(?=[^\W\d][\w.]*\s?[:=]\s*[-+.\d])")  # before "angle: 12.3" in a row of labelled numbers
_CELL_PREFIX = re.compile(
    r"(?P<about>units?|einheit|type|interp|format) ?[:=] ?", re.IGNORECASE
)  # before each cell of a row


@dataclass(frozen=True)
class TextLayout:
    """Delimiter of a table, names and units of its columns, and the number of lines above the samples."""

    delimiter: str
    width: int  # fields of a row
    names: list[str] = field(default_factory=list)  # empty where the table has no header
    units: list[str] = field(default_factory=list)  # empty where the table has no row of units
    start: int = 0  # lines above the first sample
    arrivals: bool = False  # lines begin with the time of their arrival and "->", as in a serial monitor
    inner: frozenset[int] = frozenset()  # numbers of the lines below `start` that are headings, from 1
    heads: frozenset[str] = frozenset()  # lines above the samples that may be repeated among them
    step: float = 0.0  # s between samples from the heading; 0 where a column is the clock


def split_row(line: str, delimiter: str) -> list[str]:
    """Return the fields of a line without blanks around them."""
    if delimiter == ANY_BLANKS:
        line, delimiter = " ".join(line.split()), " "
    elif delimiter == WIDE_BLANKS:
        line = re.sub(r"[ \t]{2,}", "\t", line.strip())
        line, delimiter = _NEXT_LABEL.sub("\t", line) if len(_NEXT_LABEL.findall(line)) > 1 else line, "\t"
    try:
        return [cell.strip() for cell in next(csv.reader([line], delimiter=delimiter, skipinitialspace=True), [])]
    except csv.Error:
        return [cell.strip() for cell in line.split(delimiter)]


def join_lines(lines: Sequence[str]) -> list[str]:
    """Return lines with quoted line breaks joined; the first parts become empty lines, so that numbers stay."""
    result, pending = list[str](), ""
    for i, line in enumerate(lines):
        text = f"{pending} {line}" if pending else line
        open_quote = text.count('"') % 2 == 1 and len(text) < MAX_JOINED and i + 1 < len(lines)
        pending = text if open_quote else ""
        result.append("" if open_quote else text)
    return result if not pending else list(lines)


def is_rule(line: str) -> bool:
    """Return whether a line is empty or a rule of dashes, equals signs and the like."""
    return _RULE_LINE.fullmatch(line) is not None


def find_layout(lines: Sequence[str], delimiter: str = "") -> TextLayout:
    """Detect the layout of a table from its first lines.

    Args:
        lines: lines of the file, without line ends.
        delimiter: stated in the file; "" for the one with most numbers and fewest words.
    """
    arrivals = sum(_ARRIVAL_TIME.match(line) is not None for line in lines) > MIN_NUMERIC_FRACTION * len(lines)
    candidates = []
    for order, sign in enumerate((delimiter,) if delimiter else DELIMITERS):
        rows = [
            [] if is_rule(line) or is_comment(line) else split_row(clean_line(line, sign, arrivals), sign)
            for line in lines
        ]
        kinds = [[classify_cell(cell) for cell in row] for row in rows]
        width, score = _usual_width(kinds)
        layout = _read_heading(lines, rows, kinds, TextLayout(sign, width, arrivals=arrivals))
        fits = not layout.names or len(layout.names) == width
        words = [line.strip() for line, row in zip(lines[: layout.start], kinds, strict=False) if _is_wordy(row)]
        candidates.append((score, fits, width, -order, replace(layout, heads=frozenset(words))))
    return max(candidates, key=lambda candidate: candidate[:4])[4]


def clean_line(line: str, delimiter: str, arrivals: bool) -> str:
    """Return a line without colours and outer brackets, and with its arrival time as a field of its own.

    Args:
        line: line of the file.
        delimiter: delimiter of the table.
        arrivals: lines begin with the time of their arrival and "->".
    """
    if "\x1b" in line:
        line = _COLOURS.sub("", line)
    if line.lstrip()[:1] in BRACKETS:
        line = _without_brackets(line, delimiter)
    return line.replace("->", delimiter.strip(" ") or " ", 1) if arrivals else line


def _without_brackets(line: str, delimiter: str) -> str:
    """Return a line without brackets around it, or around the time at its start."""
    bracketed = _BRACKETED_ROW.fullmatch(line)
    if bracketed:
        return next(part for part in bracketed.groups() if part is not None)
    stamped = _STAMPED_ROW.match(line)
    if stamped and (is_number(stamped["time"].strip()) or is_stamp(stamped["time"].strip())):
        return f"{stamped['time'].strip()}{delimiter}{stamped['rest']}"
    return line


def is_comment(line: str) -> bool:
    """Return whether a line is a comment."""
    return line.lstrip().startswith(COMMENT_SIGNS)


def _is_wordy(row: Sequence[CellKind]) -> bool:
    """Return whether more than half of a row's cells are words."""
    return 2 * row.count("text") > len(row)


def _usual_width(kinds: Sequence[list[CellKind]]) -> tuple[int, float]:
    """Return the usual number of fields of rows with numbers, and a score of the delimiter: numbers less words."""
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


def _holds_numbers(row: Sequence[CellKind]) -> bool:
    """Return whether a row has filled cells, of which at most half are words."""
    return len(row) - row.count("missing") >= max(2 * row.count("text"), 1)


def _read_heading(
    lines: Sequence[str], rows: Sequence[list[str]], kinds: Sequence[list[CellKind]], layout: TextLayout
) -> TextLayout:
    """Return a layout with names, units and the first line of samples."""
    width = layout.width
    samples = [row for row in kinds if len(row) == width and _holds_numbers(row)]
    filled = [not samples or any(row[i] != "missing" for row in samples) for i in range(width)]  # columns
    used = sum(filled)
    numeric = [_is_numeric([row[i] for row in samples]) for i in range(width)]  # columns

    def is_sample(row: Sequence[CellKind]) -> bool:
        """Return whether a row is one of samples: as wide as the table, its numeric columns without words."""
        numeric_cells = [kind for kind, number in zip(row, numeric, strict=False) if number]
        if row[:1] == ["text"] and not filled[0]:  # a label
            return False
        return len(row) == width and "text" not in numeric_cells and any(kind != "missing" for kind in numeric_cells)

    def is_head(i: int) -> bool:
        """Return whether a row can be the header: words alone, about as many as columns."""
        row = kinds[i][1:] if layout.arrivals else kinds[i]
        if not 1 <= len(row) <= width + 1 or abs(len(row) - width) > 1 + layout.arrivals + row.count("missing"):
            return False
        filled = [kind for kind in row if kind != "missing"]
        words = [kind for kind in filled if kind == "text"]
        return 2 * len(filled) > used and len(words) == len(filled) > 2 * _count_types(rows[i])

    first = next((i for i, row in enumerate(kinds) if is_sample(row)), None)
    if first is None:  # words alone
        first = 1 if rows and rows[0] else 0
    block = read_block(rows[:first], filled)
    if block is not None:
        return replace(layout, names=block.names, units=block.units, start=first, step=block.step)
    above = [i for i in range(first) if rows[i]][-HEADING_ROWS:]
    heads = [i for i in above if is_head(i) or (is_unit_row(rows[i]) and len(rows[i]) == width)]
    unit_row = next((i for i in reversed(heads) if i != above[0] and is_unit_row(rows[i])), None)
    named = [i for i in heads if unit_row is None or i < unit_row]
    odd = [i for i in above if i != unit_row and kinds[i][0] == "text" and _can_be_names(kinds[i], width)]
    odd = [i for i in odd if 2 * _count_types(rows[i]) < len(rows[i])]
    if not named and odd and odd[-1] == (above[-1] if unit_row is None else unit_row - 1):
        named = odd[-1:]  # names of which some are numbers, or more or fewer than there are columns
    if named:
        head, last = named[-1], unit_row if unit_row is not None else named[-1]
        start = next((i for i in range(last + 1, first) if _has_number(kinds[i], numeric)), first)
        units = [_CELL_PREFIX.sub("", normalize_cell(cell)) for cell in rows[unit_row]] if unit_row is not None else (
            read_stated_units(rows[:head], width)
        )  # fmt: skip
        names = _name_cells(rows[head], layout.arrivals)
        if len(named) > 1 and named[-2] == head - 1 and len(rows[head - 1]) == len(names):
            names = [_join_upper_name(name, upper) for name, upper in zip(names, rows[head - 1], strict=True)]
        if len(names) == width - 1 and samples and all(row[-1] == "missing" for row in samples):
            names.append("")  # rows end with a delimiter, and the header does not
        elif len(names) == width - 1 and _are_row_numbers([row[0] for row in rows[start:] if len(row) == width]):
            names.insert(0, "")  # names of rows, as R writes them
        return replace(layout, names=names, units=units, start=start)
    start = next((i for i in range(first) if len(rows[i]) == width and _has_number(kinds[i], numeric)), first)
    commented = _commented_names(lines[:start], layout)
    return replace(layout, start=start) if commented is None else replace(layout, names=commented, start=start)


def _commented_names(lines: Sequence[str], layout: TextLayout) -> list[str] | None:
    """Return the names in the last comment with as many words as there are columns, or None without one."""
    for line in reversed(lines):
        text = line.lstrip()
        sign = next((sign for sign in COMMENT_SIGNS if text.startswith(sign)), "")
        names = split_row(clean_line(text.removeprefix(sign), layout.delimiter, layout.arrivals), layout.delimiter)
        words = all(classify_cell(name) in {"text", "missing"} for name in names)
        if sign and len(names) == layout.width > 1 and words:
            return names
    return None


def _count_types(cells: Sequence[str]) -> int:
    """Return the number of cells that are `TYPE_WORDS`, or begin with a subject, as "Type: double" does."""
    return sum(cell.lower() in TYPE_WORDS or _cell_subject(cell) != "" for cell in cells)


def _join_upper_name(name: str, upper: str) -> str:
    """Return a name, with the one above it where only that has a meaning: "Angle CH1 [deg]"."""
    roles, upper_roles = (word_roles(split_words(parse_header(cell).stem)) for cell in (name, upper))
    return f"{upper} {name}" if upper_roles and not roles else name


def _are_row_numbers(cells: Sequence[str]) -> bool:
    """Return whether cells number their rows."""
    numbers = [int(cell) for cell in cells if cell.isdecimal()]
    return len(cells) == len(numbers) > 1 and numbers == list(range(numbers[0], numbers[0] + len(numbers)))


def _cell_subject(cell: str) -> str:
    """Return the first word of a cell such as "Units: kPa" or "Type: double"; "" for others."""
    match = _CELL_PREFIX.match(cell)
    return match["about"].lower() if match else ""


def _can_be_names(row: Sequence[CellKind], width: int) -> bool:
    """Return whether a row has as many cells as columns, or words alone."""
    return len(row) == width or (len(row) > 1 and all(kind == "text" for kind in row))


def _name_cells(names: list[str], arrivals: bool) -> list[str]:
    """Return the names of a header row, without comment sign, and with a name for arrival times."""
    first = "arrival" if arrivals else names[0].lstrip("#").strip()
    return [first, *names[1:]]


def _has_number(row: Sequence[CellKind], numeric: Sequence[bool]) -> bool:
    """Return whether a row has all columns, and most filled cells of its numeric ones are no words."""
    numeric_cells = [kind for kind, number in zip(row, numeric, strict=False) if number and kind != "missing"]
    return len(row) == len(numeric) and len(numeric_cells) > 2 * numeric_cells.count("text")


def _is_numeric(kinds: Sequence[CellKind]) -> bool:
    """Return whether a column is filled enough and most of its filled cells are no words."""
    filled = [kind for kind in kinds if kind != "missing"]
    return len(filled) > MIN_FILLED_FRACTION * len(kinds) and sum(
        kind != "text" for kind in filled
    ) >= MIN_NUMERIC_FRACTION * len(filled)


def is_unit_row(row: Sequence[str]) -> bool:
    """Return whether most cells of a row are units and none is a number."""
    cells = [_CELL_PREFIX.sub("", normalize_cell(cell)).strip("[](){}<> ") for cell in row]
    filled = [cell for cell in cells if cell and cell not in {"-", "1"}]
    units = sum(parse_unit(cell) is not None for cell in filled)
    return (
        bool(filled)
        and 2 * units >= len(filled)
        and not any(classify_cell(cell) in {"number", "stamp"} for cell in filled)
    )
