"""Reading of users' files, so that none can block the program or fill the memory."""

import stat
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from layflat.errors import InputError

MAX_BYTES = 4_000_000  # of a description: a hundred times the longest built-in one


@contextmanager
def errors_as(kind: type[InputError]) -> Iterator[None]:
    """Raise any InputError of the block as one of the subclass `kind`, with the same texts."""
    try:
        yield
    except InputError as error:
        if isinstance(error, kind):
            raise
        raise kind(error.what, where=error.where, right=error.right) from None


def exists(path: Path) -> bool:
    """Return whether a path exists; False where the system refuses its name, or access to its folder."""
    with suppress(OSError, ValueError):
        return path.exists()
    return False


def is_file(path: Path) -> bool:
    """Return whether a path is a file; False for names that the system refuses."""
    with suppress(OSError, ValueError):
        return path.is_file()
    return False


def check_regular(path: Path, where: str, right: str, kind: type[InputError] = InputError) -> int:
    """Check that a path is a regular file, and return its size in bytes.

    Args:
        path: path of the file.
        where: its name in messages.
        right: advice in messages.
        kind: class of the error.

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


def read_text(
    path: Path, where: str, right: str, kind: type[InputError] = InputError, max_bytes: int = MAX_BYTES
) -> str:
    """Return the text of a file in UTF-8, without a byte order mark.

    Args:
        path: path of the file.
        where: its name in messages.
        right: advice in messages, if it can't be read.
        kind: class of the error.
        max_bytes: greatest size of the file.

    Raises:
        InputError: of class `kind`: it can't be read, is not text, or is too large.
    """
    content = read_bytes(path, where, right, kind, max_bytes)
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError:
        raise kind("is not a text file in UTF-8", where=where, right=right) from None


def read_bytes(
    path: Path, where: str, right: str, kind: type[InputError] = InputError, max_bytes: int = MAX_BYTES
) -> bytes:
    """Return the bytes of a file.

    Args:
        path: path of the file.
        where: its name in messages.
        right: advice in messages, if it can't be read.
        kind: class of the error.
        max_bytes: greatest size of the file.

    Raises:
        InputError: of class `kind`: it can't be read, or is too large.
    """
    check_regular(path, where, right, kind)
    try:
        with path.open("rb") as file:
            content = file.read(max_bytes + 1)
    except OSError as error:
        raise kind(f"can't be read ({error.strerror or error})", where=where, right=right) from None
    if len(content) > max_bytes:
        raise kind(f"is larger than {max_bytes / 1e6:g} MB", where=where, right=right)
    return content
