"""Lines of samples, as pandas can read them: comments, rules, repeated headers and broken rows are left out.

Encodings are told by byte order mark, by declaration, as UTF-8, and as Windows' own where it is none of these.
"""

import codecs
import csv
import io
import re
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import IO, BinaryIO

from layflat.errors import InputError
from layflat.identify.logs.text.cells import kind_of, shortened
from layflat.identify.logs.text.layout import (
    BLANKS,
    BRACKETS,
    COMMENTS,
    WIDE_BLANKS,
    Layout,
    is_rule,
    parted,
    split_row,
)

_MARKS = ((codecs.BOM_UTF8, "utf-8-sig"), (codecs.BOM_UTF32_LE, "utf-32"), (codecs.BOM_UTF32_BE, "utf-32"),
          (codecs.BOM_UTF16_LE, "utf-16"), (codecs.BOM_UTF16_BE, "utf-16"))  # fmt: skip
_DECLARED = re.compile(
    rb"(?:coding|charset)\s*[:=]\s*[\"']?((?:utf|iso|latin|cp|windows|mac|ascii|us-ascii|gb|big5|shift|sjis|euc|koi)[-\w.]*)",
    re.IGNORECASE,
)
GARBAGE = 0.01  # fraction of control characters above which a file is binary; a serial port leaves a few
_BLOCK = 1 << 20  # bytes read at once
_HEAD = 4096  # bytes in which an encoding may be declared
_CONTROLS = bytes(set(range(32)) - set(b"\t\n\r\f\v\x1a\x1b"))
WINDOWS = "cp1252"
FOREIGN = (
    (b"\x1f\x8b", "is compressed by gzip", "unpack it first: gunzip"),
    (b"pk\x03\x04", "is a workbook of a spreadsheet, or an archive", "save its sheet as CSV, or unpack it"),
    (b"\xd0\xcf\x11\xe0", "is a workbook of an old spreadsheet", "save its sheet as CSV"),
    (b'{"', "holds JSON", "write it as CSV: a header, and a row a sample"),
    (b"[{", "holds JSON", "write it as CSV: a header, and a row a sample"),
    (b"<html", "holds a page of HTML", "write its table as CSV"),
    (b"<!doctype", "holds a page of HTML", "write its table as CSV"),
    (b"<?xml", "holds XML", "write its table as CSV"),
)
"""Beginnings of files that hold no table of text, in small letters, with the message and the advice."""
RIGHT = "give a table of text, or a file that ends in .parquet, .nc or .mcap"


def encoding_of(path: Path) -> tuple[str, str]:
    """Return the encoding of a text file, and a note where it had to be guessed.

    Raises:
        InputError: it is not a text file, or one that holds no table.
    """
    with path.open("rb") as file:
        head = file.read(_HEAD)
        for begins, what, right in FOREIGN:
            if head.lstrip().lower().startswith(begins):
                raise InputError(what, where=str(path), right=right)
        marked = next((name for mark, name in _MARKS if head.startswith(mark)), "") or _without_mark(head)
        if not marked and sum(byte in _CONTROLS for byte in head) > GARBAGE * len(head):
            raise InputError("is not a text file", where=str(path), right=RIGHT)
        declared = _DECLARED.search(b"\n".join(head.splitlines()[:3]))
        named = declared[1].decode() if declared else ""
        for encoding in filter(None, (marked, named, "utf-8")):
            if _decodes(file, encoding):
                return encoding, ""
    return WINDOWS, "is not UTF-8, and is read as Windows-1252: check names and units that are not ASCII"


