"""Readers of log files, chosen by a file's first bytes, as suffixes are often wrong."""

import hashlib
from collections.abc import Callable
from pathlib import Path

import numpy as np

from layflat.description.text import check_regular
from layflat.errors import InputError
from layflat.identify.logs import arrays, bags
from layflat.identify.logs.arrangement import arrange_columns
from layflat.identify.logs.clocks import join_stamps
from layflat.identify.logs.table import FileContent, LogTable
from layflat.identify.logs.text import read_text

Reader = Callable[[Path], FileContent]


TABLE_ADVICE = "give a table of samples, with commas, semicolons, tabs, bars or blanks between columns"


def read_table(path: str | Path, progress: Callable[[float], None] | None = None) -> LogTable:
    """Read a log's file in the format of its first bytes, else of its suffix.

    Args:
        path: path of the file.
        progress: called with the fraction of a text file that is read.

    Returns:
        Columns of raw numbers by name.

    Raises:
        InputError: it can't be read, or holds no numbers.
    """
    path, right = Path(path), "give a CSV, Parquet, NetCDF or MCAP file"
    if path.is_dir():
        inside = sorted(file for file in path.iterdir() if file.suffix in {".mcap", ".db3"})
        right = f"give the recording inside: {inside[0]}" if inside else right
    check_regular(path, str(path), right)
    try:
        with path.open("rb") as file:
            sha256 = hashlib.file_digest(file, "sha256").hexdigest()
            file.seek(0)
            start = file.read(16)
    except OSError as error:
        raise InputError(f"can't be read ({error.strerror})", where=str(path), right=right) from None
    columns, clock, words, notes = _read_content(path, start, progress)
    if not any(np.isfinite(column.values).any() for column in columns.values()):
        first = next((f": column {name!r} {why}" for name, why in words.items()), "")
        raise InputError(f"holds no numbers{first}", where=str(path), right=TABLE_ADVICE)
    columns = join_stamps(columns) if clock is None else columns
    return LogTable(path, sha256, columns, clock, notes, dict(words))


def _read_content(path: Path, head: bytes, progress: Callable[[float], None] | None) -> FileContent:
    """Read a file by the reader of its format.

    Args:
        path: the file.
        head: its first bytes, 16 or more if it has them.
        progress: called with the fraction of a text file that is read.

    Returns:
        The columns and notes of its reader.
    """
    for magic, reader in READERS_BY_MAGIC.items():
        if head.startswith(magic):
            return reader(path)
    if path.suffix.lower() == ".mcap" or path.name.endswith(".mcap.part"):
        return bags.read_mcap(path)
    if path.suffix.lower() in READERS_BY_SUFFIX:
        return READERS_BY_SUFFIX[path.suffix.lower()](path)
    text = read_text(path, progress)
    content = arrange_columns(text.columns, text.units, text.notes, text.starts)
    return content._replace(notes=(*text.notes.get("", ()), *content.notes))


def _refuse_compressed(command: str) -> Reader:
    """Return a reader that raises InputError with the command to decompress the file."""

    def refuse(path: Path) -> FileContent:
        right = f"unpack it first: `{command} {path.name}`"
        raise InputError("is compressed as a whole", where=str(path), right=right)

    return refuse


READERS_BY_MAGIC: dict[bytes, Reader] = {
    b"\x89MCAP0\r\n": bags.read_mcap,
    b"#ROSBAG V2.0": bags.read_ros1_bag,
    b"SQLite format 3\0": bags.read_sqlite_bag,
    b"PAR1": arrays.read_parquet,
    b"\x89HDF\r\n\x1a\n": arrays.read_netcdf,
    b"CDF\x01": arrays.read_netcdf,
    b"CDF\x02": arrays.read_netcdf,
    b"CDF\x05": arrays.read_netcdf,
    b"\x28\xb5\x2f\xfd": _refuse_compressed("zstd -d"),
    b"\x04\x22\x4d\x18": _refuse_compressed("lz4 -d"),
}
"""Readers by the first bytes of a file."""

READERS_BY_SUFFIX: dict[str, Reader] = {
    ".bag": bags.read_ros1_bag,
    ".db3": bags.read_sqlite_bag,
    ".parquet": arrays.read_parquet,
    ".pq": arrays.read_parquet,
    ".nc": arrays.read_netcdf,
    ".nc4": arrays.read_netcdf,
    ".h5": arrays.read_netcdf,
}
"""Readers by suffix, for files with other first bytes: the reader says what is wrong with them."""
