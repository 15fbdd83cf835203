"""Folder of a study: study.json with its content, chunks/ with finished chunks, table.parquet and table.csv.

While chunks are missing, partial.txt says how many runs are done.
"""

import json
import os
import re
import shutil
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from layflat.errors import InputError, OutputError
from layflat.extras import import_extra
from layflat.files import whole_file, write_text
from layflat.outputs import is_forced

if TYPE_CHECKING:
    import pandas
    import pyarrow

ANSWER_FILES = ("figure.png", "figure.svg", "finding.txt")
"""Figures and finding of a study; only built-in studies have a finding."""

STUDY_FILES = {"study.json", "chunks", "table.parquet", "table.csv", "partial.txt", *ANSWER_FILES}

TEMPORARY_FILE = re.compile(r"\.(study|table|partial|figure|finding|\d{5,})-\w+\.(json|parquet|csv|png|svg|txt)")
"""Pattern of temporary files of a run that was killed."""

CHUNK_NAME = re.compile(r"\d{5,}\.parquet")

BYTES_A_CELL, BYTES_A_COLUMN, BYTES_A_NUMBER = 10, 400, 24
"""Upper bounds: of a number in a Parquet file, of a column's metadata in a chunk, of a number as text."""


class ChangedError(OutputError):
    """Error for a folder with another study than the one to be run; `differences` has a line for each."""

    def __init__(self, what: str, where: str, differences: list[str]) -> None:
        super().__init__(what, where=where, right="give another folder, or the study as it was")
        self.differences = differences


class StudyFolder:
    """Folder of a study's results, with a number of chunks."""

    def __init__(self, place: Path, chunks: int) -> None:
        self.place, self.chunks = place, chunks
        self.study, self.table, self.partial = (place / name for name in ("study.json", "table.parquet", "partial.txt"))

    def chunk(self, number: int) -> Path:
        """Return the file of a chunk."""
        return self.place / "chunks" / f"{number:05d}.parquet"

    def finished_chunks(self) -> dict[int, int]:
        """Return the number of rows of each chunk that can be read, by its index, which is below `chunks`."""
        parquet, counts = _import_arrow("parquet"), {}
        for number in sorted(int(one.stem) for one in self.chunk(0).parent.glob("*.parquet") if one.stem.isdecimal()):
            try:
                counts[number] = int(parquet.read_metadata(self.chunk(number)).num_rows)
            except (OSError, ValueError):  # broken
                continue
        return {number: rows for number, rows in counts.items() if number < self.chunks}

    def holds(self, content: dict[str, Any]) -> bool:
        """Return whether study.json has this content; False without the file, or if it can't be read."""
        try:
            held = json.loads(self.study.read_text(encoding="utf-8"))
        except (OSError, ValueError):
            return False
        return bool(held == json.loads(json.dumps(content)))

    def write_chunk(self, number: int, table: "pyarrow.Table") -> None:
        """Write a chunk; raise OutputError if it can't be written."""
        with whole_file(self.chunk(number), owned=True) as temporary:
            _import_arrow("parquet").write_table(table, temporary)

    def mark_partial(self, done: str) -> None:
        """Write partial.txt: how much of the study is done."""
        write_text(self.partial, f"partial: {done}; the same command goes on from here\n", owned=True)

    def write_table(self) -> Path:
        """Write the table from all chunks, in their order, as Parquet and, with units in its header, as CSV.

        Remove partial.txt, and return the path of the Parquet file.
        """
        parquet, csv = _import_arrow("parquet"), _import_arrow("csv")
        schema = parquet.read_schema(self.chunk(0))
        headed = [f"{field.name} [{field.metadata[b'unit'].decode()}]" for field in schema]
        with (
            whole_file(self.place / "table.csv") as text,
            whole_file(self.table) as temporary,
            parquet.ParquetWriter(temporary, schema) as writer,
            csv.CSVWriter(text, schema.empty_table().rename_columns(headed).schema) as rows,
        ):
            for number in range(self.chunks):
                part = parquet.read_table(self.chunk(number), schema=schema)
                writer.write_table(part)
                rows.write_table(part.rename_columns(headed))
        self.partial.unlink(missing_ok=True)
        return self.table

    @contextmanager
    def lock(self, content: dict[str, Any]) -> Iterator[None]:
        """Lock a new folder for a study, or the one in which it was stopped, for this process; write study.json.

        Temporary files of a killed run are removed, and with --force another study.

        Raises:
            ChangedError: it holds another study.
            OutputError: it can't be written, holds other files, or is in use.
        """
        try:
            self.place.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            right = "give a folder that you may write to"
            raise OutputError(f"can't write here ({error.strerror})", where=str(self.place), right=right) from None
        with _lock_folder(self.place):
            self._refuse_foreign()
            if self.study.exists() and is_forced() and not self.holds(content):
                self._clear()
            elif self.study.exists():
                self._refuse_other(content)
            for leftover in [*self.place.glob(".*"), *self.chunk(0).parent.glob(".*")]:
                leftover.unlink()
            if not self.study.exists():
                write_text(self.study, json.dumps(content, indent=2) + "\n", owned=True)
            yield

    def _clear(self) -> None:
        """Remove the study that the folder holds."""
        for path in [entry for entry in self.place.iterdir() if entry.name in STUDY_FILES]:
            shutil.rmtree(path) if path.is_dir() else path.unlink()

    def _refuse_foreign(self) -> None:
        """Raise OutputError for any other file than a study's; without study.json for any but temporary ones."""
        expected = STUDY_FILES if self.study.exists() else set()
        foreign = [path.name for path in self.place.iterdir() if path.name not in expected]
        if expected:
            foreign += [
                f"chunks/{one.name}" for one in self.place.glob("chunks/*") if not CHUNK_NAME.fullmatch(one.name)
            ]
        foreign = sorted(name for name in foreign if not TEMPORARY_FILE.fullmatch(name.removeprefix("chunks/")))
        if foreign:
            what, right = f"holds {foreign[0]!r}, which is none of a study's files", "give a new or an empty folder"
            raise OutputError(what, where=str(self.place), right=right)

    def _refuse_other(self, content: dict[str, Any]) -> None:
        """Raise ChangedError, with the differences, for a study of another content; OutputError if it can't be read."""
        try:
            before = _flatten(json.loads(self.study.read_text(encoding="utf-8")))
        except ValueError:
            right = "give a new or an empty folder"
            raise OutputError("is not a study's file", where=str(self.study), right=right) from None
        now = _flatten(json.loads(json.dumps(content)))
        lines = [
            f"{key}: {before.get(key, '(none)')} -> {now.get(key, '(none)')}"
            for key in now | before
            if before.get(key) != now.get(key)
        ]
        if before != now:
            raise ChangedError("holds a study that differs from this one", str(self.place), lines)

    def check_space(self, rows: int, columns: int, chunks: int) -> None:
        """Refuse a disk without space for a study, before any computation.

        Args:
            rows: number of rows to write.
            columns: number of columns.
            chunks: number of chunks to write.

        Raises:
            OutputError: the disk has less free space than the chunks and the table need.
        """
        needed = columns * ((2 * BYTES_A_CELL + BYTES_A_NUMBER) * rows + 2 * BYTES_A_COLUMN * chunks)
        there = next(path for path in (self.place, *self.place.absolute().parents) if path.exists())
        free = shutil.disk_usage(there).free
        if needed > free:
            what = f"needs {needed / 1e6:,.1f} MB, and {free / 1e6:,.1f} MB are free"
            raise OutputError(what, where=str(self.place), right="make room, or give a folder on another disk")