def _without_mark(head: bytes) -> str:
    """Return the kind of UTF-16 of a text whose every other byte is null."""
    even, odd = head[0::2].count(0), head[1::2].count(0)
    half = max(len(head) // 2, 1)
    return "utf-16-le" if odd > 0.8 * half and not even else "utf-16-be" if even > 0.8 * half and not odd else ""


def _decodes(file: BinaryIO, encoding: str) -> bool:
    file.seek(0)
    try:
        decoder = codecs.getincrementaldecoder(encoding)()
        while block := file.read(_BLOCK):
            decoder.decode(block)
        decoder.decode(b"", final=True)
    except (UnicodeError, LookupError):
        return False
    return True


BATCH = 4096  # lines that are handed over at once
MAX_BROKEN = 0.01  # fraction of rows with another number of values that are left out; with more a table is refused

Progress = Callable[[float], None]  # takes the fraction that is read


class SampleLines(io.TextIOBase):
    """File of the rows of samples of a table alone, with a field for each column; what is left out is counted."""

    def __init__(self, path: Path, encoding: str, layout: Layout, progress: Progress | None = None) -> None:
        self.path, self.layout, self.progress = path, layout, progress
        self.delimiter = "\t" if layout.delimiter in {BLANKS, WIDE_BLANKS} else layout.delimiter
        self.rows, self.broken, self.first_broken = 0, 0, ""
        self._file = path.open(encoding=encoding, errors="replace")
        self._size = max(path.stat().st_size, 1)
        self._batches = self._read()
        self._rest = ""

    def readable(self) -> bool:
        """Return True."""
        return True

    def read(self, size: int | None = -1, /) -> str:
        """Return some characters, "" at the end."""
        wanted = float("inf") if size is None or size < 0 else size
        parts = [self._rest]
        length = len(self._rest)
        while length < wanted and (batch := next(self._batches, "")):
            parts.append(batch)
            length += len(batch)
        text = "".join(parts)
        cut = len(text) if wanted == float("inf") else int(wanted)
        self._rest = text[cut:]
        return text[:cut]

    def __iter__(self) -> Iterator[str]:  # type: ignore[override]  # typeshed takes all streams for bytes
        return iter(self.read().splitlines(keepends=True))

    def close(self) -> None:
        """Close the file."""
        self._file.close()
        super().close()

    def check(self) -> list[str]:
        """Return a note on rows that were left out; raise InputError if they are too many."""
        if not self.broken:
            return []
        what = f"{self.first_broken} in place of {self.layout.width}"
        if self.broken > MAX_BROKEN * (self.rows + self.broken):
            raise InputError(what, where=str(self.path), right=self._right())
        plural = "s" if self.broken > 1 else ""
        return [f"{self.broken} row{plural} of another length left out, the first: {what}"]

    def _right(self) -> str:
        if self.layout.delimiter == ",":
            return "give each row as many values as the header has; decimal commas need another delimiter, such as ;"
        return "give each row as many values as the header has"

    def _read(self) -> Iterator[str]:
        layout, batch = self.layout, list[str]()
        raw: IO[bytes] = self._file.buffer  # type: ignore[assignment]
        for count, line in enumerate(self._file, 1):
            if count <= layout.start or count in layout.inner:
                continue
            row = self._row(line.rstrip("\n"), count)
            if row is not None:
                batch.append(row + "\n")
            if len(batch) == BATCH:
                yield "".join(batch)
                batch.clear()
                if self.progress is not None:
                    self.progress(raw.tell() / self._size)
        yield "".join(batch)

    def _row(self, line: str, count: int) -> str | None:
        """Return a row with a field for each column; None for a line that is none."""
        layout, width = self.layout, self.layout.width
        if layout.arrivals or "\x1b" in line or line.lstrip()[:1] in BRACKETS:
            line = parted(line, layout.delimiter, layout.arrivals)
        elif line.strip() in layout.heads:
            return None
        if self.delimiter != layout.delimiter:
            line = "\t".join(split_row(line, layout.delimiter))
        quoted = '"' in line
        fields = len(split_row(line, self.delimiter)) if quoted else line.count(self.delimiter) + 1
        if fields == width and "\0" not in line and line[:1] not in "#%=-":
            self.rows += 1
            return line
        if is_rule(line) or line.lstrip().startswith(COMMENTS):
            return None
        cells = split_row(line, self.delimiter)
        while len(cells) > width and not cells[-1]:
            cells.pop()
        if len(cells) == width and "\0" not in line:
            self.rows += 1
            return _joined(cells, self.delimiter)
        if all(kind_of(cell) in {"text", "missing"} for cell in cells):
            return None  # a header that stands there again, an end mark
        self.broken += 1
        self.first_broken = self.first_broken or f"line {count} ({shortened(line.strip())!r}) has {len(cells)} values"
        return None


def _joined(cells: list[str], delimiter: str) -> str:
    text = io.StringIO()
    csv.writer(text, delimiter=delimiter, lineterminator="").writerow(cells)
    return text.getvalue()
