"""Lines of samples, as pandas can read them: comments, rules, repeated headers and broken rows are left out."""

import csv
import io
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import IO

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
