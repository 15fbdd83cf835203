"""Results reach their place whole or not at all: written under a temporary name beside it, then moved."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from layflat.errors import OutputError


@contextmanager
def whole_file(path: Path) -> Iterator[Path]:
    """Give a temporary path to write to; move it to `path` when the block ends well, remove it otherwise.

    Raises:
        OutputError: the folder can't be made or written.
    """
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        handle, name = tempfile.mkstemp(prefix=f".{path.stem}-", suffix=path.suffix, dir=path.parent)
        os.close(handle)
    except OSError as error:
        raise OutputError(
            f"can't write here ({error.strerror})", where=str(path), right="give a folder that you may write to"
        ) from None
    temporary = Path(name)
    try:
        yield temporary
        temporary.chmod(0o666 & ~_umask())
        temporary.replace(path)
    finally:
        temporary.unlink(missing_ok=True)


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask


def check_folder(folder: Path) -> Path:
    """Make sure, before any work is done, that results can be written to a folder; leave no trace of the trial.

    Raises:
        OutputError: they can't.
    """
    missing = [parent for parent in (folder, *folder.parents) if not parent.exists()]
    with whole_file(folder / ".layflat"):
        pass
    (folder / ".layflat").unlink()
    for parent in missing:
        parent.rmdir()
    return folder
