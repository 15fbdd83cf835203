"""Readers of log files, by what a file begins with: names of files are often wrong."""

from collections.abc import Callable
from pathlib import Path

from layflat.errors import InputError
from layflat.identify.logs import arrays, bag, rosbag
from layflat.identify.logs.arrangement import arranged
from layflat.identify.logs.table import Content
from layflat.identify.logs.text import read_text

Reader = Callable[[Path], Content]


def read_content(path: Path, start: bytes, progress: Callable[[float], None] | None) -> Content:
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