def study_table(out: str | Path) -> "pandas.DataFrame":
    """Return the table of a finished study; `attrs["units"]` has the unit of every column.

    Raises:
        InputError: the folder has none.
    """
    parquet, path = _import_arrow("parquet"), Path(out) / "table.parquet"
    if not path.exists():
        raise InputError("holds no table of a study", where=str(out), right="`layflat study run` writes one")
    whole = parquet.read_table(path)
    frame: pandas.DataFrame = whole.to_pandas()
    frame.attrs["units"] = {field.name: field.metadata[b"unit"].decode() for field in whole.schema}
    return frame


def _flatten(value: Any, path: str = "") -> dict[str, Any]:
    """Return the values of nested tables and lists by dotted path, items by number; empty ones count as values."""
    if not isinstance(value, (dict, list)) or not value:
        return {path: value}
    items = value.items() if isinstance(value, dict) else enumerate(value)
    return {
        key: leaf
        for name, item in items
        for key, leaf in _flatten(item, f"{path}.{name}" if path else str(name)).items()
    }


def _import_arrow(part: str) -> Any:
    """Import a part of the library that reads and writes tables."""
    return import_extra("study", f"pyarrow.{part}", where="study")


@contextmanager
def _lock_folder(place: Path) -> Iterator[None]:
    """Lock a folder against other processes, until the block or this process ends; do nothing on Windows.

    Raise OutputError if another process holds the lock.
    """
    if sys.platform == "win32":
        yield
        return
    import fcntl  # noqa: PLC0415  # not on every system

    handle = os.open(place, os.O_RDONLY)
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        yield
    except BlockingIOError:
        raise OutputError("is in use by another run of the study", where=str(place), right="wait for it") from None
    finally:
        os.close(handle)
