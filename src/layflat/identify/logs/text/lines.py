"""Rows of samples for pandas, without comments, rules, repeated headers and broken rows; and encodings.

An encoding is detected by byte order mark, by declaration, as UTF-8, else it is Windows-1252.
"""

import codecs
import csv
import io
import re
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import IO, BinaryIO

from layflat.errors import InputError
from layflat.identify.logs.text.cells import classify_cell, shorten
from layflat.identify.logs.text.layout import (
    ANY_BLANKS,
    BRACKETS,
    COMMENT_SIGNS,
    WIDE_BLANKS,
    TextLayout,
    clean_line,
    is_rule,
    split_row,
)

_BYTE_ORDER_MARKS = ((codecs.BOM_UTF8, "utf-8-sig"), (codecs.BOM_UTF32_LE, "utf-32"), (codecs.BOM_UTF32_BE, "utf-32"),
          (codecs.BOM_UTF16_LE, "utf-16"), (codecs.BOM_UTF16_BE, "utf-16"))  # fmt: skip
_DECLARED_ENCODING = re.compile(
    rb"(?:coding|charset)\s*[:=]\s*[\"']?((?:utf|iso|latin|cp|windows|mac|ascii|us-ascii|gb|big5|shift|sjis|euc|koi)[-\w.]*)",
    re.IGNORECASE,
)
MAX_CONTROL_FRACTION = 0.01  # of control characters: a file with more is binary; a serial port leaves a few
_BLOCK_BYTES = 1 << 20  # bytes read at once
_HEAD_BYTES = 4096  # bytes in which an encoding may be declared
_CONTROL_BYTES = bytes(set(range(32)) - set(b"\t\n\r\f\v\x1a\x1b"))
FALLBACK_ENCODING = "cp1252"
OTHER_FILE_KINDS = (
    (b"\x1f\x8b", "is compressed by gzip", "unpack it first: gunzip"),
    (b"pk\x03\x04", "is a workbook of a spreadsheet, or an archive", "save its sheet as CSV, or unpack it"),
    (b"\xd0\xcf\x11\xe0", "is a workbook of an old spreadsheet", "save its sheet as CSV"),
    (b'{"', "holds JSON", "write it as CSV: a header, and a row a sample"),
    (b"[{", "holds JSON", "write it as CSV: a header, and a row a sample"),
    (b"<html", "holds a page of HTML", "write its table as CSV"),
    (b"<!doctype", "holds a page of HTML", "write its table as CSV"),
    (b"<?xml", "holds XML", "write its table as CSV"),
)
"""First bytes of files that are no text table, in small letters, with the message and the advice."""
TEXT_ADVICE = "give a table of text, or a file that ends in .parquet, .nc or .mcap"


def detect_encoding(path: Path) -> tuple[str, str]:
    """Return the encoding of a text file, and a note where it is guessed, else "".

    Raises:
        InputError: it is not a text file, or a text file of another kind.
    """
    with path.open("rb") as file:
        head = file.read(_HEAD_BYTES)
        for magic, problem, right in OTHER_FILE_KINDS:
            if head.lstrip().lower().startswith(magic):
                raise InputError(problem, where=str(path), right=right)
        marked = next((name for mark, name in _BYTE_ORDER_MARKS if head.startswith(mark)), "") or _guess_utf16(head)
        if not marked and sum(byte in _CONTROL_BYTES for byte in head) > MAX_CONTROL_FRACTION * len(head):
            raise InputError("is not a text file", where=str(path), right=TEXT_ADVICE)
        declared = _DECLARED_ENCODING.search(b"\n".join(head.splitlines()[:3]))
        named = declared[1].decode() if declared else ""
        for encoding in filter(None, (marked, named, "utf-8")):
            if _can_decode(file, encoding):
                return encoding, ""
    return FALLBACK_ENCODING, "is not UTF-8, and is read as Windows-1252: check names and units that are not ASCII"


