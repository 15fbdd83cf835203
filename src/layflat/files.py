"""Results reach their place whole or not at all: written under a temporary name beside it, then moved."""

import errno
import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from layflat.errors import LayflatError, OutputError

FULL = {errno.ENOSPC, errno.EFBIG, getattr(errno, "EDQUOT", errno.ENOSPC)}
"""The disk, the file or the user's share is at its limit."""

TRIAL = bytes(1 << 16)  # enough to see that nothing more can be written


@contextmanager
def whole_file(path: Path) -> Iterator[Path]:
    """Give a temporary path to write to; move it to `path` when the block ends well, remove it otherwise.

    Raises:
        OutputError: the folder can't be made or written, or the disk is full.
    """
    temporary: Path | None = None
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        handle, name = tempfile.mkstemp(prefix=f".{path.stem}-", suffix=path.suffix, dir=path.parent)
        temporary = Path(name)
        os.close(handle)
        yield temporary
        temporary.chmod(0o666 & ~_umask())
        temporary.replace(path)
    except LayflatError:
        raise
    except Exception as error:
        refused = _refusal(error, path, temporary)
        if refused is None:
            raise
        raise refused from error
    finally:
        if temporary is not None:
            temporary.unlink(missing_ok=True)


def write_text(path: Path, text: str) -> Path:
    """Write a text file, whole or not at all, and return its path.

    Raises:
        OutputError: as from `whole_file`.
    """
    with whole_file(path) as temporary:
        temporary.write_text(text, encoding="utf-8")
    return path


def _refusal(error: Exception, path: Path, temporary: Path | None) -> OutputError | None:
    """Why nothing could be written; None where it could, and something else is wrong.

    Libraries raise errors of their own on a full disk, without its number: writing a little more shows the cause.
    """
    cause = error if isinstance(error, OSError) and error.errno is not None else _trial(temporary)
    other = temporary is not None and cause is not None and cause.filename not in {None, str(temporary), str(path)}
    if cause is None or other:
        return None
    full = cause.errno in FULL
    right = "free some space, or give another folder" if full else "give a folder that you may write to"
    return OutputError(f"can't write here ({cause.strerror})", where=str(path), right=right)


def _trial(temporary: Path | None) -> OSError | None:
    """Return what forbids to write more, if anything does."""
    if temporary is None:
        return None
    try:
        with temporary.open("ab") as file:
            file.write(TRIAL)
            file.flush()
            os.fsync(file.fileno())
    except OSError as error:
        return error
    return None


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask


def check_file(path: Path) -> Path:
    """Make sure, before any work is done, that a result can be written there; raise OutputError if it can't."""
    if path.is_dir():
        raise OutputError("is a folder", where=str(path), right="give the name of a file in it")
    check_folder(path.parent)
    return path


def check_folder(folder: Path) -> Path:
    """Make sure, before any work is done, that results can be written to a folder; leave no trace of the trial.

    Raises:
        OutputError: they can't.
    """
    missing = [parent for parent in (folder, *folder.parents) if not parent.exists()]
    try:
        with whole_file(folder / ".layflat") as trial:
            trial.write_bytes(TRIAL)
        (folder / ".layflat").unlink(missing_ok=True)
    finally:
        for parent in missing:
            with suppress(OSError):  # it was never made, or somebody else writes here by now
                parent.rmdir()
    return folder
