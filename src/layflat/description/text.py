"""Files that people wrote, read so that none can hang or fill the memory."""

import stat
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from layflat.errors import InputError

MOST_BYTES = 4_000_000  # of a description: a hundred times as much as the longest one that is built in


@contextmanager
def told_as(kind: type[InputError]) -> Iterator[None]:
    """Turn errors of the input into those of a class below `InputError`."""
    try:
        yield
    except InputError as error:
        if isinstance(error, kind):
            raise
        raise kind(error.what, where=error.where, right=error.right) from None


def exists(path: Path) -> bool:
    """Tell whether there is something of a name, however odd the name."""
    with suppress(OSError, ValueError):
        return path.exists()
    return False


def is_file(path: Path) -> bool:
    """Return whether there is a file of a name, however odd or long the name."""
    with suppress(OSError, ValueError):
        return path.is_file()
    return False


def check_regular(path: Path, where: str, right: str, kind: type[InputError] = InputError) -> int:
    """Make sure that a file can be read to its end, and return its size in bytes.

    Raises:
        InputError: of class `kind`: there is none, or it is a folder, a pipe or a device.
    """
    try:
        status = path.stat()
    except OSError as error:
        raise kind(f"can't be read ({error.strerror or error})", where=where, right=right) from None
    except ValueError:  # a null character
        raise kind("is not the name of a file", where=repr(where), right=right) from None
    if stat.S_ISDIR(status.st_mode):
        raise kind("is a folder", where=where, right=right)
    if not stat.S_ISREG(status.st_mode):
        raise kind("is a pipe or a device, not a file", where=where, right=right)
    return status.st_size


def read_text(path: Path, where: str, right: str, kind: type[InputError] = InputError, most: int = MOST_BYTES) -> str:
    """Return the text of a file in UTF-8, without the byte order mark that some editors put in front.

    Args:
        path: of the file.
        where: how it is named in messages.
        right: what to give in place of a file that can't be read.
        kind: of error.
        most: bytes that it may have.

    Raises:
        InputError: of class `kind`: it can't be read, is not text, or is too large.
    """
    content = read_bytes(path, where, right, kind, most)
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError:
        raise kind("is not a text file in UTF-8", where=where, right=right) from None


def read_bytes(
    path: Path, where: str, right: str, kind: type[InputError] = InputError, most: int = MOST_BYTES
) -> bytes:
    """Return the bytes of a file; arguments as of `read_text`.

    Raises:
        InputError: of class `kind`: it can't be read, or is too large.
    """
    check_regular(path, where, right, kind)
    try:
        with path.open("rb") as file:
            content = file.read(most + 1)
    except OSError as error:
        raise kind(f"can't be read ({error.strerror or error})", where=where, right=right) from None
    if len(content) > most:
        raise kind(f"is larger than {most / 1e6:g} MB", where=where, right=right)
    return content