def _guess_utf16(head: bytes) -> str:
    """Return the variant of UTF-16 of a text in which nearly every other byte is null; "" for other texts."""
    even, odd = head[0::2].count(0), head[1::2].count(0)
    half = max(len(head) // 2, 1)
    return "utf-16-le" if odd > 0.8 * half and not even else "utf-16-be" if even > 0.8 * half and not odd else ""


def _can_decode(file: BinaryIO, encoding: str) -> bool:
    """Return whether a whole file is valid in an encoding."""
    file.seek(0)
    try:
        decoder = codecs.getincrementaldecoder(encoding)()
        while block := file.read(_BLOCK_BYTES):
            decoder.decode(block)
        decoder.decode(b"", final=True)
    except (UnicodeError, LookupError):
        return False
    return True


BATCH_LINES = 4096  # lines read at once
MAX_BROKEN_FRACTION = 0.01  # of rows with another number of values, which are left out; with more a table is refused

Progress = Callable[[float], None]  # called with the fraction that is read


class SampleLines(io.TextIOBase):
    """File of the rows of samples of a table, with a field for each column; rows left out are counted."""

    def __init__(self, path: Path, encoding: str, layout: TextLayout, progress: Progress | None = None) -> None:
        self.path, self.layout, self.progress = path, layout, progress
        self.delimiter = "\t" if layout.delimiter in {ANY_BLANKS, WIDE_BLANKS} else layout.delimiter
        self.rows, self.broken, self.first_broken = 0, 0, ""
        self._file = path.open(encoding=encoding, errors="replace")
        self._size = max(path.stat().st_size, 1)
        self._batches = self._read()
        self._rest = ""

    def readable(self) -> bool:
        """Return True."""
        return True

    def read(self, size: int | None = -1, /) -> str:
        """Return up to `size` characters, all for a negative size; "" at the end."""
        limit = float("inf") if size is None or size < 0 else size
        parts = [self._rest]
        length = len(self._rest)
        while length < limit and (batch := next(self._batches, "")):
            parts.append(batch)
            length += len(batch)
        text = "".join(parts)
        cut = len(text) if limit == float("inf") else int(limit)
        self._rest = text[cut:]
        return text[:cut]

    def __iter__(self) -> Iterator[str]:  # type: ignore[override]  # typeshed takes all streams for bytes
        return iter(self.read().splitlines(keepends=True))

    def close(self) -> None:
        """Close the file."""
        self._file.close()
        super().close()

    def check(self) -> list[str]:
        """Return notes on rows that were left out; raise InputError if they are more than `MAX_BROKEN_FRACTION`."""
        if not self.broken:
            return []
        problem = f"{self.first_broken} in place of {self.layout.width}"
        if self.broken > MAX_BROKEN_FRACTION * (self.rows + self.broken):
            raise InputError(problem, where=str(self.path), right=self._right())
        plural = "s" if self.broken > 1 else ""
        return [f"{self.broken} row{plural} of another length left out, the first: {problem}"]

    def _right(self) -> str:
        """Return the advice for rows with another number of values."""
        if self.layout.delimiter == ",":
            return "give each row as many values as the header has; decimal commas need another delimiter, such as ;"
        return "give each row as many values as the header has"

    def _read(self) -> Iterator[str]:
        """Yield the rows of samples in batches of `BATCH_LINES` lines; report progress as a fraction of the file."""
        layout, batch = self.layout, list[str]()
        raw: IO[bytes] = self._file.buffer  # type: ignore[assignment]
        for count, line in enumerate(self._file, 1):
            if count <= layout.start or count in layout.inner:
                continue
            row = self._row(line.rstrip("\n"), count)
            if row is not None:
                batch.append(row + "\n")
            if len(batch) == BATCH_LINES:
                yield "".join(batch)
                batch.clear()
                if self.progress is not None:
                    self.progress(raw.tell() / self._size)
        yield "".join(batch)

    def _row(self, line: str, count: int) -> str | None:
        """Return a line as a row with a field for each column, and count it; None if broken or no row of samples."""
        layout, width = self.layout, self.layout.width
        if layout.arrivals or "\x1b" in line or line.lstrip()[:1] in BRACKETS:
            line = clean_line(line, layout.delimiter, layout.arrivals)
        elif line.strip() in layout.heads:
            return None
        if self.delimiter != layout.delimiter:
            line = "\t".join(split_row(line, layout.delimiter))
        quoted = '"' in line
        fields = len(split_row(line, self.delimiter)) if quoted else line.count(self.delimiter) + 1
        if fields == width and "\0" not in line and line[:1] not in "#%=-":
            self.rows += 1
            return line
        if is_rule(line) or line.lstrip().startswith(COMMENT_SIGNS):
            return None
        cells = split_row(line, self.delimiter)
        while len(cells) > width and not cells[-1]:
            cells.pop()
        if len(cells) == width and "\0" not in line:
            self.rows += 1
            return _csv_line(cells, self.delimiter)
        if all(classify_cell(cell) in {"text", "missing"} for cell in cells):
            return None  # a repeated header, or an end mark
        self.broken += 1
        self.first_broken = self.first_broken or f"line {count} ({shorten(line.strip())!r}) has {len(cells)} values"
        return None


def _csv_line(cells: list[str], delimiter: str) -> str:
    """Return cells as a line of CSV, quoted where needed."""
    text = io.StringIO()
    csv.writer(text, delimiter=delimiter, lineterminator="").writerow(cells)
    return text.getvalue()
