"""Readers of log files, by what a file begins with: names of files are often wrong."""

import hashlib
from collections.abc import Callable
from pathlib import Path

import numpy as np

from layflat.description.text import check_regular
from layflat.errors import InputError
from layflat.identify.logs import arrays, bag, rosbag
from layflat.identify.logs.arrangement import arranged
from layflat.identify.logs.clocks import join_stamps
from layflat.identify.logs.table import Content, Table
from layflat.identify.logs.text import read_text

Reader = Callable[[Path], Content]


RIGHT = "give a table of samples, with commas, semicolons, tabs, bars or blanks between columns"


def read_table(path: str | Path, progress: Callable[[float], None] | None = None) -> Table:
    """Read a log's file, of the kind that it begins as, or is named.

    Args:
        path: of the file.
        progress: takes the fraction of a text file that is read.

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
        raise InputError(f"holds no numbers{first}", where=str(path), right=RIGHT)
    columns = join_stamps(columns) if clock is None else columns
    return Table(path, sha256, columns, clock, notes, dict(words))


def _read_content(path: Path, start: bytes, progress: Callable[[float], None] | None) -> Content:
    """Read a file by its kind.

    Args:
        path: the file.
        start: its first bytes, 16 or more if it has them.
        progress: takes the fraction of a text file that is read.

    Returns:
        What its reader hands over.
    """
    for magic, reader in READERS.items():
        if start.startswith(magic):
            return reader(path)
    if path.suffix.lower() == ".mcap" or path.name.endswith(".mcap.part"):
        return bag.read_bag(path)
    if path.suffix.lower() in BY_SUFFIX:
        return BY_SUFFIX[path.suffix.lower()](path)
    text = read_text(path, progress)
    content = arranged(text.columns, text.units, text.notes, text.starts)
    return content._replace(notes=(*text.notes.get("", ()), *content.notes))


def _packed(program: str) -> Reader:
    def refuse(path: Path) -> Content:
        right = f"unpack it first: `{program} {path.name}`"
        raise InputError("is compressed as a whole", where=str(path), right=right)

    return refuse


READERS: dict[bytes, Reader] = {
    b"\x89MCAP0\r\n": bag.read_bag,
    b"#ROSBAG V2.0": rosbag.read_bag_of_ros1,
    b"SQLite format 3\0": rosbag.read_bag_in_sqlite,
    b"PAR1": arrays.read_parquet,
    b"\x89HDF\r\n\x1a\n": arrays.read_netcdf,
    b"CDF\x01": arrays.read_netcdf,
    b"CDF\x02": arrays.read_netcdf,
    b"CDF\x05": arrays.read_netcdf,
    b"\x28\xb5\x2f\xfd": _packed("zstd -d"),
    b"\x04\x22\x4d\x18": _packed("lz4 -d"),
}
"""By the first bytes of their files."""

BY_SUFFIX: dict[str, Reader] = {
    ".bag": rosbag.read_bag_of_ros1,
    ".db3": rosbag.read_bag_in_sqlite,
    ".parquet": arrays.read_parquet,
    ".pq": arrays.read_parquet,
    ".nc": arrays.read_netcdf,
    ".nc4": arrays.read_netcdf,
    ".h5": arrays.read_netcdf,
}
"""By how their files are named, where the first bytes are none of these: readers say what is wrong."""
